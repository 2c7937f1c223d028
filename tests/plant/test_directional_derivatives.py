"""Derivatives of outputs by inputs, against difference quotients and closed forms.

At a communication point that is how inputs act at once, everything else being as it is: outputs after a step that is
too short for anything to move, from a saved state. In initialization mode parameters act as well.
"""

from __future__ import annotations

from ctypes import byref, c_double, c_int
from math import copysign, inf, nan

import numpy as np
import pytest

from fmu_src.fmus import MODELS
from tests.plant import theory
from tests.plant.drive import DAMPED, PLANT, Drive
from tests.plant.fmi import ERROR, OK, Instance, must
from tests.plant.programs import PAPER

DRIVEN = [name for name, model in MODELS.items() if model.has_real_inputs]
SHORT = 1e-9
"""A step in which nothing moves by more than 1e-7 rad/s [s]."""
MOMENTS = {"stuck": (10.0, 1.8), "slipping": (10.0, 3.4), "slipping back": (-10.0, 3.4)}


def names_of(fmu: Instance, *causalities: str) -> list[str]:
    """Return the Real variables of some causalities."""
    return [name for name, v in fmu.variables.items() if v.causality in causalities and v.type == "Real"]


def outputs_after(plant: Drive, time: float, state: object, **change: float) -> dict[str, float]:
    """Return the outputs after a short step from a state with changed inputs."""
    must(plant, plant.call("SetFMUstate", state))
    plant.time = time
    if change:
        plant.put(**change)
    plant.go(time + SHORT)
    return plant.named()


@pytest.mark.parametrize("moment", MOMENTS)
def test_derivatives_of_the_plant_are_how_inputs_act_at_once(moment):
    omega, time = MOMENTS[moment]
    with Drive(PLANT, {"Omega": omega}) as plant:
        plant.go(time)
        assert plant.get("bit_stuck") == (moment == "stuck")
        state, held = plant.saved(), {"Omega": omega, "WOB": 97347.0}
        base = outputs_after(plant, time, state)
        for name in held:
            by = {output: plant.sensitivity(output, **{name: 1.0}) for output in names_of(plant, "output")}
            change = 1e-3 * abs(held[name])
            moved = outputs_after(plant, time, state, **{name: held[name] + change})
            for output, derivative in by.items():
                quotient = (moved[output] - base[output]) / change
                # what the changed input moves meanwhile is as short as the step
                assert derivative == pytest.approx(quotient, rel=1e-6, abs=SHORT * max(1.0, abs(base[output])))
        must(plant, plant.call("FreeFMUstate", byref(state)))


@pytest.mark.parametrize("moment", MOMENTS)
def test_derivatives_of_the_plant_are_those_of_its_boundary_conditions(moment):
    omega, time = MOMENTS[moment]
    with Drive(PLANT, {"Omega": omega}) as plant:
        plant.go(time)
        now = plant.named()
        due = dict.fromkeys(((output, name) for output in names_of(plant, "output") for name in ("Omega", "WOB")), 0.0)
        due["top_speed", "Omega"] = PAPER.transmission
        due["top_torque", "Omega"] = PAPER.c_a * (1 - PAPER.transmission)
        if moment != "stuck":
            dry = theory.torque_on_bit(PAPER, 1.0, now["bit_speed"]) - PAPER.c_b * now["bit_speed"]
            due["bit_torque", "WOB"] = dry
            assert copysign(1.0, dry) == copysign(1.0, omega)
        for (output, name), derivative in due.items():
            assert plant.sensitivity(output, **{name: 1.0}) == pytest.approx(derivative, rel=1e-12, abs=0.0)


DESCRIBED = {
    # settings under which everything that can depend on an input does
    PLANT: [{}],
    DAMPED: [{"beta": 0.1}],
    "WeightOnBitLaw": [{}],
    "DissipativeLaw": [{"form": form, "top_speed": 12.0} for form in (1, 2)],
    "SoftTorque": [{"filter_time": 0.0}],
    "TopAbsorber": [{"filter_time": 0.0}],
    "BitSpeedObserver": [{}],
}


@pytest.mark.parametrize("model", DESCRIBED)
def test_what_the_description_says_depends_on_an_input_and_nothing_else(model):
    described, seen = set(), set()
    for setting in DESCRIBED[model]:
        with Drive(model, setting) as fmu:
            fmu.go(3.4)
            for unknown in fmu.library.description.outputs:
                if unknown.variable.type == "Real":
                    described |= {(unknown.variable.name, known.name) for known in unknown.dependencies}
            for output in names_of(fmu, "output"):
                inputs = names_of(fmu, "input")
                seen |= {(output, name) for name in inputs if fmu.sensitivity(output, **{name: 1.0}) != 0.0}
    assert seen == described


STARTS = {
    # of the plant: at rest, held while wound up, torn loose at once either way, turning either way
    "at rest": {},
    "wound up": {"initial_torque": 5000.0},
    "torn loose": {"initial_torque": 2e4},
    "torn loose backwards": {"initial_torque": -2e4},
    "turning": {"initial_speed": 6.0, "initial_torque": 7000.0},
    "turning backwards": {"initial_speed": -6.0, "initial_torque": 2000.0, "c_b": 10.0},
}
LAW_STARTS = {
    "printed": {"form": 1, "c_b": 15.0, "top_speed": 9.0, "bit_speed": 7.0, "bit_speed_ref": 4.0, "Omega_max": 1e3},
    "printed, guarded": {"form": 1, "c_b": 15.0, "top_speed": -0.2, "top_speed_min": 0.5, "bit_speed_ref": 2.0},
    "printed, limited": {"form": 1, "top_speed": 1.0, "bit_speed_ref": 20.0},
    "tracking": {"form": 2, "c_b": 15.0, "top_speed": 9.0, "bit_speed": 7.0, "bit_torque_ref": 7e3, "c_1": 0.6},
    "tracking, limited": {"form": 2, "c_b": 15.0, "bit_torque_ref": 1e5},
}


def quotients(fmu: Instance, name: str, outputs: list[str]) -> tuple[dict[str, float], float]:
    """Return difference quotients of outputs by a start value, and the difference; the value is put back."""
    value = fmu.get(name)
    step = 1e-5 * abs(value) if value else 1e-4
    sides = []
    for side in (value + step, value - step):
        must(fmu, fmu.set(**{name: side}))
        sides.append({output: fmu.get(output) for output in outputs})
    must(fmu, fmu.set(**{name: value}))
    return {output: (sides[0][output] - sides[1][output]) / (2 * step) for output in outputs}, step


def assert_differentiates_its_start(
    model: str, start: dict[str, float], left_out: set[tuple[str, str]], energy_bar: float = 1e-6
) -> None:
    integers = {name: value for name, value in start.items() if isinstance(value, int)}
    with Instance(model) as fmu:
        for name, value in start.items():
            must(fmu, fmu.set(**{name: value}))
        must(fmu, fmu.call("EnterInitializationMode"))
        outputs = names_of(fmu, "output")
        for name in set(names_of(fmu, "input", "parameter")) - set(integers):
            due, step = quotients(fmu, name, outputs)
            for output in outputs:
                if (output, name) not in left_out:
                    derivative = fmu.sensitivity(output, **{name: 1.0})
                    noise = 1e-13 * max(1.0, abs(fmu.get(output))) / step
                    bar = energy_bar if output == "energy" else 1e-6
                    assert derivative == pytest.approx(due[output], rel=bar, abs=noise), (output, name)


@pytest.mark.parametrize("start", STARTS)
def test_in_initialization_mode_the_plant_is_differentiated_by_all_it_starts_from(start):
    # a bit at rest cannot be given a speed without slipping: there its torque jumps
    held = "initial_speed" not in STARTS[start]
    left_out = {("bit_torque", "initial_speed")} if held else set()
    assert_differentiates_its_start(PLANT, STARTS[start], left_out)


@pytest.mark.parametrize("start", STARTS)
def test_in_initialization_mode_the_damped_plant_is_differentiated_by_all_it_starts_from(start):
    left_out = {("bit_torque", "initial_speed")} if "initial_speed" not in STARTS[start] else set()
    # the energy is that of the cells, whose error is of second order
    assert_differentiates_its_start(DAMPED, STARTS[start] | {"beta": 0.1, "stations": 3}, left_out, energy_bar=1e-4)


@pytest.mark.parametrize("start", LAW_STARTS)
def test_in_initialization_mode_the_drive_law_is_differentiated_by_inputs_and_parameters(start):
    left_out = {("Omega", "c_b")} if "c_b" not in LAW_STARTS[start] else set()
    assert_differentiates_its_start("DissipativeLaw", LAW_STARTS[start], left_out)


@pytest.mark.parametrize("bit_speed", [8.0, -8.0, 60.0])
def test_in_initialization_mode_the_weight_law_is_differentiated_by_inputs_and_parameters(bit_speed):
    assert_differentiates_its_start("WeightOnBitLaw", {"bit_speed": bit_speed}, set())


SWITCHED = ("SoftTorque", "TopAbsorber")


@pytest.mark.parametrize("model", SWITCHED)
@pytest.mark.parametrize("start", [{}, {"enabled": 0}, {"mode": 2, "top_speed": 6.0, "Omega_max": 9.0}])
def test_in_initialization_mode_a_law_that_can_be_switched_is_differentiated_by_all_it_starts_from(model, start):
    inside = {"J_v": 1.0} if model == "SoftTorque" else {}
    assert_differentiates_its_start(model, start | inside, set())


@pytest.mark.parametrize("model", SWITCHED)
@pytest.mark.parametrize("start", [{}, {"filter_time": 0.0}, {"slip": 2, "filter_time": 0.0}])
def test_after_a_step_a_law_that_can_be_switched_is_differentiated_by_its_inputs(model, start):
    with Drive(model, start | {"top_speed": 8.0, "top_torque": 5000.0}) as law:
        law.go(0.5)
        state = law.saved()
        for name, change in (("top_speed", 1.0), ("top_torque", 1e3), ("speed_ref", 1.0)):
            sides, value = [], law.get(name)
            for side in (change, -change):
                after = outputs_after(law, 0.5, state, **{name: value + side})
                sides.append(after["Omega"])
            must(law, law.call("SetFMUstate", state))
            due = (sides[0] - sides[1]) / (2 * change)
            assert law.sensitivity("Omega", **{name: 1.0}) == pytest.approx(due, rel=1e-4, abs=1e-6)
        must(law, law.call("FreeFMUstate", byref(state)))


@pytest.mark.parametrize("start", LAW_STARTS)
def test_after_a_step_the_drive_law_is_differentiated_at_the_end_of_the_ramps(start):
    at_end = {"top_speed": 0.0, "bit_speed": 0.0, "bit_speed_ref": 10.0, "bit_torque_ref": 0.0} | LAW_STARTS[start]
    slopes = {"top_speed": -0.4, "bit_speed": 3.0, "bit_speed_ref": 0.25, "bit_torque_ref": 100.0}
    begin = at_end | {name: at_end[name] - 0.5 * slope for name, slope in slopes.items()}
    with Drive("DissipativeLaw", begin) as ramped, Drive("DissipativeLaw", at_end) as held:
        must(ramped, ramped.set_slopes(**slopes))
        ramped.go(0.5)
        held.go(0.5)
        for name in slopes:
            derivative = held.sensitivity("Omega", **{name: 1.0})
            assert ramped.sensitivity("Omega", **{name: 1.0}) == pytest.approx(derivative, rel=1e-9)
        ramped.put(top_speed=20.0, c_1=-1.0)  # what is set since has not acted yet
        assert ramped.sensitivity("Omega", bit_speed=1.0) == pytest.approx(
            held.sensitivity("Omega", bit_speed=1.0), rel=1e-9
        )


def test_at_a_kink_the_derivative_is_that_to_the_side_asked_for():
    with Drive("WeightOnBitLaw", {}) as law:
        assert [law.sensitivity("WOB", bit_speed=way) for way in (1.0, -1.0)] == [5000.0, 5000.0]
    at_limit = {"K_w": 1000.0, "WOB_0": 1000.0, "WOB_max": 5000.0, "bit_speed": 4.0}
    with Drive("WeightOnBitLaw", at_limit) as law:
        assert [law.sensitivity("WOB", bit_speed=way) for way in (1.0, -1.0)] == [0.0, -1000.0]
    with Drive("DissipativeLaw", {"form": 2, "top_speed": 40.0, "bit_speed": 40.0, "bit_speed_ref": 40.0}) as law:
        assert [law.sensitivity("Omega", top_speed=way) for way in (1.0, -1.0)] == [0.0, -0.3]
    guard = {"c_1": 0.0, "c_2": 1.0, "c_b": 0.0, "top_speed": 0.5, "top_speed_min": 0.5, "bit_speed_ref": 1.0}
    with Drive("DissipativeLaw", guard) as law:
        assert [law.sensitivity("Omega", top_speed=way) for way in (1.0, -1.0)] == [4.0, 0.0]


def test_seeds_add_up():
    with Drive(PLANT, {}) as plant:
        plant.go(3.4)
        n, unknown = 4, ["bit_torque", "top_speed", "top_torque", "bit_speed"]
        known, seed = plant.references(["Omega", "WOB", "Omega"]), (c_double * 3)(2.0, -3.0, 0.5)
        change = (c_double * n)()
        must(plant, plant.call("GetDirectionalDerivative", plant.references(unknown), n, known, 3, seed, change))
        assert list(change) == [plant.sensitivity(output, Omega=2.5, WOB=-3.0) for output in unknown]
        by = {name: plant.sensitivity("bit_torque", **{name: 1.0}) for name in ("Omega", "WOB")}
        assert change[0] == pytest.approx(2.5 * by["Omega"] - 3.0 * by["WOB"], rel=1e-15)


def test_no_unknowns_and_no_knowns_are_fine():
    with Drive(PLANT, {}) as plant:
        assert plant.call("GetDirectionalDerivative", None, 0, None, 0, None, None) == OK
        one = c_double(7.0)
        assert (
            plant.call("GetDirectionalDerivative", plant.references(["top_speed"]), 1, None, 0, None, byref(one)) == OK
        )
        assert one.value == 0.0


def ask(fmu: Instance, unknown: str, known: str, seed: float = 1.0) -> int:
    """Ask for one derivative and return the status."""
    references = fmu.references([unknown]), 1, fmu.references([known]), 1
    return fmu.call("GetDirectionalDerivative", *references, byref(c_double(seed)), byref(c_double()))


def test_what_cannot_be_differentiated_is_refused_by_name():
    with Drive(PLANT, {}) as plant:
        plant.go(1.0)
        for unknown, known, sentence in (
            ("Omega", "WOB", "Omega is no output"),
            ("c_b", "WOB", "c_b is no output"),
            ("slip_count", "WOB", "variable slip_count is of type Integer"),
            ("bit_stuck", "WOB", "variable bit_stuck is of type Boolean"),
            ("bit_torque", "c_b", "c_b is no input"),
            ("bit_torque", "G", "G is no input"),
            ("bit_torque", "bit_speed", "bit_speed is no input"),
            ("bit_torque", "cells", "variable cells is of type Integer"),
        ):
            assert ask(plant, unknown, known) == ERROR
            assert plant.messages[-1].text == f"plant at t = 1 s: fmi2GetDirectionalDerivative: {sentence}"
        for seed in (nan, inf):
            assert ask(plant, "top_speed", "Omega", seed) == ERROR
            assert plant.messages[-1].text.endswith("top_speed has no finite derivative in that direction")
        plant.go(2.0)


def test_a_known_that_is_not_real_contributes_nothing_with_seed_zero():
    """As when a tool passes all that InitialUnknowns lists for Omega, `form` among it."""
    with Instance("DissipativeLaw") as law:
        must(law, law.set(top_speed=9.0, bit_speed=7.0))
        must(law, law.call("EnterInitializationMode"))
        knowns = law.references(["top_speed", "form", "c_1"])
        change = c_double()
        seeds = (c_double * 3)(1.0, 0.0, 0.0)
        must(law, law.call("GetDirectionalDerivative", law.references(["Omega"]), 1, knowns, 3, seeds, byref(change)))
        assert change.value == law.sensitivity("Omega", top_speed=1.0) != 0.0
        assert ask(law, "Omega", "form", 0.0) == OK
        assert ask(law, "Omega", "form", 1.0) == ERROR
        assert law.messages[-1].text.endswith("variable form is of type Enumeration")


def test_in_initialization_mode_outputs_are_no_knowns_and_parameters_must_fit():
    with Instance(PLANT) as plant:
        must(plant, plant.call("EnterInitializationMode"))
        assert ask(plant, "bit_torque", "bit_speed") == ERROR
        assert plant.messages[-1].text.endswith("bit_speed is no input and no parameter")
        assert ask(plant, "bit_torque", "c_b") == OK
        must(plant, plant.set(mu_sb=0.1))
        assert ask(plant, "bit_torque", "c_b") == ERROR
        assert plant.messages[-1].text.endswith("mu_sb is 0.1; expected at least mu_cb = 0.5")


def test_a_root_that_begins_at_zero_has_no_derivative():
    with Instance("DissipativeLaw") as law:
        must(law, law.set(c_b=0.0, top_speed=9.0, bit_speed=7.0))
        must(law, law.call("EnterInitializationMode"))
        assert ask(law, "Omega", "c_b") == ERROR
        assert law.messages[-1].text.endswith("Omega has no finite derivative in that direction")
        assert law.sensitivity("Omega", bit_speed=1.0) == 0.0


def test_a_model_without_inputs_provides_none():
    with Drive("DrillingProgram", {}) as program:
        assert not program.library.description.coSimulation.providesDirectionalDerivative
        assert ask(program, "WOB", "c_b") == ERROR
        with Instance("DrillingProgram") as fresh:
            must(fresh, fresh.call("EnterInitializationMode"))
            assert ask(fresh, "WOB", "c_b") == ERROR
            assert fresh.messages[-1].text.endswith("is not provided: DrillingProgram has no inputs")


@pytest.mark.parametrize("model", DRIVEN)
def test_the_description_promises_them(model):
    with Drive(model, {}) as fmu:
        assert fmu.library.description.coSimulation.providesDirectionalDerivative
        jacobian = np.array(
            [[fmu.sensitivity(y, **{u: 1.0}) for u in names_of(fmu, "input")] for y in names_of(fmu, "output")]
        )
        assert np.isfinite(jacobian).all()
        assert fmu.call("Terminate") == OK
        assert ask(fmu, names_of(fmu, "output")[0], names_of(fmu, "input")[0]) == OK


@pytest.mark.parametrize("model", DRIVEN)
def test_asking_changes_nothing(model):
    with Drive(model, {}) as asked, Drive(model, {}) as other:
        for end in (1.0, 3.4, 5.0):
            asked.go(end)
            other.go(end)
            orders = (c_int * 1)(1)
            for output in names_of(asked, "output"):
                asked.call("GetRealOutputDerivatives", asked.references([output]), 1, orders, byref(c_double()))
                for name in names_of(asked, "input"):
                    asked.sensitivity(output, **{name: 1.0})
            assert asked.outputs() == other.outputs()
            assert asked.serialized() == other.serialized()
