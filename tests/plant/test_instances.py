"""Many instances side by side, and what they say to the logger."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from ctypes import c_char_p

import numpy as np
import pytest

from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, Instance, must
from tests.plant.programs import solved

SLOW = {"cells": 60}
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


def test_stops_and_releases_are_told_in_order_with_their_times():
    with Drive(PLANT, SLOW, logging=True) as plant:
        for k in range(1, 61):
            plant.go(0.1 * k)
    texts = [message.text for message in plant.messages]
    assert {(message.status, message.category) for message in plant.messages} == {(OK, "logEvents")}
    solution = solved("stick-slip of figure 2")
    events = [(time, "breaks loose") for time in solution.releases] + [(time, "sticks") for time in solution.stops]
    assert len(texts) == 5
    for text, (time, what) in zip(texts, sorted(events), strict=False):
        told = re.search(r"the bit (breaks loose|sticks) at t = ([\d.]+) s", text)
        assert told
        assert told[1] == what
        assert float(told[2]) == pytest.approx(time, abs=1e-5)


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_without_logging_no_events_are_told(packaging):
    with Drive(PLANT, SLOW, packaging) as plant:
        plant.go(6.0)
        assert plant.messages == []


def test_log_categories_are_those_of_the_description():
    with Instance(PLANT) as plant:
        assert [category.name for category in plant.library.description.logCategories] == CATEGORIES
        for category in CATEGORIES:
            assert plant.call("SetDebugLogging", 1, 1, (c_char_p * 1)(category.encode())) == OK
        assert plant.call("SetDebugLogging", 1, 1, (c_char_p * 1)(b"logWeather")) == ERROR
        assert 'there is no log category "logWeather"' in plant.messages[-1].text


@pytest.mark.parametrize(("category", "told"), [("logEvents", True), ("logAll", True), ("logStatusError", False)])
def test_log_categories_can_be_chosen(category, told):
    with Drive(PLANT, SLOW) as plant:
        must(plant, plant.call("SetDebugLogging", 1, 1, (c_char_p * 1)(category.encode())))
        plant.go(3.0)
        assert bool(plant.messages) == told
        plant.messages.clear()
        must(plant, plant.call("SetDebugLogging", 0, 0, None))
        plant.go(6.0)
        assert plant.messages == []
