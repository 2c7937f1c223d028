"""Say in annotations what SSP has no word for: how a system is run and drawn, and which components are signals."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from typing import Any, cast
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import SspError, suggestion
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.document import SCENARIO_ANNOTATION, SIGNALS_ANNOTATION, own, plain_name, ssc, ssd
from cosim.system.method import Method
from cosim.system.structure import PowerBond


@dataclass(frozen=True)
class Remarks:
    """Hold what the annotation on a description says; None where it says nothing.

    Attributes
    ----------
    name, title, description : str or None
        Of the scenario.
    step_size : float or None
        Communication step size, s.
    method : Method
        Algorithm and its settings.
    signals : tuple of str
        What the figure shows.
    guards, power_bonds : tuple or None
        Of the system.
    """

    name: str | None = None
    title: str = ""
    description: str = ""
    step_size: float | None = None
    method: Method = field(default_factory=Method)
    signals: tuple[str, ...] = ()
    guards: tuple[str, ...] | None = None
    power_bonds: tuple[PowerBond, ...] | None = None


def add_scenario(parent: Element, scenario: Scenario) -> None:
    """Annotate a description with how its system is to be run."""
    annotation = SubElement(SubElement(parent, ssd("Annotations")), ssc("Annotation"), type=SCENARIO_ANNOTATION)
    texts = {"name": scenario.name, "title": scenario.title, "description": scenario.description}
    content = SubElement(annotation, own("Scenario"), texts, stepSize=repr(scenario.step_size))
    for setting in fields(Method):
        value = json.dumps(getattr(scenario.method, setting.name))
        SubElement(content, own("Method"), name=setting.name, value=value)
    system = scenario.system
    if system.guards is not None:
        SubElement(content, own("Guards"), names=json.dumps(system.guards))
    if system.power_bonds is not None:
        ends = [[bond.input, bond.output] for bond in system.power_bonds]
        SubElement(content, own("PowerBonds"), ends=json.dumps(ends))
    for signal in scenario.signals:
        SubElement(content, own("Signal"), name=signal)


def mark_as_signals(component: Element) -> None:
    """Annotate a component that stands for signals."""
    SubElement(SubElement(component, ssd("Annotations")), ssc("Annotation"), type=SIGNALS_ANNOTATION)


def stands_for_signals(component: Element) -> bool:
    """Tell whether a component carries the annotation."""
    return _annotation(component, SIGNALS_ANNOTATION) is not None


def read_remarks(description: Element, where: str) -> Remarks:
    """Read the annotation on a description, if there is one.

    Raises
    ------
    SspError
        If it says something that is not understood.
    InputError
        If it names an algorithm that does not exist.
    """
    annotation = _annotation(description, SCENARIO_ANNOTATION)
    if annotation is None:
        return Remarks()
    content = annotation.find(own("Scenario"))
    if content is None:
        raise SspError(f"{where}: the annotation {SCENARIO_ANNOTATION} holds no Scenario")
    return Remarks(
        content.get("name"),
        content.get("title", ""),
        content.get("description", ""),
        _step_size(content.get("stepSize"), where),
        _method(content, where),
        tuple(str(signal.get("name")) for signal in content.iterfind(own("Signal"))),
        _guards(content, where),
        _power_bonds(content, where),
    )


def _annotation(element: Element, kind: str) -> Element | None:
    """Find an annotation by type. The standard has `Annotations` in the namespace of the file, its items in ssc."""
    for child in element:
        if plain_name(child.tag) == "Annotations":
            return next((annotation for annotation in child if annotation.get("type") == kind), None)
    return None


def _step_size(text: str | None, where: str) -> float | None:
    """Read the step size."""
    try:
        return None if text is None else float(text)
    except ValueError:
        raise SspError(f"{where}: stepSize is '{text}'; expected a number") from None


def _guards(content: Element, where: str) -> tuple[str, ...] | None:
    """Read the names of guards."""
    element = content.find(own("Guards"))
    return None if element is None else tuple(map(str, _list(element.get("names", ""), f"{where}: guards")))


def _power_bonds(content: Element, where: str) -> tuple[PowerBond, ...] | None:
    """Read pairs of input and output."""
    element = content.find(own("PowerBonds"))
    if element is None:
        return None
    pairs = _list(element.get("ends", ""), f"{where}: power bonds")
    if not all(isinstance(pair, list) and len(cast(list[object], pair)) == 2 for pair in pairs):
        raise SspError(f"{where}: power bonds are {pairs}; expected pairs of an input and an output")
    return tuple(PowerBond(*map(str, cast(list[object], pair))) for pair in pairs)


def _list(text: str, what: str) -> list[object]:
    """Read a list."""
    try:
        value: object = json.loads(text)
    except ValueError:
        value = None
    if not isinstance(value, list):
        raise SspError(f"{what} are '{text}'; expected a list in JSON")
    return cast(list[object], value)


def _method(content: Element, where: str) -> Method:
    """Read algorithm and settings."""
    known = {setting.name for setting in fields(Method)}
    settings: dict[str, Any] = {}
    for setting in content.iterfind(own("Method")):
        name = setting.get("name", "")
        if name not in known:
            raise SspError(f"{where}: the method has no setting '{name}'{suggestion(name, known)}")
        settings[name] = _setting(name, setting.get("value", ""), where)
    return Method(**settings)


def _setting(name: str, text: str, where: str) -> object:
    """Read one setting, of the type that it has in `Method`."""
    try:
        value: object = json.loads(text)
    except ValueError:
        raise SspError(f"{where}: the method's {name} is '{text}', which is not JSON") from None
    usual = getattr(Method(), name)
    if isinstance(usual, tuple):
        expected, items = "a list of strings", cast(list[object], value) if isinstance(value, list) else [None]
        fits = all(isinstance(item, str) for item in items)
        value = tuple(items)
    elif isinstance(usual, bool | str):
        expected, fits = "true or false" if isinstance(usual, bool) else "a string", type(value) is type(usual)
    else:
        expected = "a number"
        fits = type(value) in (int, float) or (value is None and usual is None)
    if not fits:
        raise SspError(f"{where}: the method's {name} is {text}; expected {expected}")
    return value
