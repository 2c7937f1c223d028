"""Reading .ssp files of other tools: what the standard allows and is supported, and what is refused by name."""

from __future__ import annotations

import logging
import math
import re
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim import simulate
from cosim.cli.app import app
from cosim.errors import InputError
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.reading import open_ssp
from cosim.scenario.ssp.writing import export_ssp
from cosim.system.signals import Value

NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
)
RPM = '<ssc:Unit name="rpm"><ssc:BaseUnit rad="1" s="-1" factor="0.10471975511965977"/></ssc:Unit>'
CONNECTION = '<ssd:Connection startElement="one" startConnector="u_seen" endElement="two" endConnector="u"/>'
STRUCTURE = (Path(__file__).parent / "probes.ssd").read_text(encoding="utf-8")
REFUSED = tomllib.loads((Path(__file__).parent / "refused.toml").read_text(encoding="utf-8"))["refused"]

Make = Callable[..., Path]


def parameter_set(*parameters: str, units: str = "") -> str:
    units = f"<ssv:Units>{units}</ssv:Units>" if units else ""
    content = "".join(parameters)
    return (
        f'<ssv:ParameterSet {NAMESPACES} version="1.0" name="set">'
        f"<ssv:Parameters>{content}</ssv:Parameters>{units}</ssv:ParameterSet>"
    )


def parameter(name: str, kind: str, value: str, **attributes: str) -> str:
    more = "".join(f' {key}="{text}"' for key, text in attributes.items())
    return f'<ssv:Parameter name="{name}"><ssv:{kind} value="{value}"{more}/></ssv:Parameter>'


def bindings(*content: str) -> str:
    return f"<ssd:ParameterBindings>{''.join(content)}</ssd:ParameterBindings>"


def inline(content: str, prefix: str = "") -> str:
    values = f"<ssd:ParameterValues>{content}</ssd:ParameterValues>"
    return f'<ssd:ParameterBinding prefix="{prefix}">{values}</ssd:ParameterBinding>'


def external(source: str) -> str:
    return f'<ssd:ParameterBinding source="{source}"/>'


@pytest.fixture
def make(probe: Path, tmp_path: Path) -> Make:
    """Pack two probes into an archive, with replacements in the description."""

    def make(replace: dict[str, str] | None = None, files: dict[str, str | bytes] | None = None) -> Path:
        text = STRUCTURE
        for old, new in (replace or {}).items():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "probes.ssp"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("SystemStructure.ssd", text)
            archive.write(probe, "resources/probe.fmu")
            for name, content in (files or {}).items():
                archive.writestr(name, content)
        return path

    return make


def read(path: Path) -> Scenario:
    with open_ssp(path, step_size=0.125) as scenario:
        return scenario


def parameters(path: Path, component: str = "one") -> dict[str, Value]:
    return next(dict(part.parameters) for part in read(path).system.components if part.name == component)


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    return sentence


def test_a_plain_system_is_run(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make({"<!--bindings-->": bindings(inline(parameter_set(parameter("u", "Real", "2.5"))))})
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["run", str(path), "--step-size", "0.125", "--output", "out"])
    assert result.exit_code == 0, result.output
    header, first, *_, last = (tmp_path / "out" / "trajectory.csv").read_text().splitlines()
    rows = (dict(zip(header.split(","), map(float, row.split(",")), strict=True)) for row in (first, last))
    begin, end = rows
    assert (begin["time"], end["time"]) == (0.5, 1.5)
    assert end["two.u"] == 2.5
    assert end["one.integral"] == 2.5


def test_a_folder_is_left_only_while_it_is_needed(make: Make, no_leftovers: Path) -> None:
    with open_ssp(make(), step_size=0.125) as scenario:
        assert all(Path(part.fmu).is_file() for part in scenario.system.components)


def test_both_ends_of_a_connection_may_come_first(make: Make) -> None:
    turned = '<ssd:Connection startElement="two" startConnector="u" endElement="one" endConnector="u_seen"/>'
    assert read(make({CONNECTION: turned})).system.connections == read(make()).system.connections


@pytest.mark.parametrize(
    ("given", "name", "value"),
    [
        (parameter("gain", "Real", "1e-1"), "gain", 0.1),
        (parameter("n", "Integer", "-3"), "n", -3),
        (parameter("flag", "Boolean", "1"), "flag", True),
        (parameter("text", "String", " a &amp; b "), "text", " a & b "),
        (parameter("mode", "Enumeration", "fast"), "mode", "fast"),
    ],
)
def test_every_type_of_parameter_is_read(make: Make, given: str, name: str, value: Value) -> None:
    path = make({"<!--bindings-->": bindings(inline(parameter_set(given)))})
    assert parameters(path) == {name: value}
    assert type(parameters(path)[name]) is type(value)


def test_later_bindings_and_those_of_the_system_take_priority(make: Make) -> None:
    def gains(*values: float) -> str:
        return parameter_set(*(parameter(name, "Real", str(v)) for name, v in zip(("gain", "u"), values, strict=False)))

    own = bindings(inline(gains(1, 1)), external("resources/second%20set.ssv"))
    files: dict[str, str | bytes] = {"resources/second set.ssv": gains(2)}
    assert parameters(make({"<!--bindings-->": own}, files)) == {"gain": 2.0, "u": 1.0}
    above = bindings(inline(gains(3), prefix="one."), inline(parameter_set(parameter("two.gain", "Real", "4"))))
    path = make({"<!--bindings-->": own, "<!--system bindings-->": above}, files)
    assert parameters(path) == {"gain": 3.0, "u": 1.0}
    assert parameters(path, "two") == {"gain": 4.0}


def test_units_of_parameters_are_converted(make: Make) -> None:
    given = parameter_set(parameter("u", "Real", "30", unit="rpm"), units=RPM)
    (value,) = parameters(make({"<!--bindings-->": bindings(inline(given))})).values()
    assert value == pytest.approx(3.14159265358979, rel=1e-15)


def test_a_unit_that_the_set_does_not_define_is_taken_by_its_name(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    given = parameter_set(parameter("u", "Real", "30", unit="rad/s"))
    with caplog.at_level(logging.WARNING, "cosim"):
        assert parameters(make({"<!--bindings-->": bindings(inline(given))})) == {"u": 30.0}
    (record,) = caplog.records
    assert record.getMessage() == "one.u is given in rad/s and taken as rad/s (= s^-1 rad) as it is"


@pytest.mark.parametrize(("unit", "units"), [("rpm", ""), ("m", '<ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>')])
def test_a_unit_that_cannot_be_converted_is_refused(make: Make, unit: str, units: str) -> None:
    given = parameter_set(parameter("u", "Real", "1", unit=unit), units=units)
    found = refusal(make({"<!--bindings-->": bindings(inline(given))}))
    assert found.startswith(f"one.u is given in {unit}")
    assert found.endswith("; expected rad/s (= s^-1 rad) or what can be converted into it")


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ('unit="rad/s"', "connector two.u is in rad/s, the FMU's variable in rad/s (= s^-1 rad); taken for the same"),
        ('unit="1/min"', "connector two.u is in 1/min, the FMU's variable in rad/s (= s^-1 rad); taken for the same"),
    ],
)
def test_a_connector_in_a_unit_that_is_not_defined_is_taken_with_a_warning(
    make: Make, caplog: pytest.LogCaptureFixture, other: str, message: str
) -> None:
    with caplog.at_level(logging.WARNING, "cosim"):
        read(make({'name="u" kind="input"><ssc:Real/>': f'name="u" kind="input"><ssc:Real {other}/>'}))
    assert message in caplog.text


def test_suppressed_conversion_of_units_passes_values_on_as_they_are(make: Make, tmp_path: Path) -> None:
    replace = {
        '<ssd:Connector name="u" kind="input"><ssc:Real/>': '<ssd:Connector name="v" kind="input"><ssc:Real/>',
        'endConnector="u"': 'endConnector="v"',
        "<!--bindings-->": bindings(inline(parameter_set(parameter("u", "Real", "2.5")))),
    }
    with open_ssp(make(replace), step_size=0.125) as scenario:
        assert simulate(scenario)["two.v"][-1] == pytest.approx(2.5 * 30.0 / math.pi, rel=1e-15)
    suppressed = replace | {'endConnector="u"': 'endConnector="v" suppressUnitConversion="true"'}
    with open_ssp(make(suppressed), step_size=0.125) as scenario:
        assert simulate(scenario)["two.v"][-1] == 2.5
        export_ssp(scenario, tmp_path / "again.ssp")
    assert read(tmp_path / "again.ssp").system.connections[0].unconverted


def test_values_nothing_takes_are_ignored_with_a_warning(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    given = parameter_set(parameter("two.u", "Real", "1"), parameter("two.gaim", "Real", "1"))
    with caplog.at_level(logging.WARNING, "cosim"):
        assert parameters(make({"<!--system bindings-->": bindings(inline(given))}), "two") == {}
    assert [record.getMessage() for record in caplog.records] == [
        "two.u: a connection drives this input; its start value is ignored",
        "two.gaim: Probe has no variable of that name; its value is ignored",
    ]


def test_variants_in_the_archive_are_named(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "cosim"):
        read(make(files={"VariantB.ssd": STRUCTURE}))
    (record,) = caplog.records
    assert record.getMessage() == "probes.ssp: SystemStructure.ssd is read; the variants VariantB.ssd are not"


def test_what_is_drawn_and_noted_is_ignored(make: Make) -> None:
    drawn = (
        '<ssd:SystemGeometry x1="0" y1="0" x2="1" y2="1"/>'
        '<ssd:GraphicalElements><ssd:Note x1="0" y1="0" x2="1" y2="1" text="?"/></ssd:GraphicalElements>'
        '<ssd:Annotations><ssc:Annotation type="com.example"><any xmlns="urn:x"/></ssc:Annotation></ssd:Annotations>'
    )
    assert described(read(make({"<!--after-->": drawn}))) == described(read(make()))


def described(scenario: Scenario) -> object:
    names = [part.name for part in scenario.system.components]
    return names, scenario.system.connections, scenario.start_time, scenario.stop_time


MAPPING = (
    '<ssd:ParameterBinding source="resources/set.ssv"><ssd:ParameterMapping source="resources/map.ssm"/>'
    "</ssd:ParameterBinding>"
)


@pytest.mark.parametrize(
    ("replace", "sentence"),
    [
        *((case["replace"], case["said"]) for case in REFUSED),
        (
            {"<!--bindings-->": bindings(inline(parameter_set(parameter("u", "Real", "two"))))},
            "a parameter binding of one breaks the schema of SSP 1.0: Element 'Real', attribute 'value': 'two' is not",
        ),
        (
            {"<!--bindings-->": bindings(inline(parameter_set(*[parameter("u", "Real", "1")] * 2)))},
            "a parameter binding of one: u is given twice; expected once",
        ),
        (
            {"<!--bindings-->": bindings(inline(parameter_set(parameter("u", "Binary", "00"))))},
            "a parameter binding of one: u is binary; expected a number, a Boolean, a string or an enumeration",
        ),
    ],
)
def test_what_is_damaged_or_not_supported_is_refused_by_name(
    make: Make, replace: dict[str, str], sentence: str, no_leftovers: Path
) -> None:
    found = refusal(make(replace))
    assert "probes.ssp" in found
    assert sentence in found


def test_a_step_size_is_asked_for(make: Make) -> None:
    result = CliRunner().invoke(app, ["run", str(make())])
    assert result.exit_code == 2
    assert "SSP has no communication step size; expected one from --step-size" in result.stderr


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "resources/set.ssv is not XML: no element found"),
        (b"\xff\xfe\x00", "resources/set.ssv is not in UTF-8: byte 0 is 0xff"),
        (
            STRUCTURE.encode(),
            "resources/set.ssv: the root element is SystemStructureDescription; expected ParameterSet",
        ),
        (parameter_set("<ssv:Value/>").encode(), "resources/set.ssv breaks the schema of SSP 1.0: Element 'Value'"),
    ],
)
def test_a_damaged_parameter_set_is_refused(make: Make, content: bytes, sentence: str) -> None:
    path = make({"<!--bindings-->": bindings(external("resources/set.ssv"))}, {"resources/set.ssv": content})
    assert re.search(f"probes.ssp: {re.escape(sentence)}", refusal(path))


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "probes.ssp"
    assert refusal(path) == f"{path}: there is no such file"
    path.write_bytes(b"PK\x03\x04 and nothing")
    assert refusal(path) == f"{path} is not an SSP file: it is not a zip archive"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("other.ssd", STRUCTURE)
    assert refusal(path) == f"{path} is not an SSP file: there is no SystemStructure.ssd in it"


def test_a_damaged_member_is_refused(make: Make) -> None:
    path = make()
    content = bytearray(path.read_bytes())
    content[content.index(b"SystemStructure.ssd") + 60] ^= 0xFF
    path.write_bytes(content)
    assert "SystemStructure.ssd is damaged: " in refusal(path)
