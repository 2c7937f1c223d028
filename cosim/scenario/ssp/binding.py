"""Parameter bindings: which values a description gives to which variables."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element

from cosim.errors import SspError
from cosim.scenario.ssp.archive import SspArchive
from cosim.scenario.ssp.document import check_document, plain_name, read_document
from cosim.scenario.ssp.parameter_set import Given, read_parameter_set
from cosim.scenario.ssp.vocabulary import PARAMETER_SET_TYPE, ssd, ssv
from cosim.system.description import Description
from cosim.system.signals import Value

log = logging.getLogger("cosim")


def read_bindings(archive: SspArchive, element: Element, where: str) -> dict[str, Given]:
    """Read all parameter bindings of a component or system; later ones take priority (SSP 1.0, section 5.3.1).

    Parameters
    ----------
    archive : SspArchive
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
        if binding.find(ssd("ParameterMapping")) is not None:
            raise SspError(f"{label} has a ParameterMapping, which is not supported")
        prefix = binding.get("prefix", "")
        for name, given in _parameter_set(archive, binding, label).items():
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
        From the system's bindings, by ``component.variable``; these take precedence.
    driven : sequence of str
        Inputs, ``component.variable``, that connections drive.
    """
    prefix = f"{name}."
    inherited = {key.removeprefix(prefix): given for key, given in above.items() if key.startswith(prefix)}
    values: dict[str, Value] = {}
    for variable, given in {**bound, **inherited}.items():
        label = prefix + variable
        if variable not in description.by_name:
            log.warning("%s: %s has no variable of that name; its value is ignored", label, description.model_name)
        elif label in driven:
            log.warning("%s: a connection drives this input; its start value is ignored", label)
        else:
            values[variable] = given.for_variable(label, description.by_name[variable])
    return values


def _parameter_set(archive: SspArchive, binding: Element, label: str) -> dict[str, Given]:
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
