"""What SSP says of values on their way, units and transformations; and one run that tells all that is wrong."""

from __future__ import annotations

import math
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cosim import Component, Connection, Constant, Scenario, System, load_scenario, simulate
from cosim.cli.app import app
from cosim.errors import InputError
from cosim.scenario.ssp.reading import open_ssp
from cosim.scenario.ssp.writing import export_ssp
from tests.cosim.scenario.test_ssp_file import RPM, bindings, inline, parameter, parameter_set
from tests.cosim.scenario.test_ssp_round_trip import validate
from tests.cosim.scenario.test_ssp_topology import component, connection, having, make, read, system

__all__ = ["make"]

Make = Callable[..., Path]
PER_RPM = 30.0 / math.pi
UNITS = f"<ssd:Units>{RPM}</ssd:Units>"
CHOOSING = {
    'causality="input" variability="discrete"><Integer start="0"/>':
        'causality="input" variability="discrete"><Enumeration declaredType="Mode" start="1"/>',
}  # fmt: skip


def linear(**attributes: float) -> str:
    return "<ssc:LinearTransformation " + " ".join(f'{name}="{value}"' for name, value in attributes.items()) + "/>"


def table(kind: str, **entries: str) -> str:
    content = "".join(
        f'<ssc:MapEntry source="{given.strip("_")}" target="{taken}"/>' for given, taken in entries.items()
    )
    return f"<ssc:{kind}MappingTransformation>{content}</ssc:{kind}MappingTransformation>"


def in_unit(content: str, unit: str, name: str) -> str:
    """Give the connectors of a name a unit."""
    return re.sub(rf'(<ssd:Connector name="{name}" kind="\w+">)<ssc:Real/>', rf'\1<ssc:Real unit="{unit}"/>', content)


def final(path: Path, name: str, **options: Any) -> float:
    with open_ssp(path, step_size=0.125) as scenario:
        return float(simulate(scenario, **options)[name][-1])


GIVEN = bindings(inline(parameter_set(parameter("a.u", "Real", "3"))))
A, B = component("a", "u_seen:output", "n_next:output", "not_flag:output"), "b"


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "implicit"])
@pytest.mark.parametrize(
    ("to", "content", "attributes", "expected"),
    [
        ("u", linear(factor=2, offset=-1), "", 5.0),
        ("u", linear(offset=0.5), "", 3.5),
        ("u", linear(factor=-4), "", -12.0),
        ("v", "", "", 3.0 * PER_RPM),
        ("v", linear(factor=2, offset=10), "", 6.0 * PER_RPM + 10.0),
        ("v", linear(factor=2, offset=10), ' suppressUnitConversion="true"', 16.0),
    ],
)
def test_a_linear_transformation_comes_after_the_conversion_of_units(
    make: Make, algorithm: str, to: str, content: str, attributes: str, expected: float
) -> None:
    link = connection("a.u_seen", f"b.{to}", content).replace("<ssd:Connection", f"<ssd:Connection{attributes}", 1)
    whole = system("all", A + component(B, f"{to}:input"), link, head=GIVEN)
    assert final(make(whole), f"b.{to}", algorithm=algorithm) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("start", "to", "content", "value", "expected"),
    [
        ("not_flag", "flag", table("Boolean", true="false"), ("flag", "Boolean", "false"), 0),
        ("not_flag", "flag", table("Boolean", true="false"), ("flag", "Boolean", "true"), 0),
        ("n_next", "n", table("Integer", _4="9"), ("n", "Integer", "3"), 9),
        ("n_next", "n", table("Integer", _4="9"), ("n", "Integer", "4"), 5),
    ],
)
def test_tables_map_what_they_list(
    make: Make, start: str, to: str, content: str, value: tuple[str, str, str], expected: int
) -> None:
    name, kind, text = value
    head = bindings(inline(parameter_set(parameter(f"a.{name}", kind, text))))
    whole = system("all", A + component(B, f"{to}:input"), connection(f"a.{start}", f"b.{to}", content), head=head)
    assert final(make(whole), f"b.{to}") == expected


def through(first: str = "", second: str = "", third: str = "", unit: str = "") -> str:
    """A value from a to a probe two systems down, with something on each of three connections."""
    inner = system("s1", component("p", "u:input"), connection("y", "p.u", third), head=having("y:input"))
    middle = system("s0", inner, connection("x", "s1.y", second), head=having("x:input"))
    whole = system("all", A + middle, connection("a.u_seen", "s0.x", first), head=GIVEN)
    return in_unit(whole, unit, "x") if unit else whole


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ((linear(factor=2), linear(offset=1), linear(factor=3)), 21.0),
        ((linear(offset=1), "", linear(factor=2, offset=5)), 13.0),
        (("", linear(factor=10), ""), 30.0),
    ],
)
def test_transformations_along_a_way_act_one_after_the_other(
    make: Make, parts: tuple[str, str, str], expected: float
) -> None:
    assert final(make(through(*parts)), "s0/s1/p.u") == pytest.approx(expected, rel=1e-14)


def test_a_connector_on_the_way_has_a_unit_of_its_own(make: Make) -> None:
    """In rpm at x, plus 30 rpm there, and back in rad/s at the probe: 3 + pi."""
    path = make(through(first=linear(offset=30), unit="rpm") + UNITS)
    assert final(path, "s0/s1/p.u") == pytest.approx(3.0 + math.pi, rel=1e-14)
    unknown = make(through(first=linear(offset=30), unit="turns"))
    assert final(unknown, "s0/s1/p.u") == 33.0
    suppressed = through(first=linear(offset=30), unit="rpm").replace(
        '<ssd:Connection startElement="a"', '<ssd:Connection suppressUnitConversion="true" startElement="a"'
    )
    assert final(make(suppressed + UNITS), "s0/s1/p.u") == pytest.approx(33.0 / PER_RPM, rel=1e-14)


def test_a_connector_in_another_unit_than_its_variable_is_converted(make: Make) -> None:
    whole = system("all", A + component(B, "u:input"), connection("a.u_seen", "b.u"), head=GIVEN)
    assert final(make(in_unit(whole, "rpm", "u_seen") + UNITS), "b.u") == pytest.approx(3.0, rel=1e-14)
    suppressed = in_unit(whole, "rpm", "u_seen").replace(
        "<ssd:Connection start", '<ssd:Connection suppressUnitConversion="true" start'
    )
    assert final(make(suppressed + UNITS), "b.u") == pytest.approx(3.0 * PER_RPM, rel=1e-14)


def test_a_value_that_is_bound_to_the_whole_system_goes_the_same_way(make: Make) -> None:
    values = bindings(inline(parameter_set(parameter("speed", "Real", "60"))))
    whole = system(
        "all", component("a", "u:input"), connection("speed", "a.u", linear(factor=2)),
        head=having("speed:input") + values,
    )  # fmt: skip
    assert final(make(in_unit(whole, "rpm", "speed") + UNITS), "a.u") == pytest.approx(4.0 * math.pi, rel=1e-14)


def test_an_ambiguous_table_is_refused(make: Make) -> None:
    twice = table("Integer", _4="9").replace("</ssc:", '<ssc:MapEntry source="4" target="8"/></ssc:', 1)
    whole = system("all", A + component(B, "n:input"), connection("a.n_next", "b.n", twice))
    with pytest.raises(InputError, match=r"a\.n_next -> b\.n: its IntegerMappingTransformation maps 4 twice"):
        read(make(whole))


def test_conversions_are_written_and_read_as_they_were(make_probe: Make, tmp_path: Path) -> None:
    probe = make_probe(replace=CHOOSING)
    connections = (
        Connection("a.u_seen", "b.v", factor=1.0 / 3.0, offset=0.1),
        Connection("a.u_seen", "c.v", unconverted=True),
        Connection("a.u_seen", "c.u"),
        Connection("a.not_flag", "b.flag", table={True: False}),
        Connection("a.n_next", "b.n", table={6: "fast"}),
    )
    inputs = {"a.u": Constant(3.0), "a.v": Constant(0.0), "b.u": Constant(1.0), "a.n": Constant("fast")}
    parts = tuple(Component(name, probe) for name in "abc")
    scenario = Scenario("converted", System(parts, connections, inputs), 1.0, 0.125)
    export_ssp(scenario, tmp_path / "out.ssp")
    assert validate(tmp_path / "out.ssp") >= 2
    with open_ssp(tmp_path / "out.ssp") as again:
        read_back, expected = simulate(again), simulate(scenario)
        export_ssp(again, tmp_path / "again.ssp")
    for name in ("b.v", "c.v", "c.u", "b.flag", "b.n", "b.integral"):
        assert read_back[name].tobytes() == expected[name].tobytes(), name
    assert expected["b.v"][-1] == pytest.approx(PER_RPM + 0.1)
    assert expected["b.n"][-1] == 5
    assert (tmp_path / "again.ssp").read_bytes() == (tmp_path / "out.ssp").read_bytes()


def test_connectors_say_their_units_and_the_description_defines_them(tmp_path: Path) -> None:
    export_ssp(load_scenario("wob-law"), tmp_path / "out.ssp")
    assert validate(tmp_path / "out.ssp") >= 2
    with zipfile.ZipFile(tmp_path / "out.ssp") as archive:
        text = archive.read("SystemStructure.ssd").decode()
    defined = dict(re.findall(r'<ssc:Unit name="([^"]+)">\s*<ssc:BaseUnit ([^/]*)/>', text))
    assert defined["N"].split() == ['kg="1"', 'm="1"', 's="-2"']
    assert defined["rad/s"].split() == ['s="-1"', 'rad="1"']
    bit_speed = re.findall(r'<ssd:Connector name="bit_speed" kind="(\w+)">\s*<ssc:Real unit="rad/s" />', text)
    assert bit_speed == ["output", "input"]
    said = set(re.findall(r'<ssc:Real unit="([^"]+)"', text))
    assert {"N", "rad/s", "rad", "J"} <= said <= set(defined)


def test_entries_for_what_the_set_does_not_hold_give_nothing_with_one_warning(
    make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    namespace = 'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"'
    entries = "".join(
        f'<ssm:MappingEntry source="{source}" target="a.{target}"/>'
        for source, target in (("g", "gain"), ("", "u"), ("", "v"), ("other", "n"))
    )
    mapping = f'<ssm:ParameterMapping {namespace} version="1.0">{entries}</ssm:ParameterMapping>'
    binding = (
        f"<ssd:ParameterBinding><ssd:ParameterValues>{parameter_set(parameter('g', 'Real', '2'))}"
        f"</ssd:ParameterValues><ssd:ParameterMapping>{mapping}</ssd:ParameterMapping></ssd:ParameterBinding>"
    )
    whole = system("all", component("a"), head=bindings(binding))
    assert dict(read(make(whole)).system.components[0].parameters) == {"gain": 2.0}
    (said,) = [record.getMessage() for record in caplog.records]
    assert "maps '' and 2 more, which its parameter set does not hold; they give nothing" in said


def test_a_name_given_twice_is_refused_where_it_is_taken(make: Make) -> None:
    values = [parameter(name, "Real", value) for name, value in (("gain", "2"), ("x", "1"), ("x", "7"))]
    whole = system("all", component("a", more=bindings(inline(parameter_set(*values)))))
    assert dict(read(make(whole)).system.components[0].parameters) == {"gain": 2.0}
    with pytest.raises(InputError, match="u is given twice; expected once"):
        read(make(whole.replace('name="x"', 'name="u"')))


def test_a_unit_in_brackets_is_taken_by_its_name(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    values = bindings(inline(parameter_set(parameter("u", "Real", "3", unit="[rad/s]"))))
    assert dict(read(make(system("all", component("a", more=values)))).system.components[0].parameters) == {"u": 3.0}
    assert "a.u is given in rad/s and taken as rad/s (= s^-1 rad) as it is" in caplog.text


def test_one_run_tells_all_that_stops_it_with_names_in_the_archive(make: Make, tmp_path: Path) -> None:
    whole = system(
        "all",
        '<ssd:Component name="gone" source="resources/gone.fmu"/>'
        '<ssd:Component name="old" source="resources/old.fmu"/>'
        '<ssd:Component name="me" source="resources/probe.fmu" implementation="ModelExchange"/>'
        + component("a", "u_seen:output", more=bindings(inline(parameter_set(parameter("gain", "Binary", "00"))))),
        connection("a.u_seen", "nobody.u"),
        connection("a.wrong", "a.u"),
    )
    path = make(whole, {"resources/old.fmu": "no zip"})
    text = zipfile.ZipFile(path).read("SystemStructure.ssd").decode()
    without = tmp_path / "without.ssp"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(without, "w") as new:
        new.writestr("SystemStructure.ssd", re.sub("<ssd:DefaultExperiment[^>]*>", "", text))
        new.writestr("resources/probe.fmu", old.read("resources/probe.fmu"))
        new.writestr("resources/old.fmu", old.read("resources/old.fmu"))
    result = CliRunner(env={"COLUMNS": "2000"}).invoke(app, ["run", str(without)])
    assert result.exit_code == 2
    said = " ".join(result.stderr.split())
    for sentence in (
        "8 things stop it",
        "has no DefaultExperiment with a stopTime; expected one from --stop-time",
        "SSP has no communication step size; expected one from --step-size",
        "component me is to be used by model exchange",
        "a connection leads to nobody.u, but there is no component of that name",
        "a connection leads to a.wrong, which has no such connector",
        "there is no resources/gone.fmu in it",
        "without.ssp: resources/old.fmu is not an FMU: it is not a zip archive",
        "a parameter binding of a: gain is binary",
    ):
        assert sentence in said, sentence
    assert "cosim-ssp-" not in said


def test_fmus_for_other_platforms_are_all_named_by_where_they_lie(make: Make, tmp_path: Path) -> None:
    path = make(system("all", component("a", "u_seen:output") + component("b").replace("probe.fmu", "other.fmu")))
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(tmp_path / "foreign.ssp", "w") as foreign:
        with zipfile.ZipFile(archive.open("resources/probe.fmu")) as fmu:
            description = fmu.read("modelDescription.xml")
        foreign.writestr("SystemStructure.ssd", archive.read("SystemStructure.ssd"))
        for name in ("probe", "other"):
            with zipfile.ZipFile(foreign.open(f"resources/{name}.fmu", "w"), "w") as fmu:
                fmu.writestr("modelDescription.xml", description)
                fmu.writestr("binaries/riscv64-linux/probe.so", b"x")
    with open_ssp(tmp_path / "foreign.ssp", step_size=0.125) as scenario:
        assert [part.name for part in scenario.system.components] == ["a", "b"]  # to be handed on
    with pytest.raises(InputError) as caught:
        simulate(tmp_path / "foreign.ssp", step_size=0.125)
    said = str(caught.value)
    assert said.startswith("2 things stop it: (1) foreign.ssp: resources/probe.fmu: there is no probe")
    assert "(2) foreign.ssp: resources/other.fmu: there is no probe" in said
    assert "riscv64-linux" in said


def test_an_unpacked_description_may_name_what_lies_above_it(make: Make, tmp_path: Path, probe: Path) -> None:
    whole = system("all", component("a").replace("resources/probe.fmu", "../../shared%20fmus/probe.fmu"))
    folder = tmp_path / "systems" / "one"
    with zipfile.ZipFile(make(whole)) as archive:
        archive.extract("SystemStructure.ssd", folder)
    (tmp_path / "shared fmus").mkdir()
    (tmp_path / "shared fmus" / "probe.fmu").write_bytes(probe.read_bytes())
    assert final(folder / "SystemStructure.ssd", "a.u") == 0.0
    with pytest.raises(InputError, match="expected a path within the archive"):
        read(make(whole))


def test_a_proxy_on_this_machine_is_a_process_of_its_own(make: Make) -> None:
    whole = system("all", component("a", "u:input") + component("b"))
    proxied = whole.replace('source="resources/probe.fmu"', 'source="proxyfmu://localhost?file=resources/probe.fmu"', 1)
    with open_ssp(make(proxied), step_size=0.125) as scenario:
        assert [part.isolate for part in scenario.system.components] == [True, False]
        assert simulate(scenario).record["isolated"] == ["a"]
    for source in ("proxyfmu://other.host?file=a.fmu", "proxyfmu://localhost:9090?file=a.fmu"):
        with pytest.raises(InputError, match=f"'{re.escape(source)}'; expected a path within the archive"):
            read(make(whole.replace('"resources/probe.fmu"', f'"{source}"', 1)))
