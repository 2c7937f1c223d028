"""Every function in every state, as the table of FMI 2.0.4, section 4.2.4, allows it or not.

What is not allowed is fmi2Error with one sentence, and leaves the instance as it was. So does a step that is
discarded, and so does every error; therefore more is served after them than the standard asks for: all that could be
called before.
"""

from __future__ import annotations

from collections.abc import Iterator
from ctypes import byref, c_double
from typing import Any

import numpy as np
import pytest
from fmpy import fmi2

from fmu_src.fmus import MODELS
from tests.plant.calls import (
    ALLOWED,
    COMPLETE,
    EVER,
    IN_ERROR,
    INITIALIZATION,
    INSTANTIATED,
    NULL,
    START,
    TERMINATED,
    Objects,
    arguments,
    bring,
    due,
    saved,
)
from tests.plant.fmi import ERROR, OK, Instance, must


def prepared(model: str, state: str) -> Iterator[tuple[Instance, Objects]]:
    """Yield instances in a state, one for every call."""
    for _ in ALLOWED:
        with Instance(model) as fmu:
            for name, value in START[model].items():
                must(fmu, fmu.set(**{name: value}))
            bring(fmu, state)
            fmu.messages.clear()
            yield fmu, saved(fmu)


@pytest.mark.parametrize("state", sorted(EVER))
@pytest.mark.parametrize("model", MODELS)
def test_every_function_is_served_where_it_is_allowed_and_else_refused_without_a_trace(model, state):
    for function, (fmu, objects) in zip(ALLOWED, prepared(model, state), strict=True):
        status = fmu.call(function, *arguments(fmu, model, objects)[function])
        assert status == due(model, function, state), (function, fmu.messages)
        if status == OK:
            assert fmu.messages == [], function
            continue
        (message,) = fmu.messages
        assert message.status == status
        assert f": fmi2{function}" in message.text
        assert fmu.serialized() == objects.content, function
        if status == ERROR and "is not allowed while" in message.text:
            assert state == IN_ERROR or message.text.endswith(
                {
                    INSTANTIATED: "instantiated",
                    INITIALIZATION: "in initialization mode",
                    TERMINATED: "terminated",
                }.get(state, "stepping")
            )


@pytest.mark.parametrize("model", MODELS)
def test_a_reset_instance_is_as_if_it_were_new(model):
    for state in sorted(EVER):
        with Instance(model) as new, Instance(model) as fmu:
            for name, value in START[model].items():
                must(fmu, fmu.set(**{name: value}))
            bring(fmu, state)
            must(fmu, fmu.call("Reset"))
            assert fmu.serialized() == new.serialized()


@pytest.mark.parametrize("state", sorted(EVER))
@pytest.mark.parametrize("model", MODELS)
def test_an_instance_can_be_freed_in_every_state(model, state):
    with Instance(model) as fmu:
        bring(fmu, state)


class Walk:
    """A random walk through the state machine that knows what every call must answer."""

    def __init__(self, fmu: Instance, model: str, seed: int) -> None:
        self.fmu, self.model, self.random = fmu, model, np.random.default_rng(seed)
        self.state, self.time, self.kept = INSTANTIATED, 0.0, (INSTANTIATED, 0.0)
        self.objects = saved(fmu)

    def call(self, function: str) -> None:
        given = arguments(self.fmu, self.model, self.objects)[function]
        if function == "DoStep":
            given = (self.time, float(self.random.uniform(1e-4, 0.3)), 0)
        if function == "SetupExperiment":
            given = (0, 0.0, float(self.random.uniform(-5.0, 5.0)), 0, 0.0)
        status = self.fmu.call(function, *given)
        assert status == due(self.model, function, self.state), (function, self.state, self.fmu.messages[-3:])
        if status == OK:
            self._follow(function, given)

    def _follow(self, function: str, given: tuple[Any, ...]) -> None:
        """Go where a call leads that has succeeded."""
        leads = {
            "EnterInitializationMode": INITIALIZATION,
            "ExitInitializationMode": COMPLETE,
            "DoStep": COMPLETE,
            "Terminate": TERMINATED,
            "Reset": INSTANTIATED,
        }
        self.state = leads.get(function, self.state)
        if function == "Reset":
            self.time = 0.0
        if function == "SetupExperiment":
            self.time = given[2]
        if function == "DoStep":
            self.time = given[0] + given[1]
        if function == "SetFMUstate":
            self.state, self.time = self.kept
        if function == "DeSerializeFMUstate":
            must(self.fmu, self.fmu.call("FreeFMUstate", given[2]))
        if function == "GetFMUstate":
            must(self.fmu, self.fmu.call("FreeFMUstate", byref(self.objects.state)))
            self.objects, self.kept = saved(self.fmu), (self.state, self.time)
            must(self.fmu, self.fmu.call("FreeFMUstate", given[0]))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("model", MODELS)
def test_random_calls_are_served_and_refused_as_the_table_says(model, seed):
    functions = sorted(ALLOWED)
    often = ["DoStep", "EnterInitializationMode", "ExitInitializationMode"] * 6
    with Instance(model) as fmu:
        must(fmu, fmu.call("SetDebugLogging", 0, 0, NULL))
        walk = Walk(fmu, model, seed)
        for place in walk.random.integers(0, len(functions) + len(often), 1500):
            walk.call((functions + often)[place])
        must(fmu, fmu.call("FreeFMUstate", byref(walk.objects.state)))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("start", [-7.3, 0.0, 12.5])
def test_steps_beyond_the_stop_time_and_times_that_are_added_up_are_served(model, start):
    with Instance(model) as fmu:
        must(fmu, fmu.call("SetupExperiment", 1, 1e-6, start, 1, start + 1.0))
        must(fmu, fmu.call("EnterInitializationMode"))
        must(fmu, fmu.call("ExitInitializationMode"))
        time = start
        for _ in range(1234):
            assert fmu.step(time, 0.001) == OK
            time += 0.001
        last = c_double()
        assert fmu.call("GetRealStatus", fmi2.fmi2LastSuccessfulTime, byref(last)) == OK
        assert last.value == time
        assert fmu.messages == []
