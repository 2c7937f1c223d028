"""The part of modelDescription.xml that the master needs; the only place where fmpy's object model is read."""

from __future__ import annotations

import re
import tempfile
from collections import Counter
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import cast
from xml.etree import ElementTree

import fmpy.model_description as fmpy_md  # pyright: ignore[reportMissingTypeStubs]

from cosim.errors import FmuFileError
from cosim.fmi2.archive import open_archive
from cosim.fmi2.xml_check import check_xml, in_utf8
from cosim.system.description import Description, Unit, Variable, VariableType

_FILE = "modelDescription.xml"
_RELATIVE = "relativeQuantity"


def read_description(path: Path, *, validate: bool = True) -> Description:
    """Read the model description of an FMU without unpacking it, as far as it can be understood.

    A third of the FMUs that other tools have published break a rule that running does not need. What the description
    breaks of the schema and of fmpy's rules is in `Description.flaws`; `cosim check` fails it.

    Parameters
    ----------
    path : Path
        The .fmu file.
    validate : bool
        Refuse what breaks the schema; without, it is read as far as it can be understood, and no flaw is looked for.

    Raises
    ------
    FmuFileError
        If the file is missing, is not a zip archive that can safely be opened, has no modelDescription.xml that can be
        used, or is not an FMU for co-simulation by FMI 2.0.
    """
    try:
        status = path.stat()
    except OSError:
        return _description(path, validate)  # which says why
    stamp = (status.st_ino, status.st_dev, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
    return _known_description(path, validate, stamp)


@lru_cache(maxsize=64)
def _known_description(path: Path, validate: bool, stamp: tuple[int, ...]) -> Description:
    """Read the model description of a file that is as it was at a stamp, once."""
    del stamp
    return _description(path, validate)


def _description(path: Path, validate: bool) -> Description:
    """Read the model description of an FMU."""
    content, encoding, archive_flaws = _checked_content(path)
    read, flaws = _read(path, content, validate)
    slave = read.coSimulation
    if slave is None:
        raise FmuFileError(f"{path} is an FMU for model exchange only; expected one for co-simulation")
    _refuse_ambiguous_names(path, read)
    units = {str(unit.name): _unit(unit) for unit in read.unitDefinitions}
    differences = _differences(content)
    start_time, stop_time, step_size, tolerance = _default_experiment(path, read.defaultExperiment)
    return Description(
        model_name=str(read.modelName),
        model_identifier=str(slave.modelIdentifier),
        guid=str(read.guid),
        variables=tuple(_variable(path, variable, units, differences) for variable in read.modelVariables),
        can_vary_step=slave.canHandleVariableCommunicationStepSize,
        can_interpolate_inputs=slave.canInterpolateInputs,
        once_per_process=slave.canBeInstantiatedOnlyOncePerProcess,
        can_save_state=slave.canGetAndSetFMUstate,
        can_serialize_state=slave.canSerializeFMUstate,
        output_derivative_order=int(slave.maxOutputDerivativeOrder),
        provides_directional_derivative=slave.providesDirectionalDerivative,
        log_categories=tuple(str(category.name) for category in read.logCategories),
        generation_tool=str(read.generationTool or ""),
        start_time=start_time,
        stop_time=stop_time,
        step_size=step_size,
        tolerance=tolerance,
        feedthrough=_feedthrough(read.outputs),
        initial_feedthrough=_feedthrough(read.initialUnknowns),
        flaws=((encoding,) if encoding else ()) + flaws,
        archive_flaws=archive_flaws,
    )


def _read(path: Path, content: bytes, validate: bool) -> tuple[fmpy_md.ModelDescription, tuple[str, ...]]:
    """Have fmpy read a model description; return it with the rules it breaks, but none that its schema states."""
    flaws: tuple[str, ...] = ()
    with tempfile.TemporaryDirectory(prefix="cosim-") as folder:
        Path(folder, _FILE).write_bytes(content)
        try:
            try:
                read = fmpy_md.read_model_description(folder, validate=validate)  # pyright: ignore[reportUnknownMemberType]
            except (fmpy_md.ValidationError, KeyError) as error:
                flaws = _flaws(path, error)
                read = fmpy_md.read_model_description(folder, validate=False)  # pyright: ignore[reportUnknownMemberType]
        except FmuFileError:
            raise
        except Exception as error:  # fmpy raises bare Exception for whatever its own checks find
            raise FmuFileError(f"{path}: {_FILE} cannot be used: {error}") from error
    return read, flaws


def _flaws(path: Path, error: fmpy_md.ValidationError | KeyError) -> tuple[str, ...]:
    """Return which of fmpy's rules a model description breaks; FmuFileError if it breaks the schema."""
    if isinstance(error, KeyError):  # of fmpy 0.3.32, where a variable has a display unit and its unit is not defined
        return (f"unit {error} is not defined",)
    flaws = tuple(" ".join(str(flaw).split()).rstrip(".") for flaw in cast(list[object], error.problems))
    if any(flaw.startswith("ERROR") for flaw in flaws):  # what lxml says of a schema
        raise FmuFileError(f"{path}: {_FILE} is not valid: {'; '.join(flaws)}")
    return flaws


def _checked_content(path: Path) -> tuple[bytes, str | None, tuple[str, ...]]:
    """Return modelDescription.xml in UTF-8, what its encoding was, and flaws of the archive.

    What fmpy must not see, and what is not of FMI 2.0, is refused.
    """
    with open_archive(path) as archive:
        if _FILE not in archive.names:
            raise FmuFileError(f"{path} is not an FMU: there is no {_FILE} in it")
        content, encoding = in_utf8(archive.read(_FILE))
        flaws = archive.flaws
    version = check_xml(content, f"{path}: {_FILE}", FmuFileError).attributes.get("fmiVersion")
    if version != "2.0":
        raise FmuFileError(f"{path}: FMI version is {version or 'not given'}; expected 2.0")
    return content, encoding, flaws


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


def _default_experiment(path: Path, experiment: fmpy_md.DefaultExperiment | None) -> tuple[float | None, ...]:
    """Return start time, stop time and step size [s], and the tolerance, as far as they are given."""
    names = ("startTime", "stopTime", "stepSize", "tolerance")
    return tuple(_number(path, f"{name} of the default experiment", getattr(experiment, name, None)) for name in names)


def _number(path: Path, what: str, text: str | None) -> float | None:
    """Read a number of the file; XML Schema's words for infinity are Python's too."""
    try:
        return None if text is None else float(text)
    except ValueError:
        raise FmuFileError(f"{path}: {what} is '{text}'; expected a number") from None


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


def _differences(content: bytes) -> dict[str, bool]:
    """Read which variables say themselves whether they are differences; fmpy 0.3.32 reads it of types only."""
    if _RELATIVE.encode() not in content:
        return {}
    found = ElementTree.fromstring(content).iterfind("ModelVariables/ScalarVariable")
    given = {str(variable.get("name")): real.get(_RELATIVE) for variable in found for real in variable.iterfind("Real")}
    return {name: text.strip() in ("true", "1") for name, text in given.items() if text is not None}


def _variable(
    path: Path, variable: fmpy_md.ModelVariable, units: Mapping[str, Unit], differences: Mapping[str, bool]
) -> Variable:
    """Convert a variable; what it leaves out, its declared type may give.

    Only Real variables are continuous (FMI 2.0, section 2.2.7), whatever the file says or leaves out.
    """
    name, declared = str(variable.name), variable.declaredType
    unit = variable.unit or (declared.unit if declared else None)
    minimum = variable.min or (declared.min if declared else None)
    maximum = variable.max or (declared.max if declared else None)
    nominal = variable.nominal or (declared.nominal if declared else None)
    items = {str(item.name): int(str(item.value)) for item in declared.items} if declared else {}
    variability = str(variable.variability)
    if variable.type != "Real" and variability == "continuous":
        variability = "discrete"
    relative = differences.get(name, declared.relativeQuantity if declared else False)
    _refuse_start(path, name, variable)
    return Variable(
        name=name,
        reference=int(variable.valueReference),
        type=cast(VariableType, variable.type),
        causality=str(variable.causality),
        variability=variability,
        initial=variable.initial,
        unit=units.get(unit, Unit(unit)) if unit else None,
        start=variable.start,
        minimum=_number(path, f"min of {name}", minimum),
        maximum=_number(path, f"max of {name}", maximum),
        nominal=abs(_number(path, f"nominal of {name}", nominal) or 1.0) or 1.0,
        items=items,
        description=str(variable.description or ""),
        relative=bool(relative),
    )


def _refuse_start(path: Path, name: str, variable: fmpy_md.ModelVariable) -> None:
    """Refuse a start value that is none of the variable's type."""
    start = variable.start
    expected = {
        "Real": (r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?INF|NaN", "a number"),
        "Integer": (r"[+-]?\d+", "an integer"),
        "Enumeration": (r"[+-]?\d+", "the number of an item"),
        "Boolean": (r"true|false|0|1", "true or false"),
    }
    pattern, what = expected.get(str(variable.type), (r"(?s).*", "text"))
    if start is not None and not re.fullmatch(pattern, start.strip() if variable.type != "String" else start):
        raise FmuFileError(f"{path}: start of {name} is '{start}'; expected {what}")
