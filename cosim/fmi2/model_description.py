"""The part of modelDescription.xml that the master needs; the only place where fmpy's object model is read."""

from __future__ import annotations

import re
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import cast

import fmpy.model_description as fmpy_md  # pyright: ignore[reportMissingTypeStubs]

from cosim.errors import FmuFileError
from cosim.fmi2.archive import open_archive
from cosim.fmi2.xml_check import check_xml
from cosim.system.description import Description, Unit, Variable, VariableType

_FILE = "modelDescription.xml"


def read_description(path: Path, *, validate: bool = True) -> Description:
    """Read the model description of an FMU without unpacking it.

    Parameters
    ----------
    path : Path
        The .fmu file.
    validate : bool
        Refuse what breaks the schema; without, it is read as far as it can be understood.

    Raises
    ------
    FmuFileError
        If the file is missing, is not a zip archive that can safely be opened, has no valid modelDescription.xml, or is
        not an FMU for co-simulation by FMI 2.0.
    """
    content = _checked_content(path)
    try:
        with tempfile.TemporaryDirectory(prefix="cosim-") as folder:
            Path(folder, _FILE).write_bytes(content)
            read = fmpy_md.read_model_description(folder, validate=validate)  # pyright: ignore[reportUnknownMemberType]
    except fmpy_md.ValidationError as error:
        problems = "; ".join(str(problem) for problem in cast(list[object], error.problems))
        raise FmuFileError(f"{path}: modelDescription.xml is not valid: {problems}") from error
    except Exception as error:  # fmpy raises bare Exception for whatever its own checks find
        raise FmuFileError(f"{path}: modelDescription.xml cannot be used: {error}") from error
    slave = read.coSimulation
    if slave is None:
        raise FmuFileError(f"{path} is an FMU for model exchange only; expected one for co-simulation")
    _refuse_ambiguous_names(path, read)
    units = {str(unit.name): _unit(unit) for unit in read.unitDefinitions}
    start_time, stop_time, step_size = _default_experiment(read.defaultExperiment)
    return Description(
        model_name=str(read.modelName),
        model_identifier=str(slave.modelIdentifier),
        guid=str(read.guid),
        variables=tuple(_variable(variable, units) for variable in read.modelVariables),
        can_vary_step=slave.canHandleVariableCommunicationStepSize,
        can_interpolate_inputs=slave.canInterpolateInputs,
        once_per_process=slave.canBeInstantiatedOnlyOncePerProcess,
        can_save_state=slave.canGetAndSetFMUstate,
        can_serialize_state=slave.canSerializeFMUstate,
        output_derivative_order=int(slave.maxOutputDerivativeOrder),
        provides_directional_derivative=slave.providesDirectionalDerivative,
        log_categories=tuple(str(category.name) for category in read.logCategories),
        start_time=start_time,
        stop_time=stop_time,
        step_size=step_size,
        feedthrough=_feedthrough(read.outputs),
        initial_feedthrough=_feedthrough(read.initialUnknowns),
    )


def _checked_content(path: Path) -> bytes:
    """Return modelDescription.xml, refusing what fmpy must not see and what is not of FMI 2.0."""
    with open_archive(path) as archive:
        if _FILE not in archive.names:
            raise FmuFileError(f"{path} is not an FMU: there is no {_FILE} in it")
        content = archive.read(_FILE)
    version = check_xml(content, f"{path}: {_FILE}", FmuFileError).attributes.get("fmiVersion")
    if version != "2.0":
        raise FmuFileError(f"{path}: FMI version is {version or 'not given'}; expected 2.0")
    return content


def _refuse_ambiguous_names(path: Path, read: fmpy_md.ModelDescription) -> None:
    """Refuse names that mean two variables, and a model identifier that could lead to a file elsewhere.

    The identifier is to be a name in C (FMI 2.0, section 4.3.1); tools have put points and hyphens into it as well.
    """
    identifier = str(read.coSimulation.modelIdentifier) if read.coSimulation else ""
    if not re.fullmatch(r"\w[\w.-]*", identifier):
        raise FmuFileError(f"{path}: modelIdentifier is {identifier!r}; expected a name of letters, digits and _")
    counts = Counter(str(variable.name) for variable in read.modelVariables)
    name, count = counts.most_common(1)[0] if counts else ("", 0)
    if count > 1:
        raise FmuFileError(f"{path}: {count} variables are named '{name}'; expected each name once")


def _default_experiment(experiment: fmpy_md.DefaultExperiment | None) -> tuple[float | None, ...]:
    """Return start time, stop time and step size [s], as far as they are given."""
    texts = [getattr(experiment, name, None) for name in ("startTime", "stopTime", "stepSize")]
    return tuple(None if text is None else float(text) for text in texts)


def _feedthrough(unknowns: list[fmpy_md.Unknown]) -> dict[str, frozenset[str]]:
    """Read which inputs the unknowns of a model structure depend on, where the file says it."""
    known: dict[str, frozenset[str]] = {}
    for unknown in unknowns:
        if unknown.variable is not None and unknown.dependencies is not None:
            inputs = (str(variable.name) for variable in unknown.dependencies if variable.causality == "input")
            known[str(unknown.variable.name)] = frozenset(inputs)
    return known


def _unit(unit: fmpy_md.Unit) -> Unit:
    """Convert a unit."""
    base = unit.baseUnit
    if base is None:
        return Unit(str(unit.name))
    powers = (base.kg, base.m, base.s, base.A, base.K, base.mol, base.cd, base.rad)
    return Unit(str(unit.name), powers, base.factor, base.offset)


def _variable(variable: fmpy_md.ModelVariable, units: Mapping[str, Unit]) -> Variable:
    """Convert a variable; what it leaves out, its declared type may give."""
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared else None)
    minimum = variable.min or (declared.min if declared else None)
    maximum = variable.max or (declared.max if declared else None)
    nominal = variable.nominal or (declared.nominal if declared else None)
    items = {str(item.name): int(str(item.value)) for item in declared.items} if declared else {}
    return Variable(
        name=str(variable.name),
        reference=int(variable.valueReference),
        type=cast(VariableType, variable.type),
        causality=str(variable.causality),
        variability=str(variable.variability),
        initial=variable.initial,
        unit=units.get(unit, Unit(unit)) if unit else None,
        start=variable.start,
        minimum=float(minimum) if minimum is not None else None,
        maximum=float(maximum) if maximum is not None else None,
        nominal=abs(float(nominal or 1.0)) or 1.0,
        items=items,
        description=str(variable.description or ""),
    )
