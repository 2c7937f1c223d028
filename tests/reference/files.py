"""The files of reference experiments: FMI-LS-REF 1.0.0-alpha.1, and the Modelica Association's format for experiments.

Both are drafts: https://github.com/modelica/fmi-ls-ref and https://github.com/modelica/ma-hs-experiments. Neither says
how far a result may be off; that goes into an annotation of the references, which other tools pass over.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from itertools import pairwise
from textwrap import wrap
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from tests.reference.experiment import DOUBLE, Experiment, Points, Tolerance

MANIFEST = "fmi-ls-manifest.xml"
EXPERIMENTS = "experiments.exp"
NOTE = "fmi-ls-ref.txt"
TOLERANCES = "drillstring-cosim.tolerances"
"""Type of the annotation that holds one Tolerance element for each variable."""

_MANIFEST_SPACE = "http://fmi-standard.org/fmi-ls-manifest"
_PARAMETERS_SPACE = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


def reference_files(model: str, experiments: Sequence[Experiment]) -> dict[str, bytes]:
    """Return the files of a model's reference experiments by name, the answers computed anew."""
    files = {
        MANIFEST: _xml(_manifest(model, experiments)),
        EXPERIMENTS: _xml(_experiments(model, experiments)),
        NOTE: _note(model, experiments),
    }
    for experiment in experiments:
        if experiment.parameters:
            files[f"{experiment.name}.ssv"] = _xml(_parameters(experiment))
        if experiment.inputs:
            files[f"{experiment.name}_in.csv"] = _csv(_stimuli(experiment.inputs))
        times = experiment.times()
        answers = experiment.answer(times, experiment.step_size)
        columns = {"time": times, **{name: answers[name] for name in experiment.tolerances}}
        files[f"{experiment.name}_ref.csv"] = _csv(columns, experiment.digits)
    return files


def _manifest(model: str, experiments: Sequence[Experiment]) -> Element:
    ElementTree.register_namespace("fmi-ls", _MANIFEST_SPACE)
    root = Element("fmiReferences")
    root.set(f"{{{_MANIFEST_SPACE}}}fmi-ls-name", "org.fmi-standard.fmi-ls-ref")
    root.set(f"{{{_MANIFEST_SPACE}}}fmi-ls-version", "1.0.0-alpha.1")
    text = "Layered Standard providing information on related files included in an FMU."
    root.set(f"{{{_MANIFEST_SPACE}}}fmi-ls-description", text)
    _related(root, "application/x-ma-hs-experiments", EXPERIMENTS, "experiment/validation", f"Experiments on {model}")
    for experiment in experiments:
        name = experiment.name
        if experiment.parameters:
            _related(root, "application/x-ssp-parameter-set", f"{name}.ssv", "parameter", f"Parameters of {name}")
        if experiment.inputs:
            _related(root, "text/csv", f"{name}_in.csv", "testcase", f"Inputs of {name}")
        _related(root, "text/csv", f"{name}_ref.csv", "result", f"Reference results of {name}")
    _related(root, "text/plain", f"../../documentation/{NOTE}", "document", "What the experiments are, and tolerances")
    return root


def _related(root: Element, kind: str, source: str, role: str, description: str) -> None:
    SubElement(root, "Related", {"type": kind, "source": source, "role": role, "description": description})


def _experiments(model: str, experiments: Sequence[Experiment]) -> Element:
    root = Element("Experiments", {"name": model, "description": f"Reference experiments of {model}"})
    for experiment in experiments:
        element = SubElement(root, "Experiment", {"name": experiment.name, "description": experiment.description})
        span = {"startTime": 0.0, "stopTime": experiment.stop_time, "stepSize": experiment.step_size}
        SubElement(element, "TransientSimulation", {name: repr(value) for name, value in span.items()})
        if experiment.parameters:
            SubElement(element, "Parameters", {"source": f"{experiment.name}.ssv"})
        if experiment.inputs:
            SubElement(element, "Stimuli", {"source": f"{experiment.name}_in.csv"})
        references = SubElement(element, "References", {"source": f"{experiment.name}_ref.csv"})
        annotation = SubElement(SubElement(references, "Annotations"), "Annotation", {"type": TOLERANCES})
        for name, tolerance in experiment.tolerances.items():
            numbers = {"absolute": repr(tolerance.absolute), "relative": repr(tolerance.relative)}
            SubElement(annotation, "Tolerance", {"variable": name, **numbers, "reason": tolerance.reason})
    return root


def _parameters(experiment: Experiment) -> Element:
    ElementTree.register_namespace("ssv", _PARAMETERS_SPACE)
    root = Element(f"{{{_PARAMETERS_SPACE}}}ParameterSet", {"version": "1.0", "name": experiment.name})
    parameters = SubElement(root, f"{{{_PARAMETERS_SPACE}}}Parameters")
    for name, value in experiment.parameters.items():
        parameter = SubElement(parameters, f"{{{_PARAMETERS_SPACE}}}Parameter", {"name": name})
        kind = {str: "Enumeration", int: "Integer"}.get(type(value), "Real")
        text = value if isinstance(value, str) else repr(value)
        SubElement(parameter, f"{{{_PARAMETERS_SPACE}}}{kind}", {"value": text})
    return root


def _stimuli(inputs: Mapping[str, Points]) -> Mapping[str, np.ndarray]:
    """Put inputs on common times; where any of them jumps, all have two rows."""
    times = sorted({time for points in inputs.values() for time, _ in points})
    jumps = {before for points in inputs.values() for (before, _), (after, _) in pairwise(points) if before == after}
    rows = [(time, side) for time in times for side in (("left", "right") if time in jumps else ("left",))]
    table = {name: np.array([_value(points, *row) for row in rows]) for name, points in inputs.items()}
    return {"time": np.array([time for time, _ in rows]), **table}


def _value(points: Points, time: float, side: str) -> float:
    here = [value for at, value in points if at == time]
    if here:
        return here[0 if side == "left" else -1]
    at, values = zip(*points, strict=True)
    return float(np.interp(time, at, values))


def _csv(columns: Mapping[str, np.ndarray], digits: int = DOUBLE) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        writer.writerow(_number(value, digits) for value in row)
    return text.getvalue().encode("ascii")


def _number(value: float, digits: int) -> str:
    if isinstance(value, bool | int):
        return str(int(value))
    return repr(float(f"{value:.{digits}g}")).removesuffix(".0")


def _xml(root: Element) -> bytes:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _note(model: str, experiments: Sequence[Experiment]) -> bytes:
    """Say in words what the experiments are, where their results come from, and what is allowed."""
    lines = [f"Reference experiments of {model}", "", *wrap(_INTRODUCTION, 100), ""]
    for experiment in experiments:
        steps = f"{experiment.stop_time:g} s in steps of {experiment.step_size:g} s"
        lines += wrap(f"{experiment.name}: {experiment.description}; {steps}.", 100)
        if experiment.interpolated:
            lines += wrap(f"  {_INTERPOLATED}", 100, subsequent_indent="  ")
        lines.append("")
    lines += ["Allowed differences", ""]
    reasons = {name: tolerance for experiment in experiments for name, tolerance in experiment.tolerances.items()}
    for name, tolerance in reasons.items():
        lines += wrap(f"{name}: {_allowed(tolerance)}. {tolerance.reason[0].upper()}{tolerance.reason[1:]}.", 100)
    return ("\n".join(lines) + "\n").encode("utf-8")


def _allowed(tolerance: Tolerance) -> str:
    absolute, relative = tolerance.absolute, tolerance.relative
    if absolute == relative == 0.0:
        return "none"
    return f"{absolute:g}" + (f" and {relative:g} of the reference" if relative else "")


_INTRODUCTION = (
    "The results do not come from this FMU. Those of the plant come from an independent solution (a spectral method of "
    "steps, good to 1e-10 of each quantity's greatest value), those of laws and programs from closed forms in decimal "
    "arithmetic. They hold after initialisation (time 0) and at communication points, as the step that ends there "
    "leaves them: inputs that jump at such a time act from then on. All starts at time 0. Inputs follow straight lines "
    "between their points and jump where two points share a time."
)
_INTERPOLATED = (
    "Inputs have slopes: set value and first derivative before each step. An FMU without canInterpolateInputs cannot "
    "follow it in these steps."
)
