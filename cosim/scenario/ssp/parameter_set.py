"""Parameter sets (.ssv): values by name, with units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import SspError
from cosim.scenario.ssp.document import plain_name
from cosim.scenario.ssp.vocabulary import ssc, ssv
from cosim.system.description import Description, Unit, Variable
from cosim.system.signals import Value
from cosim.system.units import BASE_UNITS


@dataclass(frozen=True)
class Given:
    """A value as a parameter set gives it; `unit` is what the set says it is in, if it does."""

    value: Value
    unit: Unit | None = None

    def for_variable(self, label: str, variable: Variable) -> Value:
        """Return the value in the unit of a variable.

        Raises
        ------
        SspError
            If the units cannot be converted into each other.
        """
        source, target = self.unit, variable.unit
        if source is None or isinstance(self.value, bool | str) or source == target:
            return self.value
        if target is None or source.powers is None or source.powers != target.powers:
            wanted = target.name if target else "no unit"
            raise SspError(f"{label} is given in {source.name}; expected {wanted} or what can be converted into it")
        if (source.factor, source.offset) == (target.factor, target.offset):
            return self.value
        return (self.value * source.factor + source.offset - target.offset) / target.factor


SET_NAME = "start values"
"""Of the parameter sets of all components: Ecos is told which sets to use by one name."""


def parameter_set(values: Mapping[str, Value], description: Description) -> Element:
    """Make a parameter set of values for an FMU.

    Parameters
    ----------
    values : mapping of str to value
        By variable, as `cosim.system.parameters.start_values` returns them: enumeration items by number.
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
        If a value is binary, a name is given twice, or a unit is not defined.
    """
    units = read_units(root.find(ssv("Units")))
    values: dict[str, Given] = {}
    for parameter in root.iterfind(f"{ssv('Parameters')}/{ssv('Parameter')}"):
        name = str(parameter.get("name"))
        if name in values:
            raise SspError(f"{where}: {name} is given twice; expected once")
        values[name] = _given(parameter[0], units, f"{where}: {name}")
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
            if unit is not None and unit not in units:
                raise SspError(f"{where} is in the unit {unit}, which the parameter set does not define")
            return Given(float(text), units[unit] if unit is not None else None)
        case "Integer":
            return Given(int(text))
        case "Boolean":
            return Given(text.strip() in ("true", "1"))
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
