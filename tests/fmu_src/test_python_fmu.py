"""The python packaging through the front door: pythonfmu's library in an FMU, loaded by fmpy."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from math import nan
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi1 import FMICallException

from tests.fmu_src.conftest import Instance, build_gauge
from tests.fmu_src.gauge import COUNT, LABEL, LIMIT, OFFSET, RATE, TOTAL

Make = Callable[..., Instance]


def status(call: Callable[..., object], *arguments: object) -> int:
    try:
        call(*arguments)
    except FMICallException as error:
        return error.status
    return 0


def test_a_run_adds_up(gauge_fmu: Path, instantiate: Make) -> None:
    gauge = instantiate(gauge_fmu, "one")
    gauge.setString([LABEL], ["étiquette"])
    gauge.setReal([OFFSET], [1.0])
    gauge.initialize(start=2.0)
    gauge.setReal([RATE], [3.0])
    gauge.doStep(2.0, 0.5)
    assert gauge.getReal([TOTAL]) == [2.5]
    assert gauge.getInteger([COUNT]) == [1]
    assert gauge.getString([LABEL]) == ["étiquette".encode()]
    gauge.terminate()
    assert gauge.logged == []


def test_nothing_the_importer_does_wrong_is_fatal(gauge_fmu: Path, instantiate: Make) -> None:
    gauge = instantiate(gauge_fmu, "one")
    gauge.initialize()
    gauge.setReal([RATE], [nan])
    gauge.getReal([0xFFFFFFFF])
    gauge.setInteger([TOTAL], [3])
    assert status(gauge.doStep, 0.0, 1.0) == 2
    assert {message[1:3] for message in gauge.logged} == {(2, "logStatusDiscard"), (3, "logStatusError")}
    gauge.reset()
    gauge.initialize()
    gauge.doStep(0.0, 1.0)
    assert gauge.getReal([TOTAL]) == [1.5]


def test_a_refused_step_can_be_repeated(gauge_fmu: Path, instantiate: Make) -> None:
    gauge = instantiate(gauge_fmu, "one")
    gauge.initialize()
    assert status(gauge.doStep, 0.0, 6.0) == 2
    assert gauge.logged[-1] == (
        "one", 2, "logStatusDiscard", "one at t = 0.0 s: a step above 5 s cannot be taken (100 %%)",
    )  # fmt: skip
    gauge.doStep(0.0, 1.0)
    assert gauge.getReal([TOTAL]) == [1.5]


def test_a_saved_state_holds_what_is_no_variable(gauge_fmu: Path, instantiate: Make) -> None:
    gauge = instantiate(gauge_fmu, "one")
    gauge.initialize()
    gauge.setReal([RATE], [0.1])
    gauge.doStep(0.0, 0.3)
    state = gauge.getFMUstate()
    text = gauge.serializeFMUstate(state)
    gauge.doStep(0.3, 0.7)
    after = gauge.getReal([TOTAL, RATE, LIMIT])
    for saved in (state, gauge.deSerializeFMUstate(text)):
        gauge.setFMUstate(saved)
        gauge.doStep(0.3, 0.7)
        assert gauge.getReal([TOTAL, RATE, LIMIT]) == after
        gauge.freeFMUstate(saved)


def test_a_broken_state_is_refused_and_a_good_one_still_restored(gauge_fmu: Path, instantiate: Make) -> None:
    gauge = instantiate(gauge_fmu, "one")
    gauge.initialize()
    good = gauge.getFMUstate()
    gauge.setFMUstate(gauge.deSerializeFMUstate(b"[" * 100000))
    assert status(gauge.doStep, 0.0, 1.0) == 2
    gauge.setFMUstate(good)
    gauge.doStep(0.0, 1.0)


@pytest.mark.slow
def test_instances_come_and_go(gauge_fmu: Path) -> None:
    folder = fmpy.extract(str(gauge_fmu))
    for number in range(100):
        gauge = Instance(folder, f"gauge {number}")
        gauge.initialize()
        gauge.doStep(0.0, 1.0)
        assert gauge.getReal([TOTAL]) == [1.5]
        gauge.terminate()
        gauge.fmi2FreeInstance(gauge.component)
        if number % 10 == 0:
            gc.collect()  # which takes a while where other tests have left much


def test_the_path_of_the_importer_stays_as_it_was(gauge_fmu: Path, instantiate: Make) -> None:
    before = list(sys.path)
    instantiate(gauge_fmu, "one")
    instantiate(gauge_fmu, "two")
    assert sys.path == before


def test_two_versions_of_a_model_run_their_own_code(gauge_fmu: Path, instantiate: Make, tmp_path: Path) -> None:
    edited = tmp_path / "gauge.py"
    source = Path(__file__).with_name("gauge.py").read_text()
    edited.write_text(source.replace("values[RATE] * step_size", "2.0 * values[RATE] * step_size"))
    other_fmu = build_gauge(tmp_path / "other", edited)
    first, second = instantiate(gauge_fmu, "first"), instantiate(other_fmu, "second")
    for gauge in (first, second):
        gauge.initialize()
        gauge.doStep(0.0, 1.0)
    assert (first.getReal([TOTAL]), second.getReal([TOTAL])) == ([1.5], [2.5])
    assert first.guid != second.guid
