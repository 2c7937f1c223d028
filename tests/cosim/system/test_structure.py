from __future__ import annotations

import copy
import json
import pickle

import pytest

from cosim import Component, Connection, Constant, PowerBond, System
from cosim.errors import SystemDefinitionError
from cosim.system.structure import Port


def test_an_address_is_split_at_its_first_dot() -> None:
    port = Port.parse("plant.stations[1].speed")
    assert (port.component, port.variable) == ("plant", "stations[1].speed")
    assert str(port) == "plant.stations[1].speed"
    assert Port.parse(port) is port


@pytest.mark.parametrize("address", ["", "plant", ".Omega", "plant.", "."])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(SystemDefinitionError, match=rf"^'{address}': expected the form component\.variable$"):
        Port.parse(address)


def test_a_port_compares_orders_and_serves_as_a_key_like_its_text() -> None:
    port = Port("plant", "Omega")
    assert port == "plant.Omega"
    assert {port: 1}["plant.Omega"] == {"plant.Omega": 1}[port] == 1
    assert sorted([Port("plant", "b"), Port("plant", "a"), Port("law", "z")]) == ["law.z", "plant.a", "plant.b"]
    assert json.dumps({port: [port]}) == '{"plant.Omega": ["plant.Omega"]}'


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda port: pickle.loads(pickle.dumps(port))])
def test_a_copy_of_a_port_is_a_port(copied) -> None:
    port = copied(Port("plant", "a.b"))
    assert type(port) is Port
    assert (port, port.component, port.variable) == ("plant.a.b", "plant", "a.b")


def test_a_port_cannot_be_changed() -> None:
    port = Port("plant", "Omega")
    for name in ("component", "variable", "other"):
        with pytest.raises(AttributeError, match=r"^plant\.Omega: a port cannot be changed$"):
            setattr(port, name, "law")
    assert port.component == "plant"


def test_strings_and_ports_make_the_same_system_which_holds_ports() -> None:
    omega, torque, law = Port("plant", "Omega"), Port("plant", "torque"), Port("law", "active")
    parts = Component("plant", "p.fmu"), Component("law", "l.fmu")
    of_ports, of_strings = (
        System(
            parts, (Connection(read(law), read(omega)),), {read(torque): Constant(1.0)}, (read(law),),
            (PowerBond(read(omega), read(torque)),),
        )
        for read in (Port.parse, str)
    )  # fmt: skip
    assert of_ports == of_strings
    inside = [*of_strings.inputs, *of_strings.guards]
    inside += [of_strings.connections[0].source, of_strings.connections[0].target, of_strings.power_bonds[0].input]
    assert {type(port) for port in inside} == {Port}
    assert of_strings.with_values({torque: 2.0}) == of_ports.with_values({"plant.torque": 2.0})
    assert of_strings.inputs["plant.torque"] == Constant(1.0)
