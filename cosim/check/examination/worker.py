"""Run an FMU under test in this process: python -m cosim.check.examination.worker JOB.

It tells what it does in a file, line by line, so that the process that started it knows where it stopped, should the
FMU take it down.
"""

from __future__ import annotations

import json
import logging
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from cosim.check.examination.behaviour import CHECKS
from cosim.check.examination.bench import Bench
from cosim.check.examination.exercise import Plan
from cosim.check.examination.instance import CallError, CallTrace, Library
from cosim.check.examination.simulate import check_experiment
from cosim.check.reference import Experiment, model_names, read_reference
from cosim.check.verdict import Outcome, Verdict, failed, not_checked
from cosim.errors import FmuFileError, InputError
from cosim.fmi2.library import loaded_fmu
from cosim.fmi2.model_description import read_description
from cosim.system.description import Description

JOURNAL, TRACE = "journal.jsonl", "trace"
UNLOADING = "unloading"
"""The journal's entry after the last check, and before the end of the process."""

EXPERIMENT = "experiment:"
"""Prefix of the check that runs an experiment of the reference."""


@dataclass(frozen=True)
class CheckJob:
    """Set a worker its task.

    Attributes
    ----------
    fmu, folder : str
        The .fmu file; where the worker keeps its journal and what checks leave to each other.
    checks : list of str
        Names from `cosim.check.examination.behaviour.BEHAVIOUR`, or `EXPERIMENT` and the name of an experiment.
    reference : str, optional
        Folder with reference experiments.
    verdicts : dict of str to str
        Of checks that earlier workers have done.
    plan : dict, optional
        How far runs go, if an earlier worker has found out.
    """

    fmu: str
    folder: str
    checks: list[str]
    reference: str | None = None
    verdicts: dict[str, str] = field(default_factory=dict[str, str])
    plan: dict[str, Any] | None = None


class Progress:
    """Write down what the worker is about to do, one JSON object a line.

    Parameters
    ----------
    path : Path
        The file; lines are added.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("a", encoding="utf-8")

    def say(self, event: str, check: str, **more: Any) -> None:
        """Write a line at once."""
        self._file.write(json.dumps({"event": event, "check": check, **more}) + "\n")
        self._file.flush()


class CheckWorker:
    """Does the checks of a job, one after another.

    Parameters
    ----------
    job : CheckJob
        What to do.
    """

    def __init__(self, job: CheckJob) -> None:
        self._job = job
        self._folder = Path(job.folder)
        self._progress = Progress(self._folder / JOURNAL)
        self._verdicts = dict(job.verdicts)
        self._current = job.checks[0]

    def work(self) -> None:
        """Load the FMU and do the checks."""
        path = Path(self._job.fmu)
        checks = [name for name in self._job.checks if not self._skip(name)]
        if not checks:
            self._progress.say("begin", UNLOADING)
            return
        self._progress.say("begin", checks[0])
        try:
            description = read_description(path, validate=False)
            with loaded_fmu("checked", path, description) as loaded:
                library = Library(loaded, description, CallTrace(self._folder / TRACE))
                plan = Plan(**self._job.plan) if self._job.plan else Plan.of(description)
                bench = Bench(library, plan, self._experiments(description), self._folder, self._forgive)
                for name in checks:
                    self._check(name, bench)
                self._progress.say("begin", UNLOADING)
        except FmuFileError as error:
            self._end(checks[0], failed(str(error).removeprefix(f"{path}: "), "loaded"))
            for name in checks[1:]:
                self._end(name, not_checked(f"needs '{checks[0]}', which has not passed"))
            self._progress.say("begin", UNLOADING)

    def _forgive(self) -> None:
        self._progress.say("forgive", self._current)

    def _check(self, name: str, bench: Bench) -> None:
        self._current = name
        self._progress.say("begin", name)
        if not self._skip(name, final=True):
            began = time.monotonic()
            outcome = self._outcome(name, bench)
            self._end(name, outcome, time.monotonic() - began)

    def _end(self, name: str, outcome: Outcome, seconds: float = 0.0) -> None:
        self._verdicts[name] = outcome.verdict
        self._progress.say("end", name, seconds=seconds, **asdict(outcome))

    def _skip(self, name: str, *, final: bool = False) -> bool:
        """End a check that needs one which has not passed; before `final`, only where that is known already."""
        needs, spoilers = (CHECKS[name].needs, CHECKS[name].spoiled_by) if name in CHECKS else (("run",), ())
        verdicts = {each: self._verdicts.get(each) for each in (*needs, *spoilers) if final or each in self._verdicts}
        missed = [each for each in needs if each in verdicts and verdicts[each] not in (Verdict.PASSED, Verdict.NOTED)]
        missed += [each for each in spoilers if verdicts.get(each) == Verdict.FAILED]
        if missed:
            self._end(name, not_checked(f"needs '{missed[0]}', which has not passed"))
        return bool(missed)

    def _outcome(self, name: str, bench: Bench) -> Outcome:
        try:
            if name in CHECKS:
                return CHECKS[name].function(bench)
            return check_experiment(bench, name.removeprefix(EXPERIMENT))
        except CallError as error:
            return failed(str(error), "fmi2OK")
        except InputError as error:
            return failed(str(error))

    def _experiments(self, description: Description) -> tuple[Experiment, ...]:
        if self._job.reference is None:
            return ()
        read = read_reference(Path(self._job.reference), model_names(Path(self._job.fmu), description))
        return tuple(experiment.with_numbers(description) for experiment in read)


def main() -> None:
    """Do the job described in a file."""
    logging.getLogger("cosim").addHandler(logging.NullHandler())
    logging.getLogger("cosim").propagate = False
    CheckWorker(CheckJob(**json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))).work()


if __name__ == "__main__":
    main()
