"""What SSP has no word for, as annotations: how a system is run and drawn, and which components stand for signals."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from typing import Any, cast
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import SspError, suggestion
from cosim.method import Method
from cosim.scenario import Scenario
from cosim.ssp.document import plain_name
from cosim.ssp.vocabulary import SCENARIO_ANNOTATION, SIGNALS_ANNOTATION, own, ssc, ssd


@dataclass(frozen=True)
class Remarks:
    """What the annotation on a description says; None where it says nothing.

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
    """

    name: str | None = None
    title: str = ""
    description: str = ""
    step_size: float | None = None
    method: Method = field(default_factory=Method)
    signals: tuple[str, ...] = ()


def add_scenario(parent: Element, scenario: Scenario) -> None:
    """Annotate a description with how its system is to be run."""
    annotation = SubElement(SubElement(parent, ssd("Annotations")), ssc("Annotation"), type=SCENARIO_ANNOTATION)
    texts = {"name": scenario.name, "title": scenario.title, "description": scenario.description}
    content = SubElement(annotation, own("Scenario"), texts, stepSize=repr(scenario.step_size))
    for setting in fields(Method):
        value = json.dumps(getattr(scenario.method, setting.name))
        SubElement(content, own("Method"), name=setting.name, value=value)
    for signal in scenario.signals:
        SubElement(content, own("Signal"), name=signal)


def mark_as_signals(component: Element) -> None:
    """Annotate a component that stands for signals."""
    SubElement(SubElement(component, ssd("Annotations")), ssc("Annotation"), type=SIGNALS_ANNOTATION)


def stands_for_signals(component: Element) -> bool:
    """Whether a component carries the annotation."""
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


def _method(content: Element, where: str) -> Method:
    """Read algorithm and settings."""
    known = {setting.name for setting in fields(Method)}
    settings: dict[str, Any] = {}
    for setting in content.iterfind(own("Method")):
        name, text = setting.get("name", ""), setting.get("value", "")
        if name not in known:
            raise SspError(f"{where}: the method has no setting '{name}'{suggestion(name, known)}")
        try:
            value: object = json.loads(text)
        except ValueError:
            raise SspError(f"{where}: the method's {name} is '{text}', which is not JSON") from None
        settings[name] = tuple(cast(list[object], value)) if isinstance(value, list) else value
    return Method(**settings)
