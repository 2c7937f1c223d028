"""Nested systems, connectors of systems, signal dictionaries, parameter mappings: SSP as other tools write it."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim import simulate
from cosim.errors import InputError
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.reading import open_ssp
from cosim.system.structure import Connection
from tests.cosim.scenario.test_ssp_file import NAMESPACES, bindings, inline, parameter, parameter_set

Make = Callable[..., Path]
SSM = 'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"'


def component(name: str, *connectors: str, more: str = "") -> str:
    return f'<ssd:Component name="{name}" source="resources/probe.fmu">{having(*connectors)}{more}</ssd:Component>'


def having(*connectors: str) -> str:
    kinds = (each.split(":") for each in connectors)
    content = "".join(f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>' for name, kind in kinds)
    return f"<ssd:Connectors>{content}</ssd:Connectors>" if connectors else ""


def system(name: str, elements: str, *connections: str, head: str = "", tail: str = "") -> str:
    ends = f"<ssd:Connections>{''.join(connections)}</ssd:Connections>" if connections else ""
    return f'<ssd:System name="{name}">{head}<ssd:Elements>{elements}</ssd:Elements>{ends}{tail}</ssd:System>'


def connection(start: str, end: str, content: str = "") -> str:
    ends: list[str] = []
    for side, text in (("start", start), ("end", end)):
        owner, _, name = text.rpartition(".")
        ends += [f'{side}Element="{owner}"'] * bool(owner) + [f'{side}Connector="{name}"']
    return f"<ssd:Connection {' '.join(ends)}>{content}</ssd:Connection>"


@pytest.fixture
def make(probe: Path, tmp_path: Path) -> Make:
    """Pack a system of probes into an archive."""

    def make(whole: str, files: dict[str, str] | None = None) -> Path:
        path = tmp_path / "probes.ssp"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(
                "SystemStructure.ssd",
                f'<ssd:SystemStructureDescription {NAMESPACES} version="1.0" name="probes">{whole}'
                '<ssd:DefaultExperiment startTime="0" stopTime="1"/></ssd:SystemStructureDescription>',
            )
            archive.write(probe, "resources/probe.fmu")
            for name, content in (files or {}).items():
                archive.writestr(name, content)
        return path

    return make


def read(path: Path) -> Scenario:
    with open_ssp(path, step_size=0.125) as scenario:
        return scenario


def parameters(path: Path) -> dict[str, dict[str, object]]:
    return {part.name: dict(part.parameters) for part in read(path).system.components}


def nested(depth: int) -> str:
    """A probe below so many systems, reached through a connector of each of them."""
    inner = component("probe", "u:input", "u_seen:output")
    end = "probe"
    for level in range(depth):
        inner = system(
            f"s{level}", inner, connection("x", f"{end}.{'u' if level == 0 else 'x'}"),
            connection(f"{end}.{'u_seen' if level == 0 else 'y'}", "y"), head=having("x:input", "y:output"),
        )  # fmt: skip
        end = f"s{level}"
    return inner


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_connections_lead_through_systems_nested_in_each_other(make: Make, depth: int) -> None:
    outer = f"s{depth - 1}"
    whole = system(
        "all", component("a", "u_seen:output") + nested(depth) + component("b", "u:input"),
        connection("a.u_seen", f"{outer}.x"), connection("b.u", f"{outer}.y"),
    )  # fmt: skip
    scenario = read(make(whole))
    deep = "/".join(f"s{level}" for level in reversed(range(depth))) + "/probe"
    assert {part.name for part in scenario.system.components} == {"a", "b", deep}
    assert set(scenario.system.connections) == {
        Connection("a.u_seen", f"{deep}.u"),
        Connection(f"{deep}.u_seen", "b.u"),
    }


def test_a_nested_system_gives_the_values_of_a_flat_one(make: Make) -> None:
    deep = system("all", component("a", "u_seen:output") + nested(2), connection("a.u_seen", "s1.x"))
    flat = system("all", component("a", "u_seen:output") + component("b", "u:input"), connection("a.u_seen", "b.u"))
    values = bindings(inline(parameter_set(parameter("u", "Real", "3"))))
    results = []
    for whole in (deep, flat):
        with open_ssp(
            make(whole.replace("</ssd:Component>", values + "</ssd:Component>", 1)), step_size=0.125
        ) as read_one:
            results.append(simulate(read_one))
    assert results[0]["s1/s0/probe.integral"].tobytes() == results[1]["b.integral"].tobytes()
    assert results[1]["b.integral"][-1] > 0.0


def test_entries_of_a_dictionary_join_what_refers_to_them(make: Make) -> None:
    reference = '<ssd:SignalDictionaryReference name="{}" dictionary="bus"/>'
    inner = system("inner", component("b", "u:input") + reference.format("there"), connection("there.speed", "b.u"))
    whole = system(
        "all", component("a", "u_seen:output") + reference.format("here") + inner, connection("a.u_seen", "here.speed"),
        tail='<ssd:SignalDictionaries><ssd:SignalDictionary name="bus" source="bus.ssb"/></ssd:SignalDictionaries>',
    )  # fmt: skip
    assert read(make(whole)).system.connections == (Connection("a.u_seen", "inner/b.u"),)


def test_an_input_of_the_whole_system_takes_the_value_that_is_bound_to_it(make: Make) -> None:
    values = bindings(inline(parameter_set(parameter("speed", "Real", "7"))))
    whole = system(
        "all", component("a", "u:input") + component("b", "u:input"), connection("speed", "a.u"),
        connection("speed", "b.u"), head=having("speed:input") + values,
    )  # fmt: skip
    assert parameters(make(whole)) == {"a": {"u": 7.0}, "b": {"u": 7.0}}


def test_systems_further_out_take_precedence(make: Make) -> None:
    def bound(*values: str) -> str:
        return bindings(inline(parameter_set(*values)))

    inner = system(
        "inner",
        component("a", more=bound(*(parameter(name, "Real", "1") for name in ("u", "v", "gain")))),
        head=bound(parameter("a.v", "Real", "2"), parameter("a.gain", "Real", "2")),
    )
    whole = system("all", inner, head=bound(parameter("inner.a.gain", "Real", "3")))
    assert parameters(make(whole)) == {"inner/a": {"u": 1.0, "v": 2.0, "gain": 3.0}}


def test_later_bindings_and_prefixes_hold(make: Make) -> None:
    one, other = (inline(parameter_set(parameter("gain", "Real", value)), prefix="a.") for value in ("2", "5"))
    assert parameters(make(system("all", component("a"), head=bindings(one, other)))) == {"a": {"gain": 5.0}}


MAPPING = f"""<ssm:ParameterMapping {SSM} {NAMESPACES} version="1.0">
  <ssm:MappingEntry source="g" target="a.gain"><ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>
  <ssm:MappingEntry source="which" target="a.mode"><ssc:EnumerationMappingTransformation>
    <ssc:MapEntry source="quick" target="fast"/></ssc:EnumerationMappingTransformation></ssm:MappingEntry>
  <ssm:MappingEntry source="on" target="a.flag"><ssc:BooleanMappingTransformation>
    <ssc:MapEntry source="true" target="false"/><ssc:MapEntry source="false" target="true"/>
  </ssc:BooleanMappingTransformation></ssm:MappingEntry>
  <ssm:MappingEntry source="k" target="a.n"><ssc:IntegerMappingTransformation><ssc:MapEntry source="4" target="9"/>
  </ssc:IntegerMappingTransformation></ssm:MappingEntry>
</ssm:ParameterMapping>"""
SET = parameter_set(
    parameter("g", "Real", "2"), parameter("which", "Enumeration", "quick"), parameter("on", "Boolean", "true"),
    parameter("k", "Integer", "4"), parameter("a.fail_status", "Real", "3"),
)  # fmt: skip


@pytest.mark.parametrize("external", [False, True])
def test_a_mapping_gives_values_other_names_and_transforms_them(make: Make, external: bool) -> None:
    mapping = (
        '<ssd:ParameterMapping source="map.ssm"/>'
        if external
        else f"<ssd:ParameterMapping>{MAPPING}</ssd:ParameterMapping>"
    )
    binding = f"<ssd:ParameterBinding><ssd:ParameterValues>{SET}</ssd:ParameterValues>{mapping}</ssd:ParameterBinding>"
    whole = system("all", component("a"), head=bindings(binding))
    assert parameters(make(whole, {"map.ssm": MAPPING})) == {"a": {"gain": 5.0, "mode": "fast", "flag": False, "n": 9}}


@pytest.mark.parametrize(
    ("whole", "sentence"),
    [
        (
            system("all", system("in", component("b"), connection("y", "x"), head=having("x:output", "y:input"))
                   + component("a", "u:input"),
                   connection("in.x", "in.y"), connection("in.x", "a.u")),
            "lead from in.x back to it",
        ),
        (
            system("all", component("a", "u_seen:output") + component("b", "u:input")
                   + component("c", "u_seen:output"),
                   connection("a.u_seen", "b.u"), connection("c.u_seen", "b.u")),
            "b.u is driven by a.u_seen and by c.u_seen; expected one of them",
        ),
        (
            system("all", '<ssd:SignalDictionaryReference name="here" dictionary="bus"/>' + component("b", "u:input"),
                   connection("here.x", "b.u")),
            "here refers to the signal dictionary bus, which is not there",
        ),
    ],
)  # fmt: skip
def test_what_leads_nowhere_is_named(make: Make, whole: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        read(make(whole))
    assert sentence in str(caught.value)


def test_an_unpacked_description_is_read_beside_its_files(make: Make, tmp_path: Path) -> None:
    whole = system("all", component("a", "u_seen:output") + nested(1), connection("a.u_seen", "s0.x"))
    with zipfile.ZipFile(make(whole)) as archive:
        archive.extractall(tmp_path / "unpacked")
    with open_ssp(tmp_path / "unpacked" / "SystemStructure.ssd", step_size=0.125) as scenario:
        assert scenario.system.connections == (Connection("a.u_seen", "s0/probe.u"),)
        assert simulate(scenario).time[-1] == 1.0


def test_a_link_out_of_the_folder_of_a_description_is_refused(make: Make, tmp_path: Path, probe: Path) -> None:
    with zipfile.ZipFile(make(system("all", component("a")))) as archive:
        archive.extract("SystemStructure.ssd", tmp_path / "unpacked")
    (tmp_path / "unpacked" / "resources").mkdir()
    (tmp_path / "unpacked" / "resources" / "probe.fmu").symlink_to(probe)
    with (
        pytest.raises(InputError, match="leads out of the folder"),
        open_ssp(tmp_path / "unpacked" / "SystemStructure.ssd", step_size=0.125),
    ):
        pass


@pytest.mark.parametrize("new", ["", '<ssd:MetaData xmlns:x="urn:x"/>'])
def test_a_description_of_ssp_2_is_read_as_far_as_it_is_one_of_ssp_1(
    make: Make, tmp_path: Path, caplog: pytest.LogCaptureFixture, new: str
) -> None:
    with zipfile.ZipFile(make(system("all", component("a")))) as archive:
        archive.extractall(tmp_path / "unpacked")
    file = tmp_path / "unpacked" / "SystemStructure.ssd"
    file.write_text(file.read_text().replace('version="1.0" name="probes">', f'version="2.0" name="probes">{new}'))
    with open_ssp(file, step_size=0.125) as scenario:
        assert [part.name for part in scenario.system.components] == ["a"]
    assert any("it is of SSP 2.0" in record.getMessage() for record in caplog.records) == bool(new)
