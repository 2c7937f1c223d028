"""modelDescription.xml of an FMU, made from its interface table (FMI 2.0.4, section 2.2 and 4.3.1)."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from .. import project
from ..rows import UNITS
from ..schema import Model, Packaging, Unit, Value, Variable


def model_description(model: Model, packaging: Packaging, guid: str) -> bytes:
    """Return modelDescription.xml of a model, the same bytes for the same arguments.

    Parameters
    ----------
    model : Model
        The interface table.
    packaging : Packaging
        Decides the capability flags, which say what the binary of that packaging can do.
    guid : str
        Identifies the content of the FMU.
    """
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": model.name,
            "guid": guid,
            "description": model.description,
            "author": project.AUTHOR,
            "version": project.version(),
            "copyright": f"Copyright (c) {project.AUTHOR}",
            "license": project.LICENSE,
            "generationTool": f"{project.NAME} {project.version()}",
            "variableNamingConvention": "flat",
        },
    )
    simulation = SubElement(root, "CoSimulation", _capabilities(model, packaging))
    if packaging is Packaging.NATIVE:
        SubElement(SubElement(simulation, "SourceFiles"), "File", {"name": f"{model.name}.c"})
    _add_units(root, model)
    _add_types(root, model)
    categories = SubElement(root, "LogCategories")
    for name, text in model.log_categories:
        SubElement(categories, "Category", {"name": name, "description": text})
    experiment = {"startTime": "0.0", "stopTime": repr(model.stop_time), "stepSize": repr(model.step_size)}
    SubElement(root, "DefaultExperiment", experiment)
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.variables):
        _add_variable(variables, variable, reference)
    _add_structure(root, model)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _capabilities(model: Model, packaging: Packaging) -> dict[str, str]:
    native = packaging is Packaging.NATIVE
    flags: dict[str, bool | int] = {
        "needsExecutionTool": not native,
        "canHandleVariableCommunicationStepSize": True,
        # pythonfmu answers all calls for derivatives with fmi2Error
        "canInterpolateInputs": native and model.has_real_inputs,
        "maxOutputDerivativeOrder": int(native),
        "canRunAsynchronuously": False,
        "canBeInstantiatedOnlyOncePerProcess": False,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": native and model.has_real_inputs,
    }
    return {"modelIdentifier": model.name} | {name: str(flag).lower() for name, flag in flags.items()}


def _add_units(root: Element, model: Model) -> None:
    wanted = {variable.unit for variable in model.variables}
    used = [unit for unit in UNITS if unit.name in wanted]
    missing = wanted - {unit.name for unit in used} - {None}
    if missing:
        raise ValueError(f"{model.name}: no unit definition for {', '.join(sorted(map(str, missing)))}")
    if used:
        definitions = SubElement(root, "UnitDefinitions")
        for unit in used:
            _add_unit(definitions, unit)


def _add_unit(definitions: Element, unit: Unit) -> None:
    element = SubElement(definitions, "Unit", {"name": unit.name})
    exponents = {"kg": unit.kg, "m": unit.m, "s": unit.s, "rad": unit.rad}
    SubElement(element, "BaseUnit", {base: str(exponent) for base, exponent in exponents.items() if exponent})
    for display in unit.display:
        SubElement(element, "DisplayUnit", {"name": display.name, "factor": repr(display.factor)})


def _type_name(variable: Variable) -> str:
    return f"{variable.name}_choice"


def _add_types(root: Element, model: Model) -> None:
    enumerations = [variable for variable in model.variables if variable.kind == "Enumeration"]
    if not enumerations:
        return
    definitions = SubElement(root, "TypeDefinitions")
    for variable in enumerations:
        simple = SubElement(definitions, "SimpleType", {"name": _type_name(variable)})
        enumeration = SubElement(simple, "Enumeration")
        for value, item in enumerate(variable.items, start=1):
            SubElement(enumeration, "Item", {"name": item, "value": str(value)})


def _add_variable(variables: Element, variable: Variable, reference: int) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.causality != "input":  # the standard forbids initial on inputs
        attributes["initial"] = "calculated" if variable.causality == "output" else "exact"
    scalar = SubElement(variables, "ScalarVariable", attributes)
    SubElement(scalar, variable.kind, _value_attributes(variable))


def _value_attributes(variable: Variable) -> dict[str, str]:
    attributes: dict[str, str] = {}
    limits: dict[str, float | None] = {"min": variable.minimum, "max": variable.maximum}
    if variable.kind == "Enumeration":
        attributes["declaredType"] = _type_name(variable)
        limits["min"], limits["max"] = variable.bounds
    if variable.kind == "Real":
        for name, text in (("unit", variable.unit), ("displayUnit", variable.display)):
            if text is not None:
                attributes[name] = text
        limits["nominal"] = variable.nominal
    for name, limit in (limits | {"start": variable.start}).items():
        if limit is not None:
            attributes[name] = xml_value(variable, limit)
    return attributes


def xml_value(variable: Variable, value: Value) -> str:
    """Return a value of a variable as XML writes it; a Real as the shortest text that reads back as the same bits."""
    match variable.kind:
        case "Real":
            return repr(float(value))
        case "Integer" | "Enumeration":
            return str(int(value))
        case "Boolean":
            return "true" if value else "false"
        case "String":
            return str(value)


def _add_structure(root: Element, model: Model) -> None:
    structure = SubElement(root, "ModelStructure")
    outputs = model.select("output")
    if not outputs:
        return
    for name, field in (("Outputs", "dependencies"), ("InitialUnknowns", "initial_dependencies")):
        unknowns = SubElement(structure, name)
        for output in outputs:
            needed: tuple[str, ...] = getattr(output, field)
            indices = sorted(model.value_reference(need) + 1 for need in needed)
            attributes = {
                "index": str(model.value_reference(output.name) + 1),
                "dependencies": " ".join(map(str, indices)),
            }
            SubElement(unknowns, "Unknown", attributes)
