"""A saved state that is damaged, cut off, or of something else is refused, and nothing has changed."""

from __future__ import annotations

from ctypes import byref, c_size_t, create_string_buffer

import pytest

from fmu_src.fmus import MODELS
from tests.plant.drive import PLANT, PLANTS, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, must
from tests.plant.moments import SLOW, continued, drive_to


@pytest.mark.parametrize("place", [0, 5, 50, 200, 5000, -1])
@pytest.mark.parametrize("model", PLANTS)
def test_a_flipped_byte_is_refused_and_changes_nothing(place, model):
    with drive_to(3.2, model=model) as plant, drive_to(3.2, model=model) as untouched:
        damaged = bytearray(plant.serialized())
        damaged[place] ^= 0x10
        assert plant.restore(bytes(damaged)) == ERROR
        assert plant.messages[-1].status == ERROR
        assert "plant at t = 3.2 s: the serialised state is" in plant.messages[-1].text
        assert continued(plant) == continued(untouched)


@pytest.mark.parametrize("model", MODELS)
def test_a_byte_flipped_anywhere_is_refused(model):
    with Drive(model, {"cells": 4} if model in PLANTS else {}) as fmu:
        fmu.go(0.5)
        content = fmu.serialized()
        everywhere = [*range(min(4000, len(content))), *range(4000, len(content), 61)]
        for place in everywhere:
            damaged = bytearray(content)
            damaged[place] ^= 1 << place % 8
            assert fmu.restore(bytes(damaged)) == ERROR, place
        assert len(fmu.messages) == len(everywhere)
        assert all(": the serialised state is " in message.text for message in fmu.messages)
        assert fmu.serialized() == content


def test_a_state_of_another_version_is_refused():
    # the GUID names the content of the FMU; the checksum does not cover it
    with Drive(PLANT, SLOW) as plant:
        plant.go(0.5)
        content = plant.serialized()
        guid = plant.library.description.guid.encode()
        other = guid[:-2] + (b"0" if guid[-2:-1] != b"0" else b"1") + guid[-1:]
        assert content.startswith(guid)
        assert plant.restore(other + content[len(other) :]) == ERROR
        assert plant.messages[-1].text.endswith("the serialised state is not one of this build of DrillstringNeutral")
        assert plant.serialized() == content


@pytest.mark.parametrize("length", [0, 1, 47, 48, 100, 2000, -1])
def test_a_state_cut_off_or_drawn_out_is_refused_and_changes_nothing(length):
    with drive_to(3.2) as plant, drive_to(3.2) as untouched:
        content = plant.serialized()
        assert plant.restore(content[:length]) == ERROR
        for more in (b"\0", content):
            assert plant.restore(content + more) == ERROR
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
        state, size = plant.saved(), c_size_t(7)
        assert law.call("SetFMUstate", state) == ERROR
        assert law.call("SerializedFMUstateSize", state, byref(size)) == ERROR
        assert law.call("SerializeFMUstate", state, create_string_buffer(9), 9) == ERROR
        assert all(message.text.endswith("not one of this build of WeightOnBitLaw") for message in law.messages)
        assert (law.named()["WOB"], size.value) == (97347.0, 7)
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
