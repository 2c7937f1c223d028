"""An editable install, as the tests run in, takes no name but `cosim` in its environment."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def python(script: str, cwd: Path) -> str:
    return subprocess.run([sys.executable, "-c", script], cwd=cwd, capture_output=True, text=True, check=True).stdout


def test_another_project_keeps_its_package_of_that_name(tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "__init__.py").write_text('WHOSE = "another project\'s"\n', encoding="utf-8")
    script = "import models, cosim.models.parameters, cosim.drilling.energy_growth; print(models.WHOSE)"
    assert python(script, tmp_path) == "another project's\n"


def test_folders_of_the_checkout_are_no_names_elsewhere(tmp_path: Path) -> None:
    script = "from importlib.util import find_spec; print([find_spec(n) for n in ('models', 'fmu_src', 'build_fmu')])"
    assert python(script, tmp_path) == "[None, None, None]\n"
