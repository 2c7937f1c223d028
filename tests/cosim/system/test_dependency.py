"""Algebraic loops and stepping orders follow from ModelStructure and connections."""

from __future__ import annotations

import itertools
import random
from collections.abc import Mapping, Sequence

import pytest

from cosim import Component, Connection, System
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.system.dependency import feedthrough_loops, stepping_groups, stepping_order
from cosim.system.description import Description
from tests.cosim.fakes import describe


def coupled(arrows: Sequence[str], through: Mapping[str, Sequence[str]] | None = None):
    """Connect ``a.y>b.u``; an output depends directly on the inputs of its component named in `through`."""
    connections = tuple(Connection(*arrow.split(">")) for arrow in arrows)
    ends = [end for connection in connections for end in (connection.source, connection.target)]
    names = list(dict.fromkeys(end.component for end in ends))
    descriptions: dict[str, Description] = {}
    for name in names:
        inputs = {c.target.variable: 0.0 for c in connections if c.target.component == name}
        outputs = tuple(dict.fromkeys(c.source.variable for c in connections if c.source.component == name))
        needs = None if through is None else {output: through.get(f"{name}.{output}", ()) for output in outputs}
        descriptions[name] = describe(inputs, outputs, feedthrough=needs)
    return System(tuple(Component(name, "a.fmu") for name in names), connections), descriptions


def listed(system: System, names: Sequence[str]) -> System:
    """List the components in another order."""
    return System(tuple(Component(name, "a.fmu") for name in names), system.connections)


def test_a_loop_needs_feedthrough_all_the_way_round() -> None:
    arrows = ("plant.y>law.u", "law.w>plant.v")
    (loop,) = feedthrough_loops(*coupled(arrows, {"plant.y": ["v"], "law.w": ["u"]}))
    assert str(loop) == "law.u -> law.w -> plant.v -> plant.y -> law.u"
    assert feedthrough_loops(*coupled(arrows, {"law.w": ["u"]})) == ()


def test_an_output_without_stated_dependencies_depends_on_every_input() -> None:
    (loop,) = feedthrough_loops(*coupled(("a.y>b.u", "b.y>a.u")))
    assert loop.variables == {"a.y", "b.u", "b.y", "a.u"}


def test_loops_that_share_a_variable_are_one_and_separate_loops_are_two() -> None:
    shared = coupled(("a.y>b.u", "b.y>a.u", "a.z>b.v", "b.y>a.w"))
    assert len(feedthrough_loops(*shared)) == 1
    apart = coupled(("a.y>b.u", "b.y>a.u", "c.y>d.u", "d.y>c.u", "a.y>c.v"))
    assert [loop.path[0] for loop in feedthrough_loops(*apart)] == ["b.u", "d.u"]


def test_the_path_of_a_loop_is_a_shortest_way_round() -> None:
    (loop,) = feedthrough_loops(*coupled(("a.y>b.u", "b.y>c.u", "c.y>a.u", "b.z>a.v")))
    assert loop.path == ("b.u", "b.z", "a.v", "a.y")


def test_the_plant_and_the_law_form_a_loop_through_the_top_but_not_through_the_bit() -> None:
    descriptions = {
        name: read_description(locate_fmu(fmu, "native"))
        for name, fmu in (("plant", "DrillstringNeutral"), ("law", "DissipativeLaw"), ("wob", "WeightOnBitLaw"))
    }
    components = (
        Component("plant", "DrillstringNeutral"),
        Component("law", "DissipativeLaw"),
        Component("wob", "WeightOnBitLaw"),
    )
    connections = (
        Connection("law.Omega", "plant.Omega"),
        Connection("plant.top_speed", "law.top_speed"),
        Connection("plant.bit_speed", "law.bit_speed"),
        Connection("plant.bit_speed", "wob.bit_speed"),
        Connection("wob.WOB", "plant.WOB"),
    )
    system = System(components, connections)
    for initially in (False, True):
        (loop,) = feedthrough_loops(system, descriptions, initially=initially)
        assert str(loop) == "plant.Omega -> plant.top_speed -> law.top_speed -> law.Omega -> plant.Omega"


def test_the_order_follows_the_connections_and_the_list_where_they_leave_a_choice() -> None:
    system, descriptions = coupled(("c.y>b.u", "b.y>a.u", "d.y>a.v"))
    assert stepping_order(listed(system, ["a", "b", "c", "d"]), descriptions) == ("c", "b", "d", "a")
    assert stepping_order(listed(system, ["d", "a", "b", "c"]), descriptions) == ("d", "c", "b", "a")


def test_a_cycle_begins_with_the_component_that_feeds_nothing_through() -> None:
    arrows = ("law.w>plant.v", "plant.y>law.u")
    system, descriptions = coupled(arrows, {"law.w": ["u"]})
    assert stepping_order(system, descriptions) == ("plant", "law")
    system, descriptions = coupled(arrows)
    assert stepping_order(system, descriptions) == ("law", "plant")


def test_within_a_cycle_only_what_leads_back_to_its_first_component_is_late() -> None:
    system, descriptions = coupled(("a.y>b.u", "b.y>c.u", "c.y>d.u", "d.y>a.u"))
    for names in itertools.permutations("abcd"):
        order = stepping_order(listed(system, names), descriptions)
        turned = "abcd"[("abcd").index(names[0]) :] + "abcd"[: "abcd".index(names[0])]
        assert "".join(order) == turned


def test_a_component_connected_to_itself_is_coupled() -> None:
    system, descriptions = coupled(("a.y>a.u", "a.y>b.u"))
    groups = stepping_groups(system, descriptions, system.connections)
    assert [(group.components, group.coupled) for group in groups] == [(("a",), True), (("b",), False)]


@pytest.mark.parametrize("seed", range(20))
def test_no_value_between_groups_is_ever_late(seed: int) -> None:
    choice = random.Random(seed)
    names = [f"c{number}" for number in range(8)]
    arrows = [f"{a}.y>{b}.from_{a}" for a in names for b in names if choice.random() < 0.15]
    arrows.append(f"{names[0]}.y>{names[1]}.extra")
    system, descriptions = coupled(arrows)
    groups = stepping_groups(system, descriptions, system.connections)
    place = {name: index for index, group in enumerate(groups) for name in group.components}
    assert sorted(place) == sorted(component.name for component in system.components)
    for connection in system.connections:
        source, target = connection.source.component, connection.target.component
        assert place[source] <= place[target]
    for group in groups:
        assert group.coupled == _on_a_cycle(group.components[0], system)


def _on_a_cycle(name: str, system: System) -> bool:
    """Follow all connections for as many steps as there are components."""
    arrows = {(c.source.component, c.target.component) for c in system.connections}
    reached = {target for source, target in arrows if source == name}
    for _ in system.components:
        reached |= {target for source, target in arrows if source in reached}
    return name in reached
