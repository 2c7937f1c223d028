"""A saved state holds everything: going on from it repeats the same bits, in this process and in another."""

from __future__ import annotations

import json
import subprocess
import sys
from ctypes import byref, c_void_p
from pathlib import Path

import pytest

from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, Instance, must

ROOT = Path(__file__).parents[2]
MOMENTS = {
    # Fig. 2 with jumps of the inputs on the way
    "at the start": 0.0,
    "while the bit waits for the first wave": 0.123456,
    "while the bit is stuck": 1.8,
    "while the bit slips": 3.4567891,
    "long after": 60.0001,
}
PACKAGINGS = ("native", "python")
LATER = [0.001, 0.31, 0.3100001, 2.9, 9.0]
SLOW = {"cells": 60}


def drive_to(time: float, packaging: str = "native") -> Drive:
    """Return the plant after jumps of both inputs, one of them just before the given time."""
    plant = Drive(PLANT, SLOW, packaging)
    for at, change in ((0.3 * time, {"Omega": 11.0}), (0.9 * time, {"WOB": 9e4}), (0.999 * time, {"Omega": 9.5})):
        if at > 0:
            plant.go(at)
            plant.put(**change)
    if time > 0:
        plant.go(time)
    return plant


def continued(plant: Drive, changes: bool = True) -> list[list[float]]:
    """Return the outputs from here on, with an input that jumps."""
    begin, rows = plant.time, []
    for number, after in enumerate(LATER):
        if changes and number == 2:
            plant.put(WOB=1.1e5)
        plant.go(begin + after)
        rows.append(plant.outputs())
    return rows


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_restored_state_repeats_the_same_bits(packaging, moment):
    with drive_to(MOMENTS[moment], packaging) as plant:
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


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_state_restored_in_a_fresh_process_repeats_the_same_bits(packaging, moment, tmp_path):
    with drive_to(MOMENTS[moment], packaging) as plant:
        begin = plant.time
        task = {"model": PLANT, "packaging": packaging, "state": plant.serialized().hex(), "time": begin.hex()}
        rows = continued(plant, changes=False)
    task["ends"] = [(begin + after).hex() for after in LATER]
    file = tmp_path / "task.json"
    file.write_text(json.dumps(task))
    done = subprocess.run(
        [sys.executable, "-m", "tests.plant.replay", str(file)], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert [[float.fromhex(value) for value in row] for row in json.loads(done.stdout)] == rows


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


def test_equal_states_have_equal_bytes():
    with drive_to(3.2) as one, drive_to(3.2) as other:
        state = one.serialized()
        assert state == other.serialized()
        continued(one)
        assert one.serialized() != state
        assert one.restore(state) == OK
        assert one.serialized() == state


@pytest.mark.parametrize("model", ["DissipativeLaw", "WeightOnBitLaw", "DrillingProgram"])
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_laws_and_program_repeat_the_same_bits(model, packaging):
    start = {"speed_final": 20.0, "speed_duration": 3.0} if model == "DrillingProgram" else {}
    with Drive(model, start, packaging) as fmu:
        fmu.go(0.5)
        state, rows = fmu.serialized(), []
        for _ in range(2):
            assert fmu.restore(state) == OK
            fmu.time = 0.5
            if "bit_speed" in fmu.variables:
                fmu.put(bit_speed=7.0)
            fmu.go(1.25)
            rows.append(fmu.outputs())
        assert rows[0] == rows[1]


@pytest.mark.parametrize("place", [0, 5, 40, 50, 57, 65, 200, 5000, -1])
def test_a_flipped_byte_is_refused_and_changes_nothing(place):
    with drive_to(3.2) as plant, drive_to(3.2) as untouched:
        damaged = bytearray(plant.serialized())
        damaged[place] ^= 0x10
        assert plant.restore(bytes(damaged)) == ERROR
        assert plant.messages[-1].status == ERROR
        assert "plant at t = 3.2 s: the serialised state is" in plant.messages[-1].text
        assert continued(plant) == continued(untouched)


@pytest.mark.parametrize("length", [0, 1, 47, 48, 100, 2000, -1])
def test_a_state_cut_off_is_refused_and_changes_nothing(length):
    with drive_to(3.2) as plant, drive_to(3.2) as untouched:
        content = plant.serialized()
        assert plant.restore(content[:length]) == ERROR
        assert plant.restore(content + b"\0") == ERROR
        assert all("the serialised state is" in message.text for message in plant.messages)
        assert continued(plant) == continued(untouched)


def test_state_of_another_model_is_refused():
    with drive_to(1.0) as plant, Drive("WeightOnBitLaw", {}) as law:
        assert plant.restore(law.serialized()) == ERROR
        assert law.restore(plant.serialized()) == ERROR
        assert law.messages[-1].text.endswith("the serialised state is not one of this build of WeightOnBitLaw")
        plant.go(2.0)


def test_state_in_memory_of_another_model_is_refused():
    with Drive(PLANT, SLOW) as plant, Drive("WeightOnBitLaw", {}) as law:
        plant.go(1.0)
        state = plant.saved()
        assert law.call("SetFMUstate", state) == ERROR
        assert law.named()["WOB"] == 97347.0
        must(plant, plant.call("FreeFMUstate", byref(state)))


@pytest.mark.parametrize("damage", ["cut", "flipped", "foreign"])
def test_python_packaging_takes_no_step_after_a_broken_state_until_it_is_mended(damage):
    # pythonfmu cannot refuse the call itself, so the step is refused
    with Drive(PLANT, SLOW, "python", logging=True) as plant, Drive("WeightOnBitLaw", {}, "python") as law:
        plant.go(3.2)
        good = plant.serialized()
        flipped = good.replace(b'"phase"', b'"phrase"')
        bad = {"cut": good[:-9], "flipped": flipped, "foreign": law.serialized()}[damage]
        begin, before = plant.time, plant.outputs()
        plant.restore(bad)
        assert plant.outputs() == before
        assert plant.step(begin, 0.1) == DISCARD
        assert plant.messages[-1].status == DISCARD
        assert plant.restore(good) == OK
        assert plant.step(begin, 0.1) == OK


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("model", [PLANT, "DissipativeLaw", "WeightOnBitLaw", "DrillingProgram"])
def test_reset_brings_back_the_start(model, packaging):
    with Drive(model, {}, packaging) as fmu:
        start = {name: fmu.get(name) for name in fmu.variables if fmu.kind(name) != "String"}
        fmu.put(**{"c_b": 20.0} if "c_b" in fmu.variables else {"K_w": 20.0})
        if "bit_speed" in fmu.variables and model != PLANT:
            fmu.put(bit_speed=3.0)
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
