"""Find reference experiments in an FMU or a folder, and read them.

Three layouts are known:

- FMI-LS-REF (https://github.com/modelica/fmi-ls-ref): fmi-ls-manifest.xml, which names files of experiments
  (https://github.com/modelica/ma-hs-experiments, with times in attributes of Experiment or of TransientSimulation);
- the same manifest with nothing but a result of the default experiment, as the Reference-FMUs have it;
- <model>_ref.csv or <model>_out.csv beside <model>_in.csv and <model>_ref.opt, as in the FMI cross-check.

Time series are CSV files: a header, times in the first column, two rows at one time where something jumps.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from cosim.errors import InputError
from cosim.files import read_file, why
from cosim.fmi2.xml_check import check_xml
from cosim.scenario.ssp.document import read_document, ssv
from cosim.scenario.ssp.parameters import Given, read_parameter_set
from cosim.system.description import Description
from cosim.system.signals import FloatArray

PLACE = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "fmi-ls-manifest.xml"
SAME_TIME = 1e-9
"""Times nearer than this, relative to max(1, |t|), differ by rounding [s]."""
_MOST_BYTES = 2**30
_BOOLEANS = {"true": "1", "false": "0"}
ANNOTATION = "drillstring-cosim.tolerances"
"""Type of the annotation of References that holds a Tolerance element for each variable."""


@dataclass(frozen=True)
class Tolerance:
    """Allow a variable a distance from its reference, in its own unit, for a reason.

    Allowed is `absolute` + `relative` times the size of the reference, anywhere within `time` [s] of it.
    """

    reason: str
    absolute: float = 0.0
    relative: float = 0.0
    time: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """One run of an FMU and what should come of it; None leaves it to the FMU's default experiment.

    Attributes
    ----------
    start_time, stop_time, step_size : float, optional
        In s.
    parameters : mapping of str to Given
        Values, with units where the file says them.
    stimuli, references : Series, optional
        Inputs, and what is compared.
    tolerances : mapping of str to Tolerance
        For variables that have one.
    """

    name: str
    description: str = ""
    start_time: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    parameters: Mapping[str, Given] = field(default_factory=dict[str, Given])
    stimuli: Series | None = None
    references: Series | None = None
    tolerances: Mapping[str, Tolerance] = field(default_factory=dict[str, Tolerance])

    def with_numbers(self, description: Description) -> Experiment:
        """Return the experiment with numbers for the items of enumerations that its columns name."""
        stimuli = self.stimuli and self.stimuli.with_numbers(description)
        return replace(self, stimuli=stimuli, references=self.references and self.references.with_numbers(description))


def model_names(fmu: Path, description: Description) -> tuple[str, ...]:
    """Return the names that files about an FMU may begin with, the likeliest first."""
    return tuple(dict.fromkeys((fmu.stem, description.model_name, description.model_identifier)))


def holds_reference(folder: Path) -> bool:
    """Return whether an unpacked FMU holds reference experiments."""
    return (folder / PLACE / MANIFEST).is_file()


def read_reference(folder: Path, models: Sequence[str]) -> tuple[Experiment, ...]:
    """Read the reference experiments in a folder.

    Parameters
    ----------
    folder : Path
        That holds a manifest, or an unpacked FMU with one, or files named after the model.
    models : sequence of str
        Names the model goes by, the likeliest first.

    Raises
    ------
    InputError
        In one sentence: there are none, or they cannot be read.
    """
    for place in (folder, folder / PLACE):
        if (place / MANIFEST).is_file():
            return _Reader(folder.resolve()).by_manifest(place, models)
    for model in models:
        for name in (f"{model}_ref.csv", f"{model}_out.csv"):
            if (folder / name).is_file():
                return (_pair(folder / name, model),)
    expected = f"{MANIFEST}, {models[0]}_ref.csv or {models[0]}_out.csv"
    raise InputError(f"{folder}: there are no reference experiments; expected {expected}")


def _stem(path: Path, models: Sequence[str]) -> str:
    return next((path.stem.removesuffix(end) for end in ("_out", "_ref") if path.stem.endswith(end)), models[0])


def _pair(path: Path, model: str) -> Experiment:
    """Return the experiment of a result, and of the inputs and options beside it."""
    stimuli, options = path.with_name(f"{model}_in.csv"), path.with_name(f"{model}_ref.opt")
    numbers = _options(options) if options.is_file() else {}
    return Experiment(
        name=path.stem,
        description="default experiment",
        start_time=numbers.get("StartTime"),
        stop_time=numbers.get("StopTime"),
        step_size=numbers.get("StepSize") or None,
        stimuli=read_series(stimuli) if stimuli.is_file() else None,
        references=read_series(path),
    )


def _options(path: Path) -> dict[str, float]:
    """Read a file of the FMI cross-check: a name and a number on each line."""
    try:
        pairs = [line.split(",") for line in _content(path).decode("utf-8").splitlines()]
        return {pair[0].strip(): float(pair[1]) for pair in pairs if len(pair) == 2}
    except ValueError as error:
        raise InputError(f"{path.name}: {error}; expected a name and a number on each line") from None


class _Reader:
    """Reads files by FMI-LS-REF that lie in a folder or below.

    Parameters
    ----------
    root : Path
        The folder, without links; nothing outside it is read.
    """

    def __init__(self, root: Path) -> None:
        self._root = root

    def by_manifest(self, folder: Path, models: Sequence[str]) -> tuple[Experiment, ...]:
        """Read what a manifest names: files of experiments or, without any, results."""
        related = _parse(folder / MANIFEST).findall("Related")
        files = [each for each in related if (each.get("role") or "").split("/")[0] == "experiment"]
        found = [experiment for each in files for experiment in self._experiments(self._source(folder, each))]
        if found:
            return tuple(found)
        results = [self._source(folder, each) for each in related if each.get("role") == "result"]
        pairs = [_pair(path, _stem(path, models)) for path in results if path.suffix == ".csv" and path.is_file()]
        if not pairs:
            raise InputError(f"{MANIFEST} names neither experiments nor results that are there")
        return tuple(pairs)

    def _experiments(self, path: Path) -> list[Experiment]:
        return [self._experiment(path.parent, element) for element in _parse(path).findall("Experiment")]

    def _experiment(self, folder: Path, element: Element) -> Experiment:
        name = element.get("name") or "unnamed"
        transient = element.find("TransientSimulation")
        span = element if transient is None else transient
        parameters, stimuli, references = (element.find(tag) for tag in ("Parameters", "Stimuli", "References"))
        return Experiment(
            name=name,
            description=element.get("description") or "",
            start_time=_number(span, "startTime", name),
            stop_time=_number(span, "stopTime", name),
            step_size=_number(span, "stepSize", name),
            parameters={} if parameters is None else _parameters(self._source(folder, parameters)),
            stimuli=None if stimuli is None else self._series(folder, stimuli),
            references=None if references is None else self._series(folder, references),
            tolerances={} if references is None else _tolerances(references, name),
        )

    def _series(self, folder: Path, element: Element) -> Series:
        kind = element.get("type", "text/csv")
        if kind != "text/csv":
            raise InputError(f"{element.get('source')} is of type {kind}; expected text/csv")
        return read_series(self._source(folder, element))

    def _source(self, folder: Path, element: Element) -> Path:
        """Return the path a source names."""
        text = element.get("source") or ""
        source = urlsplit(text)
        path = folder / unquote(source.path)
        if source.scheme or source.netloc or not source.path or not path.resolve().is_relative_to(self._root):
            raise InputError(f"source '{text}' is not a relative path within {self._root.name}; nothing else is read")
        return path


def _parameters(path: Path) -> dict[str, Given]:
    """Read a parameter set of SSP."""
    return read_parameter_set(read_document(_content(path), path.name, ssv("ParameterSet")), path.name)


def _tolerances(references: Element, experiment: str) -> dict[str, Tolerance]:
    found: dict[str, Tolerance] = {}
    for annotation in references.findall("Annotations/Annotation"):
        if annotation.get("type") != ANNOTATION:
            continue
        for element in annotation.findall("Tolerance"):
            numbers = {name: _number(element, name, experiment) or 0.0 for name in ("absolute", "relative", "time")}
            found[element.get("variable") or ""] = Tolerance(element.get("reason") or "no reason given", **numbers)
    return found


def _number(element: Element, name: str, experiment: str) -> float | None:
    text = element.get(name)
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        raise InputError(f"experiment {experiment}: {name} is '{text}'; expected a number") from None


def _parse(path: Path) -> Element:
    content = _content(path)
    check_xml(content, path.name, InputError)
    return ElementTree.fromstring(content)


def _content(path: Path) -> bytes:
    try:
        return read_file(path, _MOST_BYTES)
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {why(error)}") from None


def same_time(one: float, other: float) -> bool:
    """Return whether two times [s] are the same but for rounding."""
    return abs(one - other) <= SAME_TIME * max(1.0, abs(one), abs(other))


@dataclass(frozen=True)
class Series:
    """Columns over times that do not fall.

    Attributes
    ----------
    path : Path
        The file, for messages.
    times : ndarray, shape (rows,)
        In s.
    texts : mapping of str to tuple of str
        The other columns as written.
    """

    path: Path
    times: FloatArray
    texts: Mapping[str, tuple[str, ...]]
    _numbers: dict[str, FloatArray] = field(default_factory=dict[str, FloatArray], init=False, repr=False)

    def with_numbers(self, description: Description) -> Series:
        """Return the series with numbers for the items of enumerations."""
        items = {name: description.by_name[name].items for name in self.texts if name in description.by_name}
        texts = {
            name: tuple(str(items.get(name, {}).get(text, text)) for text in column)
            for name, column in self.texts.items()
        }
        return Series(self.path, self.times, texts)

    def column(self, name: str) -> FloatArray:
        """Return a column as numbers, true and false as 1 and 0; InputError if one is none."""
        if name in self._numbers:
            return self._numbers[name]
        try:
            numbers = np.array([float(_BOOLEANS.get(text.lower(), text)) for text in self.texts[name]])
        except ValueError as error:
            raise InputError(f"{self.path.name}, column {name}: {error}; expected numbers") from None
        return self._numbers.setdefault(name, numbers)

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Times with two rows [s]."""
        doubled = self.times[1:][np.diff(self.times) == 0.0]
        return tuple(dict.fromkeys(doubled.tolist()))

    def after(self, time: float) -> tuple[int, int]:
        """Return the row that holds from a time on, and the next one; the same row twice at the end."""
        late = time + SAME_TIME * max(1.0, abs(time))
        row = max(int(np.searchsorted(self.times, late, side="right")) - 1, 0)
        return row, min(row + 1, len(self.times) - 1)

    def slope(self, name: str, time: float) -> float:
        """Return the slope of a column from a time on [1/s]."""
        row, following = self.after(time)
        span = self.times[following] - self.times[row]
        begins = time + SAME_TIME * max(1.0, abs(time)) >= self.times[row]
        values = self.column(name)
        return float((values[following] - values[row]) / span) if span > 0.0 and begins else 0.0

    def value(self, name: str, time: float, *, interpolate: bool) -> float:
        """Return a column's value from a time on: on the line between rows, or that of the row."""
        row, _ = self.after(time)
        value = float(self.column(name)[row])
        if not interpolate or time <= self.times[row]:
            return value
        return value + self.slope(name, time) * (time - float(self.times[row]))


def read_series(path: Path) -> Series:
    """Read a CSV file; InputError in one sentence if it is none, or its times fall."""
    try:
        text = io.StringIO(_content(path).decode("utf-8-sig"), newline="")
        rows = [row for row in csv.reader(text) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path.name} cannot be read: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{path.name} has {max(len(rows) - 1, 0)} rows below its header; expected at least one")
    header = [name.strip().strip('"') for name in rows[0]]
    short = next((number for number, row in enumerate(rows, start=1) if len(row) != len(header)), None)
    if short is not None:
        raise InputError(f"{path.name}, line {short}: expected {len(header)} fields, as in the header")
    columns = [tuple(text.strip() for text in column) for column in zip(*rows[1:], strict=True)]
    try:
        times = np.array([float(text) for text in columns[0]])
    except ValueError as error:
        raise InputError(f"{path.name}: {error} in the first column; expected times") from None
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        raise InputError(f"{path.name}: times in the first column are not finite, or fall")
    return Series(path, times, dict(zip(header[1:], columns[1:], strict=True)))
