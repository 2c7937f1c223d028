"""The energy that the coupling makes is what an energy balance of the whole system lacks."""

from __future__ import annotations

import numpy as np
import pytest

from cosim import Component, Connection, Method, PowerBond, System, co_simulate, load_scenario, simulate
from cosim.errors import SystemDefinitionError
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.system.description import Description, Unit
from cosim.system.power_bonds import find_bonds
from tests.cosim.fakes import LinearSlave

NEWTON = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
SPEED = Unit("m/s", (0, 1, -1, 0, 0, 0, 0, 0))
MASS, STIFFNESS = 2.0, 30.0
CONNECTIONS = (Connection("spring.y0", "mass.u0"), Connection("mass.y0", "spring.u0"))


def system(**options) -> System:
    return System((Component("mass", "m.fmu"), Component("spring", "s.fmu")), CONNECTIONS, **options)


def oscillator(force: Unit = NEWTON, speed: Unit = SPEED, **options) -> dict[str, LinearSlave]:
    """An undamped oscillator: a mass that starts at 1 m/s and a spring."""
    mass = LinearSlave([[0.0]], [[1.0 / MASS]], [[1.0]], start=[1.0], units={"u0": force, "y0": speed}, **options)
    spring = LinearSlave([[0.0]], [[1.0]], [[-STIFFNESS]], units={"u0": speed, "y0": force}, **options)
    return {"mass": mass, "spring": spring}


def energy(result) -> np.ndarray:
    """Energy in both components, from their outputs."""
    return 0.5 * MASS * result["mass.y0"] ** 2 + result["spring.y0"] ** 2 / (2.0 * STIFFNESS)


@pytest.mark.parametrize(("algorithm", "sign"), [("jacobi", 1.0), ("gauss-seidel", None)])
def test_an_undamped_oscillator_gains_what_the_coupling_makes(algorithm: str, sign: float | None) -> None:
    result = co_simulate(system(), oscillator(), stop_time=3.0, step_size=0.002, method=Method(algorithm))
    made = np.cumsum(result["coupling.energy_residual.mass.u0"])
    gained = energy(result) - energy(result)[0]
    assert np.abs(gained).max() > 3e-3
    assert made == pytest.approx(gained, abs=0.02 * np.abs(gained).max())
    if sign is not None:
        assert sign * gained[-1] > 0.0
    account = result.record["energy_residual"]["mass.u0"]
    assert account["sum"] == pytest.approx(made[-1])
    assert account["exchanged"] > 1.0
    assert result.units["coupling.energy_residual.mass.u0"] == "J"


def test_an_implicit_coupling_makes_next_to_nothing() -> None:
    size = {"stop_time": 3.0, "step_size": 0.02}
    late = co_simulate(system(), oscillator(), method=Method("gauss-seidel"), **size)
    closed = co_simulate(system(), oscillator(can_interpolate_inputs=True), method=Method("implicit"), **size)
    accounts = [result.record["energy_residual"]["mass.u0"] for result in (late, closed)]
    assert accounts[1]["absolute"] < 1e-6 * accounts[0]["absolute"]
    assert np.abs(energy(closed) - 1.0).max() < 0.01 * np.abs(energy(late) - 1.0).max()


def test_a_steady_shift_in_time_makes_what_its_integral_says() -> None:
    """One way only: a force that grows as t, passed on a step late, against a constant speed of 1."""
    slaves = {
        "mass": LinearSlave([[0.0]], [[0.0]], [[1.0]], start=[1.0], units={"u0": NEWTON, "y0": SPEED}),
        "spring": LinearSlave([[0.0]], [[1.0]], [[1.0]], units={"u0": SPEED, "y0": NEWTON}),
    }
    result = co_simulate(system(), slaves, stop_time=1.0, step_size=0.25)
    # In a step from t the force given goes from t to t + h, and the force taken is held at t: h^2 / 2 is lost.
    assert result["coupling.energy_residual.mass.u0"].tolist() == pytest.approx([0.0] + [-(0.25**2) / 2.0] * 4)


def test_units_scale_the_energy_to_joules() -> None:
    kilo = Unit("kN", NEWTON.powers, factor=1000.0)
    size = {"stop_time": 1.0, "step_size": 0.1}
    plain = co_simulate(system(), oscillator(), **size).record["energy_residual"]["mass.u0"]["sum"]
    scaled = co_simulate(system(), oscillator(force=kilo), **size).record["energy_residual"]["mass.u0"]["sum"]
    assert scaled == pytest.approx(1000.0 * plain)


def descriptions(coupled: System) -> dict[str, Description]:
    return {part.name: read_description(locate_fmu(part.fmu, "native")) for part in coupled.components}


def test_units_and_connections_tell_where_power_is_exchanged() -> None:
    (pair,) = find_bonds(system(), {name: slave.description for name, slave in oscillator().items()})
    assert (pair.input, pair.output, pair.source, pair.back) == ("mass.u0", "mass.y0", "spring.y0", "spring.u0")
    coupled = load_scenario("dissipative-law").system
    (drive,) = find_bonds(coupled, descriptions(coupled))
    assert (drive.input, drive.output, drive.source, drive.back) == (
        "plant.Omega",
        "plant.top_torque",
        "law.Omega",
        None,
    )
    weight = load_scenario("wob-law").system
    assert find_bonds(weight, descriptions(weight)) == ()


def test_bonds_that_are_named_replace_those_that_are_told() -> None:
    slaves = oscillator()
    named = system(power_bonds=(PowerBond("spring.u0", "spring.y0"),))
    result = co_simulate(named, slaves, stop_time=0.5, step_size=0.1)
    assert [name for name in result.names if name.startswith("coupling")] == ["coupling.energy_residual.spring.u0"]
    none = co_simulate(system(power_bonds=()), oscillator(), stop_time=0.5, step_size=0.1)
    assert none.record["energy_residual"] == {}


@pytest.mark.parametrize(
    ("bond", "message"),
    [
        (("mass.u", "mass.y0"), r"mass\.u is no input; did you mean 'mass\.u0'"),
        (("mass.u0", "mass.y"), r"mass\.y is no output; did you mean 'mass\.y0'"),
        (("mass.y0", "mass.u0"), r"mass\.y0 is no input"),
    ],
)
def test_a_bond_that_is_none_is_refused(bond: tuple[str, str], message: str) -> None:
    coupled = system(power_bonds=(PowerBond(*bond),))
    with pytest.raises(SystemDefinitionError, match=message):
        co_simulate(coupled, oscillator(), stop_time=0.5, step_size=0.1)


def test_a_bond_must_be_a_power_within_one_component_that_is_connected() -> None:
    with pytest.raises(SystemDefinitionError, match=r"spring is another component; expected an output of mass"):
        PowerBond("mass.u0", "spring.y0")
    named = system(power_bonds=(PowerBond("mass.u0", "mass.y0"),))
    with pytest.raises(SystemDefinitionError, match=r"mass\.u0 in N .* times mass\.y0 in N .* is no power"):
        co_simulate(named, oscillator(speed=NEWTON), stop_time=0.5, step_size=0.1)
    alone = System((Component("mass", "m.fmu"),), power_bonds=(PowerBond("mass.u0", "mass.y0"),))
    with pytest.raises(SystemDefinitionError, match=r"mass\.u0 is not connected"):
        co_simulate(alone, {"mass": oscillator()["mass"]}, stop_time=0.5, step_size=0.1)


def test_the_printed_law_lives_on_energy_that_the_coupling_makes() -> None:
    printed, tracking = (
        simulate(load_scenario("dissipative-law"), variant=variant, stop_time=30.0).record["energy_residual"]
        for variant in ("printed", "tracking")
    )
    assert printed["plant.Omega"]["sum"] > 0.1 * printed["plant.Omega"]["exchanged"]
    assert tracking["plant.Omega"]["absolute"] < 1e-4 * tracking["plant.Omega"]["exchanged"]
