"""Say how an FMU looks in a tool and which of its signals belong together: model.png and the folder terminalsAndIcons/.

FMI 2.0.4, section 2.3, takes terminals and icons over from FMI 3.0, section 2.4.9. The pictures are drawn as SVG, that
of an FMU in its folder, those of terminals in icons/; the PNG files beside them are made from these
(``python -m tests.fmu_src.draw``) and kept, since programs that draw pixels do not agree to the byte.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from .. import project
from ..schema import Model, Terminal

FOLDER = "terminalsAndIcons"
_EXTENT = 100
_SIZE = 20  # of a terminal, in the units of the coordinate system


def appearance(model: Model) -> dict[str, bytes]:
    """Return the pictures of a model and the description of its terminals, by path inside the FMU."""
    image, drawing = _picture(project.icon(model.name))
    files = {"model.png": image, f"{FOLDER}/icon.png": image, f"{FOLDER}/icon.svg": drawing}
    if model.terminals:
        files[f"{FOLDER}/terminalsAndIcons.xml"] = _description(model)
    for terminal in model.terminals:
        image, drawing = _picture(project.ICONS / f"{terminal.name}.svg")
        files |= {f"{FOLDER}/{terminal.name}.png": image, f"{FOLDER}/{terminal.name}.svg": drawing}
    return files


def _picture(path: Path) -> tuple[bytes, bytes]:
    # the drawing is read as text, so that line ends are the same on every platform
    return path.with_suffix(".png").read_bytes(), path.read_text(encoding="utf-8").encode("utf-8")


def _description(model: Model) -> bytes:
    """Return terminalsAndIcons.xml: what flows out is on the right, what flows in on the left."""
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    graphics = SubElement(root, "GraphicalRepresentation")
    extent = _box(-_EXTENT, -_EXTENT, _EXTENT, _EXTENT)
    SubElement(graphics, "CoordinateSystem", extent | {"suggestedScalingFactorTo_mm": "0.1"})
    SubElement(graphics, "Icon", extent)
    terminals = SubElement(root, "Terminals")
    sides: dict[bool, list[Terminal]] = {False: [], True: []}
    for terminal in model.terminals:
        sides[_gives(model, terminal)].append(terminal)
    for gives, found in sides.items():
        for place, terminal in enumerate(found, start=1):
            height = _EXTENT - 2 * _EXTENT * place // (len(found) + 1)
            _add_terminal(terminals, terminal, _EXTENT if gives else -_EXTENT, height)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _gives(model: Model, terminal: Terminal) -> bool:
    """Return whether what the terminal is named for, its first member, is an output."""
    return model.variables[model.value_reference(terminal.members[0])].causality == "output"


def _add_terminal(terminals: Element, terminal: Terminal, x: int, y: int) -> None:
    attributes = {"name": terminal.name, "matchingRule": "bus", "description": terminal.description}
    element = SubElement(terminals, "Terminal", attributes)
    for name in terminal.members:
        member = {"variableName": name, "memberName": name, "variableKind": "signal"}
        SubElement(element, "TerminalMemberVariable", member)
    box = _box(x - _SIZE // 2, y - _SIZE // 2, x + _SIZE // 2, y + _SIZE // 2)
    line = {"defaultConnectionColor": terminal.color, "defaultConnectionStrokeSize": "4"}
    SubElement(element, "TerminalGraphicalRepresentation", line | box | {"iconBaseName": terminal.name})


def _box(x1: int, y1: int, x2: int, y2: int) -> dict[str, str]:
    return {"x1": str(x1), "y1": str(y1), "x2": str(x2), "y2": str(y2)}
