"""Check an FMU from the archive to its reference results."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from cosim.check import file
from cosim.check.examination.behaviour import BEHAVIOUR, CHECKS
from cosim.check.examination.process import CheckEnd, Told, run_in_turn
from cosim.check.examination.worker import EXPERIMENT, UNLOADING, CheckJob
from cosim.check.reference import Experiment, holds_reference, model_names, read_reference
from cosim.check.verdict import Comparison, Finding, Group, Outcome, Report, Verdict, counted, failed, not_checked
from cosim.errors import FmuFileError, InputError
from cosim.fmi2.model_description import read_description
from cosim.system.description import Description

TIME_LIMIT = 60.0
"""Wall time a check may take unless said otherwise [s]."""


def check_fmu(
    path: Path, reference: Path | None = None, *, time_limit: float = TIME_LIMIT, tell: Told = lambda name: None
) -> Report:
    """Check an FMU: the file, its description, what it does, and its reference experiments.

    Parameters
    ----------
    path : Path
        The .fmu file.
    reference : Path, optional
        Folder with reference experiments, instead of those in the FMU.
    time_limit : float
        Wall time each check may take [s]; then the FMU is taken to hang.
    tell : callable
        Told the name of each check as it begins.

    Returns
    -------
    Report
        Whatever is wrong with the FMU is in it and raises nothing.

    Raises
    ------
    InputError
        If there is no such file, or `reference` holds no experiments.
    """
    if not path.is_file():
        raise FmuFileError(f"{path}: there is no such file")
    with tempfile.TemporaryDirectory(prefix="cosim-check-", ignore_cleanup_errors=True) as folder:
        return _Checking(path, reference, Path(folder), time_limit, tell).report()


class _Checking:
    """The findings about one FMU as they come."""

    def __init__(self, path: Path, reference: Path | None, folder: Path, time_limit: float, tell: Told) -> None:
        self._path, self._reference, self._folder = path, reference, folder
        self._unpacked = folder / "fmu"
        self._time_limit, self._tell = time_limit, tell
        self._findings: list[Finding] = []
        self._comparisons: list[Comparison] = []
        self._title = path.name

    def report(self) -> Report:
        """Do everything that can be done."""
        description = self._file_and_description()
        if description is None:
            for group in (Group.BEHAVIOUR, Group.REFERENCE):
                self._add(group, "all checks", "run the FMU", not_checked("it cannot be run here, see above"))
        else:
            self._behaviour_and_reference(description)
        return Report(self._path, self._title, tuple(self._findings), tuple(self._comparisons))

    def _do(self, group: Group, name: str, done: str, check: Callable[[], Outcome]) -> bool:
        """Do a check at once; return whether it did not fail."""
        self._tell(name)
        began = time.monotonic()
        outcome = check()
        self._add(group, name, done, outcome, time.monotonic() - began)
        return outcome.verdict is not Verdict.FAILED

    def _add(self, group: Group, name: str, done: str, outcome: Outcome, seconds: float = 0.0) -> None:
        done = outcome.done or done
        self._findings.append(Finding(group, name, done, outcome.found, outcome.allowed, outcome.verdict, seconds))

    def _file_and_description(self) -> Description | None:
        """Check what can be seen without running; return the description if the FMU can be run by it."""
        path, unpacked = self._path, self._unpacked
        unpacked.mkdir()
        self._do(Group.FILE, "archive", "unpack every file", partial(file.check_archive, path, unpacked))
        archive = self._findings[-1]
        if archive.verdict is Verdict.FAILED and archive.allowed != file.PLAIN_NAMES:
            return None
        try:
            read = file.read_document(unpacked)
        except FmuFileError as error:
            self._add(Group.DESCRIPTION, "XML", "read it", failed(str(error), "XML in UTF-8"))
            return None
        self._do(Group.DESCRIPTION, "encoding", "compare with UTF-8", partial(file.check_encoding, read))
        if not self._do(Group.DESCRIPTION, "kind", "read version and kind", partial(file.check_kind, read)):
            return None
        valid = self._do(Group.DESCRIPTION, "schema", "validate by FMI's .xsd", partial(file.check_schema, read))
        rules = partial(file.check_rules, unpacked) if valid else lambda: not_checked("the schema is broken")
        self._do(Group.DESCRIPTION, "rules", "apply fmpy's rules", rules)
        try:
            description = read_description(path, validate=False)
        except FmuFileError as error:
            reason = str(error).removeprefix(f"{path}: ")
            self._add(Group.DESCRIPTION, "variables", "read them", failed(reason, "readable"))
            return None
        return self._described(description, file.declared_sources(read))

    def _described(self, description: Description, sources: tuple[str, ...]) -> Description | None:
        unpacked, do = self._unpacked, self._do
        self._title = _title(description)
        do(Group.DESCRIPTION, "start values", "compare with min and max", partial(file.check_bounds, description))
        do(Group.DESCRIPTION, "aliases", "compare units, start values", partial(file.check_aliases, description))
        do(Group.DESCRIPTION, "units", "of inputs and outputs", partial(file.check_units, description))
        do(Group.FILE, "sources", "look for declared files", partial(file.check_sources, unpacked, sources))
        do(Group.FILE, "documentation", "look for index.html", partial(file.check_documentation, unpacked))
        binaries = partial(file.check_binaries, self._path, unpacked, description)
        do(Group.FILE, "libraries", "read their headers", binaries)
        return description if file.has_sound_library(self._path, unpacked, description) else None

    def _behaviour_and_reference(self, description: Description) -> None:
        experiments, folder = self._experiments(description)
        names = [*CHECKS, *(EXPERIMENT + experiment.name for experiment in experiments)]
        job = CheckJob(str(self._path), str(self._folder), names, None if folder is None else str(folder))
        ended = {each.name: each for each in run_in_turn(job, self._time_limit, self._tell_plainly)}
        if UNLOADING in ended:
            self._add(Group.BEHAVIOUR, UNLOADING, "unload the library, end the process", ended[UNLOADING].outcome)
        for check in BEHAVIOUR:
            each = ended[check.name]
            self._add(Group.BEHAVIOUR, check.name, check.done, each.outcome, each.seconds)
        for experiment in experiments:
            self._add_experiment(experiment, ended[EXPERIMENT + experiment.name])

    def _tell_plainly(self, name: str) -> None:
        self._tell(name.removeprefix(EXPERIMENT))

    def _experiments(self, description: Description) -> tuple[tuple[Experiment, ...], Path | None]:
        """Return the reference experiments and their folder; what is wrong with those in the FMU is a finding."""
        models = model_names(self._path, description)
        if self._reference is not None:
            if not self._reference.is_dir():
                raise InputError(f"{self._reference}: there is no such folder")
            return read_reference(self._reference, models), self._reference.resolve()
        looked = "look for them in the FMU"
        try:
            if holds_reference(self._unpacked):
                return read_reference(self._unpacked, models), self._unpacked
            self._add(Group.REFERENCE, "experiments", looked, not_checked("there are none; --reference can give some"))
        except InputError as error:
            self._add(Group.REFERENCE, "experiments", looked, failed(str(error), "readable"))
        return (), None

    def _add_experiment(self, experiment: Experiment, ended: CheckEnd) -> None:
        self._add(Group.REFERENCE, experiment.name, experiment.description, ended.outcome, ended.seconds)
        self._comparisons += [Comparison(**each) for each in ended.outcome.data or ()]


def _title(description: Description) -> str:
    causalities = ("input", "output", "parameter")
    variables = ", ".join(counted(len(description.with_causality(each)), each) for each in causalities)
    return f"{description.model_name}, FMI 2.0 for co-simulation: {variables}"
