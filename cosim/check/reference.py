"""Reference experiments: found in an FMU or a folder, and read.

Three layouts are known:

- FMI-LS-REF (https://github.com/modelica/fmi-ls-ref): fmi-ls-manifest.xml, which names files of experiments
  (https://github.com/modelica/ma-hs-experiments, with times in attributes of Experiment or of TransientSimulation);
- the same manifest with nothing but a result of the default experiment, as the Reference-FMUs have it;
- <model>_ref.csv or <model>_out.csv beside <model>_in.csv and <model>_ref.opt, as in the FMI cross-check.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from cosim.check.series import Series, read_series
from cosim.errors import InputError
from cosim.fmi2.xml_check import check_xml
from cosim.scenario.ssp.document import read_document
from cosim.scenario.ssp.parameter_set import Given, read_parameter_set
from cosim.scenario.ssp.vocabulary import ssv
from cosim.system.description import Description

PLACE = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "fmi-ls-manifest.xml"
ANNOTATION = "drillstring-cosim.tolerances"
"""Type of the annotation of References that holds a Tolerance element for each variable."""


@dataclass(frozen=True)
class Tolerance:
    """How far a variable may be from its reference, in its own unit, and why.

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
    pairs = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    try:
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
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {error.strerror}") from None
