"""Systems as files that tools read: SSP 1.0 archives, and the OspSystemStructure.xml of libcosim."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from cosim.fmi2.model_description import read_description
from cosim.system.structure import System
from tests.importers.systems import Setting, fmu_of, settings

PARAMETER_SET = "start values"
"""Name of the parameter set of every component in an SSP archive."""

_SSP = {
    prefix: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for prefix, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
_OSP = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"


def write_ssp(system: System, path: Path) -> None:
    """Write an SSP archive with component-to-component connections and the FMUs in it; enumerations are left out."""
    for prefix, address in _SSP.items():
        ElementTree.register_namespace(prefix, address)
    root = Element(_ssp("ssd", "SystemStructureDescription"), version="1.0", name="system")
    whole = SubElement(root, _ssp("ssd", "System"), name="system")
    elements = SubElement(whole, _ssp("ssd", "Elements"))
    for part in system.components:
        source = f"resources/{fmu_of(system, part.name).name}"
        component = SubElement(elements, _ssp("ssd", "Component"), name=part.name, source=source)
        component.set("type", "application/x-fmu-sharedlibrary")
        _add_connectors(component, fmu_of(system, part.name))
        _add_parameters(component, [setting for setting in settings(system) if setting.component == part.name])
    connections = SubElement(whole, _ssp("ssd", "Connections"))
    for connection in system.connections:
        source, target = connection.source, connection.target
        ends = {"startElement": source.component, "startConnector": source.variable}
        ends |= {"endElement": target.component, "endConnector": target.variable}
        SubElement(connections, _ssp("ssd", "Connection"), ends)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("SystemStructure.ssd", ElementTree.tostring(root, "utf-8", xml_declaration=True))
        for file in {fmu_of(system, part.name) for part in system.components}:
            archive.write(file, f"resources/{file.name}")


def write_osp(system: System, step_size: float, folder: Path) -> Path:
    """Write OspSystemStructure.xml, which names the FMUs where they are; enumerations are left out."""
    ElementTree.register_namespace("", _OSP)
    root = Element(f"{{{_OSP}}}OspSystemStructure", version="0.1")
    for name, text in (("StartTime", "0.0"), ("BaseStepSize", repr(step_size)), ("Algorithm", "fixedStep")):
        SubElement(root, f"{{{_OSP}}}{name}").text = text
    simulators = SubElement(root, f"{{{_OSP}}}Simulators")
    for part in system.components:
        source = fmu_of(system, part.name).as_posix()
        simulator = SubElement(simulators, f"{{{_OSP}}}Simulator", name=part.name, source=source)
        values = SubElement(simulator, f"{{{_OSP}}}InitialValues")
        for setting in settings(system):
            if setting.component == part.name and setting.variable.type != "Enumeration":
                value = SubElement(values, f"{{{_OSP}}}InitialValue", variable=setting.variable.name)
                SubElement(value, f"{{{_OSP}}}{setting.variable.type}", value=_text(setting))
    connections = SubElement(root, f"{{{_OSP}}}Connections")
    for connection in system.connections:
        pair = SubElement(connections, f"{{{_OSP}}}VariableConnection")
        for port in (connection.source, connection.target):
            SubElement(pair, f"{{{_OSP}}}Variable", simulator=port.component, name=port.variable)
    path = folder / "OspSystemStructure.xml"
    path.write_bytes(ElementTree.tostring(root, "utf-8", xml_declaration=True))
    return path


def _add_connectors(component: Element, fmu: Path) -> None:
    """List inputs and outputs."""
    connectors = SubElement(component, _ssp("ssd", "Connectors"))
    for variable in read_description(fmu).variables:
        if variable.causality in ("input", "output"):
            connector = SubElement(connectors, _ssp("ssd", "Connector"), name=variable.name, kind=variable.causality)
            SubElement(connector, _ssp("ssc", variable.type))


def _add_parameters(component: Element, given: list[Setting]) -> None:
    """Write start values into the description itself."""
    if not given:
        return
    bindings = SubElement(component, _ssp("ssd", "ParameterBindings"))
    values = SubElement(SubElement(bindings, _ssp("ssd", "ParameterBinding")), _ssp("ssd", "ParameterValues"))
    parameter_set = SubElement(values, _ssp("ssv", "ParameterSet"), version="1.0", name=PARAMETER_SET)
    parameters = SubElement(parameter_set, _ssp("ssv", "Parameters"))
    for setting in given:
        if setting.variable.type != "Enumeration":
            parameter = SubElement(parameters, _ssp("ssv", "Parameter"), name=setting.variable.name)
            SubElement(parameter, _ssp("ssv", setting.variable.type), value=_text(setting))


def _ssp(prefix: str, name: str) -> str:
    return f"{{{_SSP[prefix]}}}{name}"


def _text(setting: Setting) -> str:
    return str(setting.value).lower() if isinstance(setting.value, bool) else str(setting.value)
