"""The slave of the python packaging, called as pythonfmu's library calls it."""

from __future__ import annotations

from math import inf, isnan, nan

import pytest

from tests.fmu_src.gauge import COUNT, FULL, LABEL, LIMIT, MODE, OFFSET, RATE, TOTAL, Gauge


def make() -> Gauge:
    return Gauge(instance_name="gauge")


def started(**parameters: float) -> Gauge:
    slave = make()
    for name, value in parameters.items():
        slave.set_real([slave.model.value_reference(name)], [value])
    slave.setup_experiment(0.0, None, None)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    return slave


def messages(slave: Gauge) -> list[str]:
    return [message.msg for message in slave.log_queue]


def test_value_references_are_places_in_the_table() -> None:
    slave = make()
    assert [slave.vars[reference].name for reference in slave.vars] == [v.name for v in slave.model.variables]
    assert slave.get_real([OFFSET, RATE]) == [0.5, 1.0]
    assert slave.get_integer([MODE]) == [1]
    assert slave.get_string([LABEL]) == ["a?b"]


def test_outputs_follow_what_is_set_in_initialization_mode() -> None:
    slave = make()
    slave.setup_experiment(0.0, None, None)
    slave.enter_initialization_mode()
    assert slave.get_real([TOTAL]) == [0.5]
    slave.set_real([OFFSET], [2.5])
    assert slave.get_real([TOTAL]) == [2.5]
    slave.exit_initialization_mode()
    assert slave.do_step(0.0, 2.0)
    assert (slave.get_real([TOTAL]), slave.get_integer([COUNT])) == ([4.5], [1])


@pytest.mark.parametrize("bad", [nan, inf, -inf, -1.0, 10.5])
def test_a_value_that_does_not_fit_changes_nothing_and_stops_the_steps(bad: float) -> None:
    slave = started()
    slave.set_real([RATE], [2.0])
    slave.set_real([LIMIT, RATE], [7.0, bad])
    assert slave.get_real([LIMIT, RATE]) == [50.0, 2.0]
    expected = f"gauge at t = 0.0 s: input rate is {bad!r} rad/s; expected a finite value from 0 to 10"
    assert messages(slave) == [expected]
    assert not slave.do_step(0.0, 1.0)
    slave.set_real([RATE], [3.0])
    assert slave.do_step(0.0, 1.0)
    assert slave.get_real([TOTAL]) == [3.5]


@pytest.mark.parametrize(
    ("references", "values"), [([99], [1.0]), ([-1], [1.0]), ([MODE], [1.0]), ([TOTAL], [1.0]), ([OFFSET], [1.0])]
)
def test_an_illegal_setting_stops_the_steps_until_a_state_is_restored(
    references: list[int], values: list[float]
) -> None:
    slave = started()
    saved = slave._get_fmu_state()
    before = list(slave.values)
    slave.set_real(references, values)
    assert slave.values == before
    assert not slave.do_step(0.0, 1.0)
    slave._set_fmu_state(saved)
    assert slave.do_step(0.0, 1.0)


@pytest.mark.parametrize("reference", [99, -1, MODE])
def test_an_illegal_reference_reads_as_nan(reference: int) -> None:
    slave = started()
    got = slave.get_real([TOTAL, reference])
    assert len(got) == 2
    assert all(isnan(value) for value in got)
    assert not slave.do_step(0.0, 1.0)


def test_a_model_that_cannot_be_initialised_has_nan_outputs_and_takes_no_step() -> None:
    slave = started(offset=60.0)
    assert isnan(slave.get_real([TOTAL])[0])
    assert not slave.do_step(0.0, 1.0)
    assert messages(slave)[-1] == "gauge at t = 0.0 s: offset is above limit"


def test_a_tunable_parameter_is_checked_with_the_others_at_the_next_step() -> None:
    slave = started()
    slave.set_real([LIMIT], [0.1])
    assert not slave.do_step(0.0, 1.0)
    slave.set_real([LIMIT], [1.0])
    assert slave.do_step(0.0, 1.0)
    assert slave.get_boolean([FULL]) == [True]


@pytest.mark.parametrize(
    ("time", "size"), [(0.0, 0.0), (0.0, -1.0), (0.0, nan), (0.0, inf), (-1.0, 1.0), (0.1, 1.0), (nan, 1.0)]
)
def test_a_step_that_cannot_be_taken_is_refused_and_can_be_taken_right_afterwards(time: float, size: float) -> None:
    slave = started()
    assert not slave.do_step(time, size)
    assert slave.time == 0.0
    assert slave.do_step(0.0, 1.0)


def test_a_step_the_model_refuses_leaves_everything_as_it_was() -> None:
    slave = started()
    before = list(slave.values)
    assert not slave.do_step(0.0, 6.0)
    assert slave.values == before
    assert messages(slave) == ["gauge at t = 0.0 s: a step above 5 s cannot be taken (100 %%)"]
    assert slave.do_step(0.0, 1.0)


def test_an_accumulated_time_is_accepted() -> None:
    slave = started()
    slave.set_real([RATE], [0.0])
    time = 0.0
    for count in range(10000):
        assert slave.do_step(time, 0.01)
        time = (count + 1) * 0.01


def test_no_exception_leaves_the_slave() -> None:
    slave = started()
    slave.values[MODE] = 2
    assert not slave.do_step(0.0, 4.5)
    assert "KeyboardInterrupt" in messages(slave)[-1]
    assert not slave.do_step(0.0, 1.0)
    slave.set_real([RATE], [])
    slave.set_string([LABEL], [None])  # type: ignore[list-item]
    slave.terminate()
    slave.terminate()
    slave._set_fmu_state(slave._fmu_state_from_bytes(b"\xff["))
    slave._set_fmu_state(slave._fmu_state_from_bytes(b"[]"))


def test_a_serialised_state_repeats_the_same_bits_in_another_instance() -> None:
    slave = started()
    slave.set_real([RATE], [0.1])
    assert slave.do_step(0.0, 0.3)
    saved = slave._fmu_state_to_bytes(slave._get_fmu_state())
    assert slave.do_step(0.3, 0.7)
    other = make()
    other._set_fmu_state(other._fmu_state_from_bytes(saved))
    assert other.do_step(0.3, 0.7)
    assert other.values == slave.values


def test_a_state_of_another_model_is_refused() -> None:
    slave = started()
    state = slave._get_fmu_state() | {"model": "Other"}
    slave._set_fmu_state(state)
    assert not slave.do_step(0.0, 1.0)
