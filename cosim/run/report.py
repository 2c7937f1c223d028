"""Report a run: how it was made and what came of it, typed here and written to manifest.json here alone.

The master tells of a run in plain numbers, `CouplingReport` names them. With what was run they make a `RunReport`, with
what was found a `VariantReport`, and those of a folder its `Manifest`.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields, replace
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from typing import Any, NotRequired, TypeVar, cast

from typing_extensions import TypedDict  # as pydantic wants it before Python 3.12

from cosim.drilling.reporting import Findings, find
from cosim.errors import OutputError
from cosim.files import read_file, replace_file, why
from cosim.provenance import commit, versions
from cosim.recording.result import Result
from cosim.scenario.scenario import Scenario

MANIFEST = "manifest.json"
FORMAT = "cosim-run-2"
_UNPROVEN = "cosim-run-1"
"""Format of manifests without a digest, of earlier versions."""
UNFINISHED = "unfinished"
"""State of a run that can be resumed."""
MOST_BYTES = 10**8
"""In a manifest."""
_DIGEST = "sha256"
"""Key of the digest of all other entries."""
_FILES = ("trajectory", "figure")
"""Keys of files in the entry of a variant."""
_OPTIONAL = {"optional": True}
"""The mark of a field that is left out where it does not apply."""


class Iterations(TypedDict):
    """Counts of how often the components of loops were stepped in a step."""

    mean: float
    most: int


class Unsolved(TypedDict):
    """Steps in which a loop had no solution: how many, the time of the first [s], the largest residual."""

    steps: int
    first: float | None
    largest_residual: float


class NotEstimated(TypedDict):
    """Name what an estimate says nothing of: discrete outputs that are passed on, components that pass nothing on."""

    discrete: list[str]
    components: list[str]


class StepErrors(TypedDict):
    """Errors of steps, relative to values and nominal values, and the number of steps that missed the tolerance.

    None where nothing that is passed on could be compared.
    """

    largest: float | None
    mean: float | None
    beyond_tolerance: int
    not_estimated: NotEstimated


class NotIterated(TypedDict):
    """Connection that was not iterated: its loop, if any, how far its ends lay apart at most, and when [s]."""

    loop: str | None
    largest_difference: float
    time: float | None


class EnergyResidual(TypedDict):
    """Energy that the coupling made at a power bond, the sum of its absolute values, and what was exchanged [J].

    `discrete` names values of the bond that jump, while the account takes them to go on straight lines.
    """

    sum: float
    absolute: float
    exchanged: float
    discrete: NotRequired[list[str]]


class GuardSpan(TypedDict):
    """Communication points at which a guard was on: their number, the first and the last [s]."""

    points: int
    first: float
    last: float


class Initialisation(TypedDict):
    """Exchange of values at the start: whether they settled, and after how many rounds."""

    settled: bool
    rounds: int


class Ended(TypedDict):
    """End that a component has asked for: which one, at what time [s], and why, as far as it has said."""

    component: str
    time: float
    reason: str


class Timings(TypedDict, total=False):
    """Wall-clock times of the parts of a run [s]."""

    load: float
    initialise: float
    step: float


@dataclass(frozen=True, kw_only=True)
class CouplingReport:
    """Account of the coupling by the master: how it was done, and how well; None where something does not apply.

    `order` is that of stepping, `connections` and `loops` are written with arrows, `steps` counts those that were kept,
    `conversions` tells what becomes of values by connection, where there is such.
    """

    algorithm: str
    order: list[str]
    connections: list[str]
    conversions: Mapping[str, Any] | None = field(default=None, metadata=_OPTIONAL)
    loops: list[str]
    start_time: float
    stop_time: float
    step_size: float
    method: Mapping[str, Any]
    initialisation: Initialisation
    steps: int
    ended: Ended | None = field(default=None, metadata=_OPTIONAL)
    step_loop: str
    rejected: int | None = field(default=None, metadata=_OPTIONAL)
    step_loop_reason: str | None = field(default=None, metadata=_OPTIONAL)
    iteration_tolerance: float | None = field(default=None, metadata=_OPTIONAL)
    on_failure: str | None = field(default=None, metadata=_OPTIONAL)
    iterations: Iterations | None = field(default=None, metadata=_OPTIONAL)
    unsolved: Unsolved | None = field(default=None, metadata=_OPTIONAL)
    not_iterated: Mapping[str, NotIterated] | None = field(default=None, metadata=_OPTIONAL)
    tolerance: float | None = field(default=None, metadata=_OPTIONAL)
    error_estimate: StepErrors | None = field(default=None, metadata=_OPTIONAL)
    energy_residual: Mapping[str, EnergyResidual]
    guards: Mapping[str, GuardSpan]
    timings: Timings

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> CouplingReport:
        """Read what a master, the record of a result or a manifest tells; other keys are left alone."""
        names = [each.name for each in fields(cls)]
        return cls(**{name: record[name] for name in names if name in record})

    def record(self) -> dict[str, Any]:
        """Return it by name, without what does not apply."""
        told = {each: getattr(self, each.name) for each in fields(self)}
        return {each.name: value for each, value in told.items() if value is not None or not each.metadata}


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """Account of one run: what was run, by which versions, and how it was coupled.

    Attributes
    ----------
    scenario, variant : str
        Their names; `variant` is None where there are none.
    packaging : str
        Which build of the FMUs.
    components : mapping
        By name: model, file, its hash, and every parameter.
    isolated : list of str
        Components that ran in processes of their own.
    inputs : mapping
        Signals, by the input they drive.
    versions : mapping of str to str
        Of what computed.
    coupling : CouplingReport
        What the master tells.
    """

    scenario: str
    variant: str | None
    packaging: str
    components: Mapping[str, Any]
    isolated: list[str]
    inputs: Mapping[str, Any]
    versions: Mapping[str, str]
    coupling: CouplingReport

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> RunReport:
        """Read the record of a result."""
        names = [each.name for each in fields(cls) if each.name != "coupling"]
        return cls(**{name: record[name] for name in names}, coupling=CouplingReport.from_record(record))

    def record(self) -> dict[str, Any]:
        """Return it as the record of a result: one mapping, by name."""
        told = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "coupling"}
        return {**told, **self.coupling.record()}


@dataclass(frozen=True)
class VariantReport:
    """One variant in a folder: its run, and what came of it.

    Attributes
    ----------
    run : RunReport
        How it was made.
    trajectory : str
        Where its rows are, within the folder.
    units : mapping of str to str
        Of the columns that were kept.
    types : mapping of str to str
        Types of these columns, as NumPy names them.
    findings : Findings
        Measures and energy.
    figure : str, optional
        Where its own figure is, within the folder; empty if it could not be drawn, and None if it has none of its own.
    """

    run: RunReport
    trajectory: str
    units: Mapping[str, str]
    types: Mapping[str, str]
    findings: Findings
    figure: str | None = None

    @property
    def label(self) -> str:
        """Name the variant, or the scenario if it has none."""
        return self.run.variant or self.run.scenario

    def to_json(self) -> dict[str, Any]:
        """Return the entry of a manifest, which tells scenario and versions once for all variants."""
        told = self.run.record()
        del told["scenario"], told["versions"]
        figure = {} if self.figure is None else {"figure": self.figure}
        columns = {"units": dict(self.units), "types": dict(self.types)}
        return {**told, "trajectory": self.trajectory, **columns, **self.findings.to_json(), **figure}

    @classmethod
    def from_json(cls, entry: Mapping[str, Any], head: Mapping[str, Any]) -> VariantReport:
        """Read an entry of a manifest, of which the head is given as well."""
        run = RunReport.from_record({**entry, "scenario": head["scenario"], "versions": head["versions"]})
        findings = Findings.from_json(entry)
        return cls(run, entry["trajectory"], entry["units"], entry.get("types", {}), findings, entry.get("figure"))

    @classmethod
    def of(cls, result: Result, trajectory: str, figure: str | None = None) -> VariantReport:
        """Report a result, whose rows are in a file or folder."""
        types = {name: result[name].dtype.name for name in result.names}
        made = RunReport.from_record(result.record)
        return cls(made, trajectory, dict(result.units), types, find(result), figure)


@dataclass(frozen=True)
class Manifest:
    """Account of a folder: what it holds, and how that was made.

    Attributes
    ----------
    scenario, title : str
        Name and title of the scenario.
    created : str
        When the run was begun, ISO 8601.
    versions : mapping of str to str
        Of what computed.
    commit : str, optional
        Of this package.
    variants : tuple of VariantReport
        Those that are complete.
    figure : str, optional
        The figure of all variants, within the folder.
    job : mapping, optional
        What is being run, if it is unfinished and can be resumed.
    """

    scenario: str
    title: str
    created: str
    versions: Mapping[str, str]
    commit: str | None
    variants: tuple[VariantReport, ...] = ()
    figure: str | None = None
    job: Mapping[str, Any] | None = None

    @classmethod
    def begun(cls, scenario: Scenario, job: Mapping[str, Any] | None = None) -> Manifest:
        """Begin one, now and by the present versions."""
        now = datetime.now(UTC).isoformat(timespec="seconds")
        return cls(scenario.name, scenario.title, now, versions(), commit(), job=job)

    @property
    def files(self) -> list[str]:
        """List all that was written, within the folder: trajectories, the manifest, and figures."""
        figures = [self.figure, *(each.figure for each in self.variants)]
        return [*(each.trajectory for each in self.variants), MANIFEST, *(name for name in figures if name)]

    def with_variant(self, variant: VariantReport) -> Manifest:
        """Return it with one more variant."""
        return replace(self, variants=(*self.variants, variant))

    def write(self, folder: Path) -> None:
        """Write it, which makes a folder a run."""
        told = {each: getattr(self, each) for each in ("scenario", "title", "created", "versions", "commit")}
        if self.figure is not None:
            told["figure"] = self.figure
        if self.job is not None:
            told |= {"state": UNFINISHED, "job": self.job}
        write_content(folder, {**told, "variants": [each.to_json() for each in self.variants]})

    @classmethod
    def read(cls, folder: Path) -> Manifest | None:
        """Return what `write` has written of an unfinished run; None if the folder holds none.

        Raises
        ------
        OutputError
            If there is a manifest that cannot be read, or is damaged.
        """
        content = read_content(folder)
        if content is None or content.get("state") != UNFINISHED:
            return None
        with undamaged(folder):
            variants = tuple(VariantReport.from_json(entry, content) for entry in content["variants"])
            head = {name: content[name] for name in ("scenario", "title", "created", "versions", "commit", "job")}
            return fitting(cls(**head, variants=variants))


@contextmanager
def undamaged(folder: Path) -> Generator[None]:
    """Say in a sentence that what a manifest tells is not as it was written."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else why(error)
        raise OutputError(f"output folder {folder}: {MANIFEST} is damaged: {what}") from error


Told = TypeVar("Told")


def fitting(told: Told) -> Told:
    """Return a dataclass that was read with its fields, and theirs, of the types they are declared to be.

    Raises
    ------
    ValueError
        If one cannot be; in one line.
    """
    from pydantic import TypeAdapter, ValidationError  # which takes a while to import

    adapter: TypeAdapter[Told] = TypeAdapter(type(told))
    try:
        return adapter.validate_python(asdict(cast(Any, told)))
    except ValidationError as error:
        first = error.errors(include_input=False, include_url=False)[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from None


def written_files(content: Mapping[str, Any]) -> set[str]:
    """Return what a manifest says was written, within its folder; whatever leads out of it is left alone."""
    told: list[Any] = content["variants"] if isinstance(content.get("variants"), list) else []
    entries = [cast(Mapping[str, Any], entry) for entry in told if isinstance(entry, dict)]
    names: list[object] = [content.get("figure"), *(entry.get(key) for entry in entries for key in _FILES)]
    found = [PurePosixPath(name) for name in names if isinstance(name, str) and name]
    return {MANIFEST, *(name.as_posix() for name in found if not name.is_absolute() and ".." not in name.parts)}


def was_streamed(content: Mapping[str, Any]) -> bool:
    """Tell from a manifest whether its run was streamed: such a run names a figure for each variant."""
    told: list[Any] = content["variants"] if isinstance(content.get("variants"), list) else []
    return any(isinstance(entry, dict) and "figure" in entry for entry in told)


def write_content(folder: Path, content: Mapping[str, Any]) -> None:
    """Write a manifest, with a digest of what it says, in one step; infinite numbers as ``"inf"``, which JSON lacks.

    Raises
    ------
    OutputError
        If it cannot be written; one that was there is left alone.
    """
    told = {"format": FORMAT, **plain(content)}
    text = json.dumps({**told, _DIGEST: _digest(told)}, indent=2, allow_nan=False)
    try:
        replace_file(folder / MANIFEST, f"{text}\n".encode())
    except OSError as error:
        raise OutputError(f"output folder {folder} cannot be written: {why(error)}") from error


def _digest(content: Mapping[str, Any]) -> str:
    """Return the digest of what a manifest says, however it is laid out."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def read_content(folder: Path) -> dict[str, Any] | None:
    """Return the manifest of a folder as it is; None if the folder is no run.

    Raises
    ------
    OutputError
        If there is a manifest that cannot be read, or does not say what was written.
    """
    try:
        content: object = json.loads(read_file(folder / MANIFEST, MOST_BYTES, follow=False).decode("utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError(f"output folder {folder} cannot be read: {why(error)}") from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"output folder {folder}: {MANIFEST} is not JSON: {why(error)}") from error
    if not isinstance(content, dict):
        return None
    manifest = cast(dict[str, Any], content)
    if manifest.get("format") not in (FORMAT, _UNPROVEN):
        return None
    digest = manifest.pop(_DIGEST, None)
    proven = digest is not None or manifest["format"] == FORMAT
    if proven and digest != _digest(manifest):
        raise OutputError(f"output folder {folder}: {MANIFEST} is damaged: it does not say what was written")
    return manifest


def plain(value: Any) -> Any:
    """Turn a value into what JSON knows; infinite numbers into ``"inf"``, since JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in cast(Mapping[Any, Any], value).items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in cast(list[Any], value)]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value
