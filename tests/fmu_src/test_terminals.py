"""Icons and terminals of the FMUs of dist/."""

from __future__ import annotations

import io
import zipfile
from itertools import product
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree
from matplotlib.image import imread

from fmu_src.fmus import MODELS
from fmu_src.schema import Model
from tests.fmu_src.draw import draw, drawings
from tests.plant.drive import PLANTS

DIST = Path(__file__).parents[2] / "dist"
SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
FMUS = [f"{packaging}/{name}.fmu" for packaging, name in product(("native", "python"), MODELS)]


def described(archive: zipfile.ZipFile) -> etree._Element:
    return etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))


@pytest.mark.parametrize("drawing", drawings(), ids=lambda drawing: f"{drawing.parent.name}/{drawing.stem}")
def test_every_icon_is_drawn_as_its_drawing_says(drawing: Path) -> None:
    drawn, kept = (imread(io.BytesIO(image)) for image in (draw(drawing), drawing.with_suffix(".png").read_bytes()))
    assert drawn.shape == kept.shape
    np.testing.assert_allclose(drawn, kept, atol=2 / 255)


@pytest.mark.parametrize("fmu", FMUS)
def test_every_fmu_has_an_icon_and_one_for_every_terminal(fmu: str) -> None:
    with zipfile.ZipFile(DIST / fmu) as archive:
        images = ["model.png", "terminalsAndIcons/icon.png"]
        for graphics in described(archive).iter("TerminalGraphicalRepresentation"):
            images.append(f"terminalsAndIcons/{graphics.attrib['iconBaseName']}.png")
        for image in images:
            pixels = imread(io.BytesIO(archive.read(image)))
            assert pixels.shape in ((256, 256, 4), (64, 64, 4))
            assert pixels[0, 0, 3] == 0.0, "the corner is not transparent"
            assert len(np.unique(pixels.reshape(-1, 4), axis=0)) > 3, "the icon shows nothing"


@pytest.mark.parametrize("fmu", FMUS)
def test_terminals_keep_to_the_schema_and_name_variables(fmu: str) -> None:
    with zipfile.ZipFile(DIST / fmu) as archive:
        root = described(archive)
    schema = etree.XMLSchema(file=str(SCHEMA))
    assert schema.validate(root), schema.error_log
    names = {variable.name for variable in fmpy.read_model_description(str(DIST / fmu)).modelVariables}
    assert {member.attrib["variableName"] for member in root.iter("TerminalMemberVariable")} <= names


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_every_input_is_in_a_terminal(model: Model) -> None:
    joined = {member for terminal in model.terminals for member in terminal.members}
    assert {variable.name for variable in model.select("input")} <= joined


def joins_another(model: Model) -> bool:
    """Return whether a terminal of a model fits one of a model that is no plant."""
    others = [other for other in MODELS.values() if other is not model and other.name not in PLANTS]
    inputs = {variable.name for variable in model.select("input")}
    return any(
        mine.name == terminal.name and inputs & set(mine.members) & {v.name for v in other.select("output")}
        for mine in model.terminals
        for other in others
        for terminal in other.terminals
    )


@pytest.mark.parametrize("string", PLANTS)
@pytest.mark.parametrize("name", sorted(MODELS.keys() - {*PLANTS}))
def test_terminals_of_one_name_join_outputs_of_one_unit_to_inputs(name: str, string: str) -> None:
    plant, other = MODELS[string], MODELS[name]
    mine, theirs = ({terminal.name: terminal.members for terminal in model.terminals} for model in (plant, other))
    takes_anything = any(variable.kind == "Real" and variable.unit == "1" for variable in other.select("input"))
    assert mine.keys() & theirs.keys() or joins_another(other) or takes_anything
    for terminal in mine.keys() & theirs.keys():
        for member in set(mine[terminal]) & set(theirs[terminal]):
            ends = [model.variables[model.value_reference(member)] for model in (plant, other)]
            assert {end.causality for end in ends} == {"input", "output"}, member
            assert len({end.unit for end in ends}) == 1, member
