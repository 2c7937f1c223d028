"""What is made from the interface tables: the description, the C table, the page."""

from __future__ import annotations

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from fmu_src.build.description import model_description
from fmu_src.build.header import table_header, table_source
from fmu_src.build.native import NATIVE
from fmu_src.fmus import MODELS
from fmu_src.page.page import documentation_page
from fmu_src.schema import Model, Packaging
from tests.fmu_src.gauge import GAUGE

ALL = [*MODELS.values(), GAUGE]


def described(model: Model, packaging: Packaging = Packaging.NATIVE) -> ElementTree.Element:
    return ElementTree.fromstring(model_description(model, packaging, "{guid}"))


@pytest.mark.parametrize("packaging", list(Packaging))
@pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
def test_every_variable_is_described_at_its_place(model: Model, packaging: Packaging) -> None:
    scalars = described(model, packaging).findall("ModelVariables/ScalarVariable")
    assert [scalar.get("name") for scalar in scalars] == [variable.name for variable in model.variables]
    assert [int(scalar.attrib["valueReference"]) for scalar in scalars] == list(range(len(model.variables)))


@pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
def test_numbers_read_back_as_the_same_bits(model: Model) -> None:
    for scalar, variable in zip(described(model).iter("ScalarVariable"), model.variables, strict=True):
        if variable.kind == "Real":
            texts = [scalar[0].get(name) for name in ("start", "min", "max", "nominal")]
            read = [None if text is None else float(text) for text in texts]
            assert read == [variable.start, variable.minimum, variable.maximum, variable.nominal]


@pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
def test_every_unit_is_defined_by_its_base_and_every_display_unit_by_its_factor(model: Model) -> None:
    root = described(model)
    units = {unit.attrib["name"]: unit for unit in root.findall("UnitDefinitions/Unit")}
    for real in root.iter("Real"):
        unit = units[real.attrib["unit"]]
        assert unit.find("BaseUnit") is not None
        if "displayUnit" in real.attrib:
            assert real.attrib["displayUnit"] in [display.get("name") for display in unit.findall("DisplayUnit")]


def test_dependencies_are_indices_of_variables() -> None:
    model = MODELS["WeightOnBitLaw"]
    root = described(model)
    names = [variable.name for variable in model.variables]
    (output,) = root.findall("ModelStructure/Outputs/Unknown")
    assert names[int(output.attrib["index"]) - 1] == "WOB"
    assert [names[int(index) - 1] for index in output.attrib["dependencies"].split()] == ["bit_speed"]
    (unknown,) = root.findall("ModelStructure/InitialUnknowns/Unknown")
    assert len(unknown.attrib["dependencies"].split()) == 4


def test_an_output_without_dependencies_says_so() -> None:
    root = described(MODELS["DrillstringNeutral"])
    outputs = {unknown.attrib["index"]: unknown for unknown in root.findall("ModelStructure/Outputs/Unknown")}
    bit_speed = MODELS["DrillstringNeutral"].value_reference("bit_speed") + 1
    assert outputs[str(bit_speed)].attrib["dependencies"] == ""


def test_a_python_fmu_promises_no_derivatives() -> None:
    for model in MODELS.values():
        flags = described(model, Packaging.PYTHON)[0].attrib
        assert flags["needsExecutionTool"] == "true"
        assert (flags["canInterpolateInputs"], flags["maxOutputDerivativeOrder"]) == ("false", "0")
        assert flags["providesDirectionalDerivative"] == "false"


def test_a_unit_nobody_defines_is_refused() -> None:
    variable = GAUGE.variables[0].__class__("x", "input", "x", unit="furlong", start=0.0)
    model = Model("Odd", "Odd", (variable,))
    with pytest.raises(ValueError, match="Odd: no unit definition for furlong"):
        model_description(model, Packaging.NATIVE, "{guid}")


@pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
def test_the_c_table_compiles_without_a_warning(model: Model, tmp_path: Path) -> None:
    (tmp_path / "ds_table.h").write_text(table_header(model, "{guid}"))
    (tmp_path / "ds_table.c").write_text(table_source(model))
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic", f"-I{NATIVE}"]
    command = [sys.executable, "-m", "ziglang", "cc", *flags, "-c", "ds_table.c", "-o", "ds_table.o"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


def test_the_c_table_holds_what_the_table_says() -> None:
    header, source = table_header(GAUGE, "{guid}"), table_source(GAUGE)
    assert "#define DS_TEXTS 1 " in header
    assert "DS_rate = 0,\n    DS_total,\n" in header
    assert '{"rate", "rad/s", "Real", DS_REAL, DS_INPUT, 1.0, 0.0, 10.0}' in source
    assert '{"total", "rad", "Real", DS_REAL, DS_OUTPUT, 0.0, -DBL_MAX, DBL_MAX}' in source
    assert '{"full", "", "Boolean", DS_BOOLEAN, DS_OUTPUT, 0.0, 0.0, 1.0}' in source
    assert '{"limit", "rad", "Real", DS_REAL, DS_TUNABLE, 50.0, -DBL_MAX, DBL_MAX}' in source
    assert '{"mode", "", "Enumeration", DS_INTEGER, DS_FIXED, 1.0, 1.0, 2.0}' in source
    assert '{"label", "", "String", DS_STRING, DS_FIXED, 0.0, -DBL_MAX, DBL_MAX}' in source


def test_an_array_in_c_is_as_long_as_the_table_lets_its_count_be() -> None:
    model = MODELS["DrillstringDistributed"]
    stations = [variable.name for variable in model.variables if variable.name.endswith("_twist")]
    assert f"#define DS_MOST_stations {len(stations)}\n" in table_header(model, "{guid}")


class _Page(HTMLParser):
    """Collects the identifiers on a page, and what it would load from elsewhere."""

    VOID = ("meta", "br", "hr", "img", "link")

    def __init__(self) -> None:
        super().__init__()
        self.identifiers: list[str] = []
        self.loaded: list[str] = []
        self.opened: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.identifiers += [found["id"] or ""] if "id" in found else []
        self.loaded += [str(found[name]) for name in ("src", "href") if name in found]
        self.opened += [] if tag in self.VOID else [tag]

    def handle_endtag(self, tag: str) -> None:
        assert self.opened.pop() == tag


@pytest.mark.parametrize("packaging", list(Packaging))
@pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
def test_the_page_shows_every_variable_and_loads_nothing(model: Model, packaging: Packaging) -> None:
    page = _Page()
    page.feed(documentation_page(model, packaging).decode())
    sections = {name.removeprefix("#") for name in page.loaded if name.startswith("#")}
    assert sorted(page.identifiers) == sorted([*(variable.name for variable in model.variables), *sections])
    assert [name for name in page.loaded if not name.startswith("#")] == ["licenses/license.txt"]
    assert page.opened == []


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_every_variable_says_which_equation_it_belongs_to(model: Model) -> None:
    assert [variable.name for variable in model.variables if not variable.equation] == []


def test_the_page_of_the_law_begins_with_the_verdict() -> None:
    page = documentation_page(MODELS["DissipativeLaw"], Packaging.NATIVE).decode()
    body = page[page.index("</nav>") :]
    assert body.index("cannot hold a drilling speed") < body.index("<h2")


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_only_the_page_of_a_native_fmu_tells_how_to_compile(model: Model) -> None:
    pages = {packaging: documentation_page(model, packaging).decode() for packaging in Packaging}
    assert f"sources/{model.name}.c" in pages[Packaging.NATIVE]
    assert "sources/" not in pages[Packaging.PYTHON].replace("the sources are in resources/", "")
