"""Read and write parameter sets (.ssv), values by name with units, and bind them to variables."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import SspError, suggestion
from cosim.scenario.ssp.document import (
    MAPPING_TYPE,
    PARAMETER_SET_TYPE,
    SspSource,
    check_document,
    plain_name,
    read_document,
    ssc,
    ssd,
    ssm,
    ssv,
)
from cosim.system.description import (
    BASE_UNITS,
    Description,
    Match,
    Unit,
    Variable,
    compare,
    converted,
    describe,
)
from cosim.system.signals import Value

log = logging.getLogger("cosim")

_MOST_TOLD = 20
"""Values of a component that are ignored and named one by one."""


@dataclass(frozen=True)
class Given:
    """A value as a parameter set gives it; `unit` is what the set says it is in, if it does.

    Where the set contradicts itself, `fault` says so, to be told if anything takes the value.
    """

    value: Value
    unit: Unit | None = None
    fault: str = ""

    def for_variable(self, label: str, variable: Variable, told: set[str] | None = None) -> Value:
        """Return the value in the unit of a variable, by the rule of `cosim.system.description.compare`.

        Parameters
        ----------
        label : str
            Its full name, for messages.
        variable : Variable
            What the value is for.
        told : set of str, optional
            Units that have been warned of, which is done once for each.

        Raises
        ------
        SspError
            If the units cannot be converted into each other, or the value is not known for certain.
        """
        if self.fault:
            raise SspError(self.fault)
        source, target = self.unit, variable.measured_in
        if source is None or isinstance(self.value, bool | str):
            return self.value
        source = source.of_differences if variable.relative else source
        match = compare(source, target)
        if match is Match.DIFFERENT or (match is Match.UNKNOWN and target is not None):
            raise SspError(
                f"{label} is given in {describe(source)}; expected {describe(target)} or what can be converted into it"
            )
        told = set() if told is None else told
        if match in (Match.ASSUMED, Match.UNKNOWN) and source.name not in told:
            told.add(source.name)
            log.warning("%s is given in %s and taken as %s as it is", label, describe(source), describe(target))
        return converted(self.value, source, target)


SET_NAME = "start values"
"""The name of the parameter sets of all components: Ecos is told which sets to use by one name."""


def parameter_set(values: Mapping[str, Value], description: Description) -> Element:
    """Make a parameter set of values for an FMU.

    Parameters
    ----------
    values : mapping of str to value
        By variable, as `cosim.system.compatibility.start_values` returns them: enumeration items by number.
    description : Description
        Of the FMU.
    """
    root = Element(ssv("ParameterSet"), version="1.0", name=SET_NAME)
    parameters = SubElement(root, ssv("Parameters"))
    for variable, value in values.items():
        parameter = SubElement(parameters, ssv("Parameter"), name=variable)
        kind = description.by_name[variable]
        SubElement(parameter, ssv(kind.type), value=_text(kind, value))
    return root


def read_parameter_set(root: Element, where: str) -> dict[str, Given]:
    """Return the values of a parameter set by name; enumeration items by name.

    Parameters
    ----------
    root : Element
        ssv:ParameterSet, checked against the schema.
    where : str
        File it is from, for messages.

    Raises
    ------
    SspError
        If a value is binary. A name that is given twice is refused where a variable takes its value.
    """
    units = read_units(root.find(ssv("Units")))
    values: dict[str, Given] = {}
    for parameter in root.iterfind(f"{ssv('Parameters')}/{ssv('Parameter')}"):
        name = str(parameter.get("name"))
        given = _given(parameter[0], units, f"{where}: {name}")
        values[name] = (
            given if name not in values else replace(given, fault=f"{where}: {name} is given twice; expected once")
        )
    return values


def read_units(element: Element | None) -> dict[str, Unit]:
    """Return the units that a document defines in its element Units, if it has one, by name."""
    found = element.iterfind(ssc("Unit")) if element is not None else ()
    return {str(unit.get("name")): _unit(unit) for unit in found}


def _given(element: Element, units: Mapping[str, Unit], where: str) -> Given:
    """Read one value."""
    text = str(element.get("value"))
    match plain_name(element.tag):
        case "Real":
            unit = element.get("unit")
            return Given(float(text), units.get(unit, Unit(unit.strip("[] "))) if unit is not None else None)
        case "Integer":
            return Given(int(text))
        case "Boolean":
            return Given(_boolean(text))
        case "Binary":
            raise SspError(f"{where} is binary; expected a number, a Boolean, a string or an enumeration")
        case _:
            return Given(text)


def _text(variable: Variable, value: Value) -> str:
    """Write a value, numbers with as many digits as read back to the same bits."""
    if variable.type == "Enumeration":
        return next(name for name, number in variable.items.items() if number == value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def _unit(element: Element) -> Unit:
    """Read the definition of a unit."""
    base = element[0]
    powers = tuple(int(base.get(name, "0")) for name in BASE_UNITS)
    return Unit(str(element.get("name")), powers, float(base.get("factor", "1")), float(base.get("offset", "0")))


def read_bindings(archive: SspSource, element: Element, where: str) -> dict[str, Given]:
    """Read all parameter bindings of a component or system; later ones take priority (SSP 1.0, section 5.3.1).

    Parameters
    ----------
    archive : SspSource
        Where external parameter sets lie.
    element : Element
        ssd:Component or ssd:System.
    where : str
        File it is from, for messages.

    Returns
    -------
    dict of str to Given
        By name, prefix included.

    Raises
    ------
    SspError
        If a parameter set is missing or damaged, or a binding is of a kind that is not supported.
    """
    label = f"{where}: a parameter binding of {element.get('name')}"
    values: dict[str, Given] = {}
    for binding in element.iterfind(f"{ssd('ParameterBindings')}/{ssd('ParameterBinding')}"):
        if binding.get("type", PARAMETER_SET_TYPE) != PARAMETER_SET_TYPE:
            raise SspError(f"{label} has the type {binding.get('type')}; expected {PARAMETER_SET_TYPE}")
        if binding.get("sourceBase", "SSD") != "SSD":
            raise SspError(f"{label} has the sourceBase {binding.get('sourceBase')}; only SSD is supported")
        prefix = binding.get("prefix", "")
        found = _parameter_set(archive, binding, label)
        mapping = binding.find(ssd("ParameterMapping"))
        if mapping is not None:
            found = _mapped(found, _mapping(archive, mapping, label), label)
        for name, given in found.items():
            values[prefix + name] = given
    return values


def component_values(
    name: str, description: Description, bound: Mapping[str, Given], above: Mapping[str, Given], driven: Sequence[str]
) -> dict[str, Value]:
    """Return the start values of a component.

    Names that no variable has are ignored, as the standard wants it, with a warning; so are start values of inputs that
    a connection drives, since it brings their value at the start as well.

    Parameters
    ----------
    name : str
        Of the component.
    description : Description
        Of its FMU.
    bound : mapping of str to Given
        From its own bindings, by variable.
    above : mapping of str to Given
        From the bindings of the systems around it, by variable; these take precedence.
    driven : sequence of str
        Inputs, ``component.variable``, that connections drive.
    """
    prefix = f"{name}."
    values: dict[str, Value] = {}
    told: set[str] = set()
    ignored: list[str] = []
    inputs = {*driven}
    for variable, given in {**bound, **above}.items():
        label = prefix + variable
        if variable not in description.by_name:
            ignored.append(f"{label}: {description.model_name} has no variable of that name; its value is ignored")
        elif label in inputs:
            ignored.append(f"{label}: a connection drives this input; its start value is ignored")
        else:
            values[variable] = given.for_variable(label, description.by_name[variable], told)
    for sentence in ignored[:_MOST_TOLD]:
        log.warning("%s", sentence)
    if len(ignored) > _MOST_TOLD:
        log.warning("%s: %d more values are ignored", name, len(ignored) - _MOST_TOLD)
    return values


def _parameter_set(archive: SspSource, binding: Element, label: str) -> dict[str, Given]:
    """Read the parameter set of a binding, wherever it is."""
    source, inline = binding.get("source"), binding.find(ssd("ParameterValues"))
    if source is not None and inline is not None:
        raise SspError(f"{label} has both source and ParameterValues; expected one of them")
    if source is not None:
        name = archive.member(source, label.rpartition(": ")[2])
        where = f"{archive.path.name}: {PurePosixPath(name)}"
        return read_parameter_set(read_document(archive.read(name), where, ssv("ParameterSet")), where)
    if inline is None:
        raise SspError(f"{label} has neither source nor ParameterValues; expected one of them")
    content = list(inline)
    if len(content) != 1 or content[0].tag != ssv("ParameterSet"):
        found = ", ".join(plain_name(element.tag) for element in content) or "nothing"
        raise SspError(f"{label} holds {found}; expected one ParameterSet")
    check_document(content[0], label)
    return read_parameter_set(content[0], label)


def _mapping(archive: SspSource, element: Element, label: str) -> Element:
    """Read the parameter mapping of a binding, wherever it is."""
    if element.get("type", MAPPING_TYPE) != MAPPING_TYPE:
        raise SspError(f"{label} has a mapping of the type {element.get('type')}; expected {MAPPING_TYPE}")
    if element.get("sourceBase", "SSD") != "SSD":
        raise SspError(f"{label} has a mapping with the sourceBase {element.get('sourceBase')}; only SSD is supported")
    source = element.get("source")
    if source is not None:
        name = archive.member(source, f"the mapping of {label.rpartition(': ')[2]}")
        return read_document(archive.read(name), f"{archive.path.name}: {PurePosixPath(name)}", ssm("ParameterMapping"))
    content = list(element)
    if len(content) != 1 or content[0].tag != ssm("ParameterMapping"):
        raise SspError(f"{label} has a mapping with neither source nor ParameterMapping; expected one of them")
    check_document(content[0], label)
    return content[0]


def _mapped(values: Mapping[str, Given], mapping: Element, label: str) -> dict[str, Given]:
    """Apply a parameter mapping (SSP 1.0, chapter 8): by its entries alone values are given, under their targets.

    Entries for names that the parameter set does not hold give nothing, with one warning: tools write mappings for more
    than one set, and leave gaps.
    """
    mapped: dict[str, Given] = {}
    missing: list[str] = []
    for entry in mapping.iterfind(ssm("MappingEntry")):
        source, target = str(entry.get("source")), str(entry.get("target"))
        if source not in values:
            missing.append(source)
            continue
        given = values[source]
        for child in entry:
            if plain_name(child.tag) != "Annotations":
                given = replace(given, value=_transformed(given.value, child, f"{label}: {source}"))
        kept = entry.get("suppressUnitConversion") in ("true", "1")
        mapped[target] = replace(given, unit=None) if kept else given
    if missing:
        first = f"'{missing[0]}'" + (f" and {len(missing) - 1} more" if len(missing) > 1 else "")
        hint = suggestion(missing[0], values)
        log.warning("%s maps %s, which its parameter set does not hold; they give nothing%s", label, first, hint)
    return mapped


def _transformed(value: Value, transformation: Element, label: str) -> Value:
    """Apply a transformation to a value (SSP 1.0, section 4.5.4)."""
    kind = plain_name(transformation.tag)
    if kind == "LinearTransformation":
        if isinstance(value, bool | str):
            raise SspError(f"{label} is {value!r}; expected a number for a LinearTransformation")
        return float(transformation.get("factor", "1")) * value + float(transformation.get("offset", "0"))
    read = {"BooleanMappingTransformation": _boolean, "IntegerMappingTransformation": int}.get(kind, str)
    for entry in transformation:
        if read(str(entry.get("source"))) == value:
            return read(str(entry.get("target")))
    return value  # what a table does not list stays as it is (SSP 2.0, section 4.5.5)


def _boolean(text: str) -> bool:
    return text.strip() in ("true", "1")
