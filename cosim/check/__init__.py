"""Judge whether an FMU is what it says it is: by its file, its description, its behaviour, its reference results.

>>> from pathlib import Path
>>> from cosim.check import check_fmu
>>> report = check_fmu(Path("dist/native/DrillstringNeutral.fmu"))
>>> report.passed
True
"""

from cosim.check.checking import TIME_LIMIT, check_fmu
from cosim.check.verdict import Comparison, Finding, Group, Report, Verdict

__all__ = [
    "TIME_LIMIT",
    "Comparison",
    "Finding",
    "Group",
    "Report",
    "Verdict",
    "check_fmu",
]
