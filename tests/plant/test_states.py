"""A saved state holds everything: going on from it repeats the same bits, in this process and in another."""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from ctypes import byref, c_void_p, create_string_buffer
from pathlib import Path

import pytest

from fmu_src.fmus import MODELS
from tests.plant.calls import TUNABLE
from tests.plant.drive import PLANT, PLANTS, Drive
from tests.plant.fmi import OK, Instance, must
from tests.plant.moments import LATER, MOMENTS, PACKAGINGS, SLOW, continued, drive_to

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("model", PLANTS)
def test_restored_state_repeats_the_same_bits(model, packaging, moment):
    with drive_to(MOMENTS[moment], packaging, model) as plant:
        begin, before, state = plant.time, plant.outputs(), plant.saved()
        first = continued(plant)
        for _ in range(2):
            must(plant, plant.call("SetFMUstate", state))
            plant.time = begin
            assert plant.outputs() == before
            assert continued(plant) == first
        must(plant, plant.call("FreeFMUstate", byref(state)))


@pytest.mark.parametrize("omega", [10.0, -10.0])
@pytest.mark.parametrize("event", ["last_stop_time", "last_release_time"])
@pytest.mark.parametrize("after", [-1e-4, 1e-7, 1e-4])
def test_state_close_to_an_event_repeats_the_same_bits(omega, event, after):
    with Drive(PLANT, SLOW | {"Omega": omega}) as ahead, Drive(PLANT, SLOW | {"Omega": omega}) as plant:
        ahead.go(8.0)
        plant.go(ahead.get(event) + after)
        begin, state = plant.time, plant.serialized()
        first = continued(plant)
        assert plant.restore(state) == OK
        plant.time = begin
        assert continued(plant) == first
        assert ahead.restore(state) == OK
        ahead.time = begin
        assert continued(ahead) == first


def test_moments_are_what_they_are_called():
    seen = {}
    for moment, time in MOMENTS.items():
        with drive_to(time) as plant:
            seen[moment] = plant.named()
    assert seen["while the bit waits for the first wave"]["bit_torque"] == 0.0
    assert seen["while the bit is stuck"]["bit_stuck"] == 1
    assert seen["while the bit slips"]["bit_stuck"] == 0
    assert seen["while the bit slips"]["bit_speed"] > 1.0
    assert seen["long after"]["slip_count"] >= 3


def in_a_fresh_process(fmu: Drive, packaging: str, tmp_path: Path, ends: list[float]) -> list[list[float]]:
    """Return the outputs at times after the present one, as a process of its own computes them from the saved state."""
    task = {
        "model": fmu.library.description.modelName,
        "packaging": packaging,
        "state": fmu.serialized().hex(),
        "time": fmu.time.hex(),
        "ends": [end.hex() for end in ends],
    }
    file = tmp_path / "task.json"
    file.write_text(json.dumps(task))
    done = subprocess.run(
        [sys.executable, "-m", "tests.plant.replay", str(file)], capture_output=True, text=True, cwd=ROOT, check=True
    )
    return [[float.fromhex(value) for value in row] for row in json.loads(done.stdout)]


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("model", PLANTS)
def test_state_restored_in_a_fresh_process_repeats_the_same_bits(model, packaging, moment, tmp_path):
    with drive_to(MOMENTS[moment], packaging, model) as plant:
        rows = in_a_fresh_process(plant, packaging, tmp_path, [plant.time + after for after in LATER])
        assert continued(plant, changes=False) == rows


MOVING = {
    "DrillingProgram": {"speed_final": 20.0, "speed_duration": 3.0},
    "SpeedSupervisor": {"window": 0.25},
}
"""What lets the outputs of those move within seconds that do not by their start values."""


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_state_restored_in_a_fresh_process_goes_on_along_derivatives_that_are_set(model, tmp_path):
    with Drive(model, MOVING.get(model, {})) as fmu:
        fmu.go(0.7)
        inputs = [variable.name for variable in MODELS[model].select("input") if variable.kind == "Real"]
        must(fmu, fmu.set_slopes(**dict.fromkeys(inputs, 3.0)) if inputs else OK)
        ends = [1.0, 1.5, 4.25]
        rows = in_a_fresh_process(fmu, "native", tmp_path, ends)
        for end, row in zip(ends, rows, strict=True):
            fmu.go(end)
            assert fmu.outputs() == row
        assert rows[0] != rows[1]


def test_state_goes_to_another_instance_with_other_parameters():
    with drive_to(3.2) as plant, Drive(PLANT, {"cells": 200, "L": 2000.0, "initial_speed": 3.0}) as other:
        state = plant.serialized()
        assert other.restore(state) == OK
        other.time = plant.time
        assert other.outputs() == plant.outputs()
        assert continued(other) == continued(plant)


def test_a_step_can_be_repeated_from_a_state_with_other_inputs():
    # as a master does that looks for the inputs that fit
    with drive_to(3.2) as plant:
        begin, state, seen = plant.time, plant.saved(), []
        for drive in (9.5, 12.0, 9.5):
            must(plant, plant.call("SetFMUstate", state))
            plant.time = begin
            plant.put(Omega=drive)
            plant.go(begin + 0.9)
            seen.append(plant.outputs())
        assert seen[0] == seen[2] != seen[1]
        # a state pointer is used again, not leaked, when it is handed in
        must(plant, plant.call("GetFMUstate", byref(state)))
        must(plant, plant.call("FreeFMUstate", byref(state)))
        assert state.value is None


@pytest.mark.parametrize("model", PLANTS)
def test_equal_states_have_equal_bytes(model):
    with drive_to(3.2, model=model) as one, drive_to(3.2, model=model) as other:
        state = one.serialized()
        assert state == other.serialized()
        continued(one)
        assert one.serialized() != state
        assert one.restore(state) == OK
        assert one.serialized() == state


@pytest.mark.parametrize("model", sorted(MODELS.keys() - {*PLANTS}))
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_laws_and_program_repeat_the_same_bits(model, packaging):
    start = {"speed_final": 20.0, "speed_duration": 3.0} if model == "DrillingProgram" else {}
    with Drive(model, start, packaging) as fmu:
        fmu.go(0.5)
        state, rows = fmu.serialized(), []
        for _ in range(2):
            assert fmu.restore(state) == OK
            fmu.time = 0.5
            for variable in MODELS[model].select("input"):
                fmu.put(**{variable.name: False if variable.kind == "Boolean" else 7.0})
            fmu.go(1.25)
            rows.append(fmu.outputs())
        assert rows[0] == rows[1]


def test_state_in_memory_goes_to_another_instance_and_outlives_its_own():
    # the standard does not say whether it may; a copy of a whole instance fits any instance of the same FMU
    with drive_to(3.2) as plant, Drive(PLANT, {"cells": 200, "L": 2000.0}) as other:
        state, begin, rows = plant.saved(), plant.time, continued(plant)
        plant.free()
        must(other, other.call("SetFMUstate", state))
        other.time = begin
        assert continued(other) == rows
        must(other, other.call("FreeFMUstate", byref(state)))


def test_a_state_can_be_serialised_in_threads():
    with drive_to(3.2) as plant, ThreadPoolExecutor(4) as pool:
        content, state = plant.serialized(), plant.saved()

        def serialised(_: int) -> bytes:
            room = create_string_buffer(len(content))
            must(plant, plant.call("SerializeFMUstate", state, room, len(content)))
            return room.raw

        assert set(pool.map(serialised, range(100))) == {content}
        must(plant, plant.call("FreeFMUstate", byref(state)))


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("model", MODELS)
def test_reset_brings_back_the_start(model, packaging):
    with Drive(model, {}, packaging) as fmu:
        start = {name: fmu.get(name) for name in fmu.variables if fmu.kind(name) != "String"}
        fmu.put(**{TUNABLE[model]: 0.5})
        if model not in PLANTS:
            for variable in MODELS[model].select("input"):
                fmu.put(**{variable.name: False if variable.kind == "Boolean" else 3.0})
        fmu.go(3.0)
        assert {name: fmu.get(name) for name in start} != start
        must(fmu, fmu.call("Reset"))
        must(fmu, fmu.initialize())
        assert {name: fmu.get(name) for name in start} == start
        fmu.time = 0.0
        fmu.go(3.0)
        with Drive(model, {}, packaging) as fresh:
            fresh.go(3.0)
            assert fmu.outputs() == fresh.outputs()


def test_states_can_be_had_at_any_time_of_life():
    with Instance(PLANT) as plant:
        plant.set(L=700.0)
        early = plant.saved()
        plant.set(L=900.0)
        must(plant, plant.call("SetFMUstate", early))
        must(plant, plant.call("FreeFMUstate", byref(early)))
        must(plant, plant.initialize())
        assert plant.get("L") == 700.0
        ready = plant.saved()
        plant.step(0.0, 1.0)
        must(plant, plant.call("Terminate"))
        must(plant, plant.call("SetFMUstate", ready))
        assert plant.step(0.0, 1.0) == OK
        must(plant, plant.call("Reset"))
        must(plant, plant.call("SetFMUstate", ready))
        assert plant.step(0.0, 1.0) == OK
        must(plant, plant.call("FreeFMUstate", byref(ready)))
        assert plant.call("FreeFMUstate", byref(c_void_p())) == OK
