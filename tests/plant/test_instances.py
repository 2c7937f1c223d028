"""Many instances side by side, and what they say to the logger."""

from __future__ import annotations

import re
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from ctypes import c_char_p
from multiprocessing import get_context

import numpy as np
import pytest

from fmu_src.fmus import MODELS
from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, WARNING, Instance, must
from tests.plant.programs import solved

SLOW = {"cells": 60}
PACKAGINGS = ("native", "python")
CATEGORIES = ["logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError", "logAll"]


def course(number: int) -> list[list[float]]:
    """Return the outputs of one of several different runs."""
    rows = []
    with Drive(PLANT, SLOW | {"L": 800.0 + 150.0 * (number % 3)}, name=f"plant {number}") as plant:
        for k in range(1, 120):
            plant.put(Omega=10.0 + np.sin(0.1 * k + number % 3))
            plant.go(0.1 * k)
            rows.append(plant.outputs())
    return rows


def test_instances_that_take_turns_do_not_disturb_each_other():
    alone = [course(number) for number in range(3)]
    plants = [Drive(PLANT, SLOW | {"L": 800.0 + 150.0 * number}) for number in range(3)]
    for k in range(1, 120):
        for number, plant in enumerate(plants):
            plant.put(Omega=10.0 + np.sin(0.1 * k + number))
            plant.go(0.1 * k)
            assert plant.outputs() == alone[number][k - 1]
    for plant in plants:
        plant.free()


def test_instances_in_threads_give_the_same_bits():
    alone = [course(number) for number in range(3)]
    with ThreadPoolExecutor(6) as pool:
        runs = list(pool.map(course, range(18)))
    assert all(run == alone[number % 3] for number, run in enumerate(runs))


def test_instances_in_processes_give_the_same_bits():
    alone = [course(number) for number in range(3)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(course, range(3))) == alone


def law_course(number: int) -> list[float]:
    """Return the outputs of one of several runs of a law, with its rates."""
    rows = []
    with Drive("DissipativeLaw", {"c_b": 15.0, "c_1": 0.1 * (number % 5)}, name=f"law {number}") as law:
        for k in range(1, 300):
            must(law, law.set_slopes(top_speed=np.cos(0.1 * k), bit_speed=0.5))
            law.go(0.1 * k)
            rows += [law.get("Omega"), law.rate("Omega"), law.sensitivity("Omega", top_speed=1.0)]
    return rows


def test_laws_in_threads_give_the_same_bits():
    alone = [law_course(number) for number in range(5)]
    with ThreadPoolExecutor(6) as pool:
        runs = list(pool.map(law_course, range(20)))
    assert all(run == alone[number % 5] for number, run in enumerate(runs))


def test_a_thousand_instances_live_at_once():
    plants = [Drive(PLANT, {"cells": 8}) for _ in range(1000)]
    for plant in plants:
        plant.go(3.0)
    rows = [plant.outputs() for plant in plants]
    for plant in plants:
        plant.free()
    assert all(row == rows[0] for row in rows)


def test_messages_name_instance_and_time():
    with Drive(PLANT, SLOW, name="rig 7 (100 %d)") as plant:
        plant.go(12.4)
        assert plant.set(WOB=-1.0) == DISCARD
        assert plant.messages[-1] == (
            "rig 7 (100 %d)", DISCARD, "logStatusDiscard",
            "rig 7 (100 %d) at t = 12.4 s: WOB is -1 N; expected a finite value in [0, 100000000]",
        )  # fmt: skip


def test_long_names_are_cut_in_messages_only():
    name = "n" * 5000
    with Drive(PLANT, SLOW, name=name) as plant:
        assert plant.set(WOB=-1.0) == DISCARD
        assert plant.messages[-1].instance == name
        assert plant.messages[-1].text.startswith("nnnn")
        assert "WOB is -1 N" in plant.messages[-1].text


def test_names_of_any_script_are_cut_between_characters():
    for name in ("ö" * 40, "井" * 40, "a" + "ö" * 40, "😀" * 40):
        with Drive(PLANT, SLOW, name=name) as plant:
            assert plant.set(WOB=-1.0) == DISCARD
            shown = plant.messages[-1].text.partition(" at t = ")[0]
            assert name.startswith(shown)
            assert 60 < len(shown.encode()) <= 64


def test_a_number_sign_is_doubled_in_messages():
    # by itself it would begin a reference to a variable: FMI 2.0.4, section 2.1.5
    with Drive(PLANT, SLOW, name="rig #r0#") as plant:
        assert plant.set(WOB=-1.0) == DISCARD
        assert plant.messages[-1].instance == "rig #r0#"
        assert plant.messages[-1].text.startswith("rig ##r0## at t = 0 s: ")


def told_events(fmu: Instance) -> list[tuple[float, str]]:
    """Return the times and sentences of the events an instance called x has told."""
    matches = [re.fullmatch(r"x at t = (\S+) s: (.*)", message.text) for message in fmu.messages]
    assert {(message.status, message.category) for message in fmu.messages} <= {(OK, "logEvents")}
    return [(float(match[1]), match[2]) for match in matches if match]


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("step", [0.1, 6.0])
def test_stops_and_releases_are_told_in_order_with_their_times(step, packaging):
    solution = solved("stick-slip of figure 2")
    events = [(time, f"the bit breaks loose, release number {1 + k}") for k, time in enumerate(solution.releases)]
    events += [(time, "the bit sticks") for time in solution.stops]
    due = [event for event in sorted(events) if event[0] < 6.0]
    assert len(due) == 5
    with Drive(PLANT, SLOW, packaging, name="x", logging=True) as plant:
        for k in range(1, round(6.0 / step) + 1):
            plant.go(step * k)
        told = told_events(plant)
    if step == 6.0:  # of several in one step, the last
        due = due[-2:]
    assert [sentence for _, sentence in told] == [sentence for _, sentence in due]
    assert [time for time, _ in told] == pytest.approx([time for time, _ in due], abs=1e-5)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_bit_that_cannot_be_held_is_told_to_break_loose_at_the_start(packaging):
    with Drive(PLANT, SLOW | {"initial_torque": 2e4}, packaging, -3.5, name="x", logging=True) as plant:
        assert plant.get("slip_count") == 1
        plant.go(-3.0)
        assert told_events(plant) == [(-3.5, "the bit breaks loose, release number 1")]


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_guard_and_limit_of_the_drive_law_are_told_when_they_switch(packaging):
    start = {"top_speed": 12.0, "bit_speed": 8.0}
    with Drive("DissipativeLaw", start, packaging, name="x", logging=True) as law:
        for k, top_speed in enumerate((12.0, 0.001, 0.002, 3.0, 3.0, 12.0), start=1):
            law.put(top_speed=top_speed)
            law.go(0.5 * k)
        assert told_events(law) == [
            (1.0, "the divisor of Omega is held at top_speed_min"),
            (1.0, "Omega is held at its limit"),
            (2.0, "the divisor of Omega is the top speed again"),
            (3.0, "Omega is off its limit again"),
        ]


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_limit_of_the_weight_is_told_when_it_switches(packaging):
    with Drive("WeightOnBitLaw", {}, packaging, name="x", logging=True) as law:
        for k, bit_speed in enumerate((30.0, 50.0, -60.0, 30.0), start=1):
            law.put(bit_speed=bit_speed)
            law.go(0.5 * k)
        assert told_events(law) == [(1.0, "WOB is held at its limit"), (2.0, "WOB is off its limit again")]


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_the_first_break_that_is_folded_is_a_warning(packaging):
    with Drive(PLANT, {"cells": 4, "L": 300.0}, packaging, name="x", logging=True) as plant:
        for k in range(1, 700):
            plant.put(Omega=10.0 + 5.0 * np.sin(37.0 * k))
            plant.go(0.001 * k)
            if plant.get("breaks_folded") > 0:
                break
        plant.go(plant.time + 0.5)
        (warning,) = (message for message in plant.messages if message.category == "logStatusWarning")
        time = f"{0.001 * k:.9g}" if packaging == "native" else repr(0.001 * k)
        sentence = "more breaks are under way than can be kept: the weakest are folded"
        assert warning == ("x", WARNING, "logStatusWarning", f"x at t = {time} s: {sentence}")


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_without_logging_no_events_are_told(packaging):
    with Drive(PLANT, SLOW, packaging) as plant:
        plant.go(6.0)
        assert plant.messages == []


def switch(fmu: Instance, on: bool, *categories: str) -> int:
    """Switch log categories on or off, all of them if none is named."""
    names = (c_char_p * len(categories))(*[category.encode() for category in categories])
    return fmu.call("SetDebugLogging", int(on), len(categories), names if categories else None)


def test_log_categories_are_those_of_the_description():
    for model in MODELS:
        with Instance(model) as fmu:
            assert [category.name for category in fmu.library.description.logCategories] == CATEGORIES
            for category in CATEGORIES:
                assert switch(fmu, True, category) == OK
            assert switch(fmu, True, "logWeather") == ERROR
            assert 'there is no log category "logWeather"' in fmu.messages[-1].text


def told_categories(plant: Drive) -> list[str]:
    """Let an event happen, have a value refused and make an illegal call; return the categories of what is told."""
    plant.go(3.0)
    assert plant.set(WOB=-1.0) == DISCARD
    assert plant.set(bit_speed=1.0) == ERROR
    return [message.category for message in plant.messages]


@pytest.mark.parametrize(
    ("logging", "switches", "told"),
    [
        # refusals are told unless they are switched off, errors always
        (False, [], ["logStatusDiscard", "logStatusError"]),
        (True, [], ["logEvents", "logStatusDiscard", "logStatusError"]),
        (False, [(True, "logEvents")], ["logEvents", "logStatusDiscard", "logStatusError"]),
        (False, [(True, "logAll")], ["logEvents", "logStatusDiscard", "logStatusError"]),
        (False, [(True,)], ["logEvents", "logStatusDiscard", "logStatusError"]),
        (True, [(False, "logEvents")], ["logStatusDiscard", "logStatusError"]),
        (True, [(False, "logStatusDiscard", "logStatusWarning")], ["logEvents", "logStatusError"]),
        (True, [(False, "logAll")], ["logStatusError"]),
        (True, [(False,)], ["logStatusError"]),
        (True, [(False,), (True, "logEvents")], ["logEvents", "logStatusError"]),
    ],
)
def test_log_categories_can_be_chosen(logging, switches, told):
    with Drive(PLANT, SLOW, logging=logging) as plant:
        for on, *categories in switches:
            assert switch(plant, on, *categories) == OK
        assert told_categories(plant) == told


def test_an_unknown_category_switches_none_of_those_named_with_it():
    with Drive(PLANT, SLOW) as plant:
        assert switch(plant, True, "logEvents", "logWeather") == ERROR
        plant.messages.clear()
        assert told_categories(plant) == ["logStatusDiscard", "logStatusError"]
