"""Name what can go wrong, as exceptions whose text is one sentence for the user.

`InputError` and its kin mean that what was asked for cannot be done (exit code 2 on the command line); `RunError` and
its kin mean that something sensible was asked for and failed on the way (exit code 1).

A package that only a part of the work needs is imported when it begins, and named in a sentence if it is absent.
"""

from __future__ import annotations

import difflib
import importlib
import unicodedata
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any


class CosimError(Exception):
    """Base of every error this package raises on purpose."""

    exit_code = 1


class InputError(CosimError):
    """Refuse what was asked for: a name, a value, a file is wrong."""

    exit_code = 2


class SystemDefinitionError(InputError):
    """Components, connections, inputs or parameters that do not fit together."""


class ScenarioError(InputError):
    """A scenario that does not exist, cannot be read, or says something unknown."""


class SspError(InputError):
    """An .ssp file that cannot be read, or a system that cannot be written as one."""


class FmuFileError(InputError):
    """A file that is missing or is not an FMI 2.0 co-simulation FMU for this platform."""


class MissingPackageError(InputError):
    """A package that is not installed, and is needed for what was asked for only."""


class UnknownNameError(InputError, KeyError):
    """A name that nothing was recorded by; it is a KeyError, as of any mapping."""

    def __str__(self) -> str:
        """Return the sentence, which a KeyError would quote."""
        return Exception.__str__(self)


class OutputError(InputError):
    """A folder that results cannot be written to."""


class CheckpointError(InputError):
    """A run that cannot be resumed: its checkpoint is missing or damaged, or what it was made from has changed."""


class Refusals:
    """Collects what is wrong with a file or system, so that one run tells all of it."""

    def __init__(self) -> None:
        self.found: list[InputError] = []

    @contextmanager
    def noted(self) -> Generator[None]:
        """Go on after the block where it refuses something, which is noted."""
        try:
            yield
        except InputError as error:
            self.found.append(error)

    def raise_all(self, kind: type[InputError]) -> None:
        """Raise what was noted: one refusal as it is, several as one of a kind whose sentence numbers them."""
        sentences = list(dict.fromkeys(map(str, self.found)))
        if len(sentences) == 1:
            raise self.found[0]
        if sentences:
            numbered = "; ".join(f"({number}) {each}" for number, each in enumerate(sentences, 1))
            raise kind(f"{len(sentences)} things stop it: {numbered}") from self.found[0]


class RunError(CosimError):
    """A run that was started and could not be finished."""


_DISCARD = "fmi2Discard"


class SlaveError(RunError):
    """A call into an FMU that did not succeed.

    Attributes
    ----------
    component : str
        Name of the component.
    time : float
        Its communication point, s.
    function : str
        The FMI function, such as ``fmi2DoStep``.
    status : str
        What it returned, such as ``fmi2Discard``.
    message : str
        Why, as far as the FMU has said.
    """

    def __init__(self, component: str, time: float, function: str, status: str, message: str) -> None:
        self.component = component
        self.time = time
        self.function = function
        self.status = status
        self.message = message
        sentence = f"{component} at t = {format_time(time)} s: {function} returned {status}"
        super().__init__(f"{sentence}: {message}" if message else sentence)

    @property
    def discarded(self) -> bool:
        """Tell whether the component only refused this step or value, and may take another."""
        return self.status == _DISCARD


class EndRequestError(SlaveError):
    """A step that an FMU discarded because it wants to end the simulation: for the master a normal end, no failure.

    Attributes
    ----------
    end : float
        The last time up to which the FMU has computed, s.
    """

    def __init__(self, component: str, time: float, message: str, end: float) -> None:
        super().__init__(component, time, "fmi2DoStep", _DISCARD, message)
        self.end = end

    def __str__(self) -> str:
        sentence = f"{self.component} asked to end the simulation at t = {format_time(self.end)} s"
        return f"{sentence}: {self.message}" if self.message else sentence

    def record(self) -> dict[str, Any]:
        """Return what is to be told of the end of a run."""
        return {"component": self.component, "time": self.end, "reason": self.message}


class FunctionError(SlaveError):
    """A Python function in a run that raised something, or did not return what it is to give."""

    def __init__(self, component: str, time: float, function: str, message: str) -> None:
        super().__init__(component, time, function, "fmi2Error", message)

    def __str__(self) -> str:
        return f"{self.component} at t = {format_time(self.time)} s: {self.function} {self.message}"


class LostSlaveError(RunError):
    """An isolated FMU whose process is gone, because it crashed, ended or had to be stopped.

    Attributes
    ----------
    component : str
        Name of the component.
    time : float
        Its communication point, s.
    """

    def __init__(self, component: str, time: float, how: str) -> None:
        self.component = component
        self.time = time
        super().__init__(f"{component} at t = {format_time(time)} s: the FMU {how}")


class LoopError(RunError):
    """A loop between components in which no values agree.

    Attributes
    ----------
    time : float
        Communication point at which the step began, s.
    variables : tuple of str
        Along the loop, ``component.variable``.
    residual : float
        The least difference between a value that was tried and what came back, in the unit of the variable.
    trials : int
        How many values were tried.
    """

    def __init__(self, message: str, time: float, variables: tuple[str, ...], residual: float, trials: int) -> None:
        self.time = time
        self.variables = variables
        self.residual = residual
        self.trials = trials
        super().__init__(message)


class RunInterruptedError(KeyboardInterrupt):
    """A streamed run that was interrupted.

    Attributes
    ----------
    folder : Path
        Where its rows are: all of them, or those up to the last checkpoint at least if it had to end at once.
    time : float or None
        Which communication point was reached, s; None if it had to end at once.
    can_resume : bool
        Whether it can be resumed.
    """

    def __init__(self, folder: Path, time: float | None, *, can_resume: bool) -> None:
        self.folder, self.time, self.can_resume = folder, time, can_resume
        at = "at once" if time is None else f"at t = {format_time(time)} s"
        what = "what was stored by the last checkpoint" if time is None else "everything until then"
        super().__init__(f"interrupted {at}; {what} is in {folder}")


class SweepInterruptedError(KeyboardInterrupt):
    """A sweep that was interrupted; what is done is kept.

    Attributes
    ----------
    path : Path
        The store.
    done, points : int
        How many points are done, and how many there are.
    """

    def __init__(self, path: Path, done: int, points: int) -> None:
        self.path, self.done, self.points = path, done, points
        super().__init__(f"interrupted after {done} of {points} points, which are in {path}")


class TuningInterruptedError(KeyboardInterrupt):
    """A tuning that was interrupted.

    Attributes
    ----------
    folder : Path
        Where what was played is kept.
    runs : int
        How many runs that are.
    """

    def __init__(self, folder: Path, runs: int) -> None:
        self.folder, self.runs = folder, runs
        kept = f"{runs} runs are kept in {folder}"
        super().__init__(f"interrupted; {kept}, and the same command goes on from there")


def format_time(time: float) -> str:
    """Write a time in seconds with at least two decimals and no rounding noise."""
    short = f"{time:.2f}"
    return short if abs(float(short) - time) <= 1e-9 * max(1.0, abs(time)) else f"{time:.9g}"


_MOST_COMPARED, _LONGEST_COMPARED = 5000, 200


def printable(text: str) -> str:
    """Return a text with what a terminal or a reader would be led astray by written out.

    That is all but letters, marks, digits, punctuation, symbols, spaces and ends of lines: escape sequences, other
    control characters, C1 among them, and those that turn the direction of writing.
    """
    return "".join(map(_written_out, text)) if not text.isprintable() else text


def _written_out(each: str) -> str:
    """Write a character out, if need be."""
    harmless = each.isprintable() or each == "\n" or unicodedata.category(each) == "Zs"
    return each if harmless else each.encode("unicode_escape").decode()


def suggestion(name: str, known: Iterable[str]) -> str:
    """End a sentence about an unknown name with the nearest known one, or with all when they are few."""
    names = sorted(known)
    if len(names) > _MOST_COMPARED or len(name) > _LONGEST_COMPARED:
        return ""  # comparing takes time with their number, and with the square of their length
    near = difflib.get_close_matches(name, [each for each in names if len(each) <= _LONGEST_COMPARED], n=1, cutoff=0.6)
    if near:
        return f"; did you mean '{near[0]}'?"
    if 0 < len(names) <= 12:
        return f"; known: {', '.join(names)}"
    return ""


def require(module: str, *, extra: str, purpose: str) -> Any:
    """Return a module of a package that an extra of this one brings.

    Parameters
    ----------
    module : str
        Its full name, such as ``"fmu_manipulation_toolbox.container"``.
    extra : str
        Which of the extras in pyproject.toml has the package.
    purpose : str
        What needs it, as the beginning of a sentence, such as ``"writing Zarr"``.

    Raises
    ------
    MissingPackageError
        If the package, or one that it needs in turn, is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise _missing(error.name or module, extra, purpose) from error


def require_installed(*modules: str, extra: str, purpose: str) -> None:
    """Refuse at once, as `require` would, what needs packages later that are not installed; none is imported."""
    for module in modules:
        if find_spec(module) is None:
            raise _missing(module, extra, purpose)


def _missing(module: str, extra: str, purpose: str) -> MissingPackageError:
    package = module.partition(".")[0].replace("_", "-")
    how = f'pip install "drillstring-cosim[{extra}]" brings it'
    return MissingPackageError(f"{purpose} needs the package {package}; {how}")
