"""The points of a sweep: what is said of them, and in which order they are run."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.errors import InputError
from cosim.sweeps.design import SAMPLES, Axis, product, read_values, sampled

SPEEDS = Axis("plant.Omega", {"plant.Omega": [2.0, 4.0, 6.0]})
WEIGHTS = Axis("plant.WOB", {"plant.WOB": [1e4, 2e4]})


def test_a_range_holds_both_its_ends() -> None:
    assert read_values("plant.Omega", "2:20:4") == [2.0, 8.0, 14.0, 20.0]
    assert read_values("plant.Omega", [2, np.float64(3.5)]) == [2, 3.5]


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        ("20:2:65", "plant.Omega=20:2:65: the range is reversed; expected 2:20:65"),
        ("2:20:0", "plant.Omega=2:20:0: the range is empty; expected a count of 2 or more"),
        ("2:20:-3", "plant.Omega=2:20:-3: the range is empty; expected a count of 2 or more"),
        ("2:2:5", "plant.Omega=2:2:5: the range is a single value; expected plant.Omega=2"),
        ("2:20", "plant.Omega=2:20: expected first:last:count, such as 2:20:65"),
        ("2:20:5:7", "plant.Omega=2:20:5:7: expected first:last:count, such as 2:20:65"),
        ("20 rpm:190:5", "plant.Omega=20 rpm:190:5: the ends are in different units; expected one"),
        ("2:nan:5", "plant.Omega=2:nan:5: expected finite numbers"),
        (",", "plant.Omega: there are no values; expected some, such as 2:20:65 or 8,10,12"),
        ("8,10,8", "plant.Omega: 8 is given twice; expected each value once"),
        (8.0, "plant.Omega is 8.0; expected several values, such as [8, 10, 12], or text such as 2:20:65"),
        (b"8,9", "plant.Omega is b'8,9'; expected several values, such as [8, 10, 12], or text such as 2:20:65"),
        ([[8, 9]], "plant.Omega: a value is [8, 9]; expected a number or a text"),
        ([], "plant.Omega: there are no values; expected some, such as 2:20:65 or 8,10,12"),
        ([float("nan")], "plant.Omega: a value is nan; expected finite numbers"),
    ],
)
def test_a_range_that_makes_no_sense_is_refused(said: object, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        read_values("plant.Omega", said)  # pyright: ignore[reportArgumentType]
    assert str(refused.value) == sentence


def test_points_from_rest_are_lines_of_one() -> None:
    design = product([SPEEDS, WEIGHTS], None, "rest")
    assert (design.points, design.lines, design.length) == (6, 6, 1)
    assert [design.place(line, 0) for line in range(6)] == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]
    assert design.values(3, 0) == {"plant.Omega": 4.0, "plant.WOB": 2e4}


@pytest.mark.parametrize(("branch", "speeds"), [("up", [2.0, 4.0, 6.0]), ("down", [6.0, 4.0, 2.0])])
def test_a_branch_goes_along_one_axis_at_each_place_of_the_others(branch: str, speeds: list[float]) -> None:
    design = product([WEIGHTS, SPEEDS], "plant.Omega", branch)
    assert (design.lines, design.length) == (2, 3)
    for line, weight in enumerate([1e4, 2e4]):
        values = [design.values(line, step) for step in range(3)]
        assert [each["plant.Omega"] for each in values] == speeds
        assert {each["plant.WOB"] for each in values} == {weight}


def test_every_point_of_three_axes_comes_once() -> None:
    third = Axis("plant.c_b", {"plant.c_b": [0.1, 0.2, 0.3, 0.4]})
    design = product([SPEEDS, third, WEIGHTS], "plant.WOB", "down")
    places = {design.place(line, step) for line in range(design.lines) for step in range(design.length)}
    assert len(places) == design.points == 24


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol"])
def test_samples_fill_their_bounds_and_come_again(method: str) -> None:
    axis = sampled({"plant.Omega": "2:20", "plant.WOB": (5e3, 150e3)}, 64, method, seed=3)
    assert axis.name == SAMPLES
    for name, (low, high) in {"plant.Omega": (2.0, 20.0), "plant.WOB": (5e3, 150e3)}.items():
        values = np.array(axis.values[name])
        # both ways put one of 64 samples into each of 64 equal parts
        assert sorted(np.floor((values - low) / (high - low) * 64).astype(int)) == list(range(64))
    again = sampled({"plant.Omega": "2:20", "plant.WOB": (5e3, 150e3)}, 64, method, seed=3)
    other = sampled({"plant.Omega": "2:20", "plant.WOB": (5e3, 150e3)}, 64, method, seed=4)
    assert again == axis
    assert other != axis


@pytest.mark.parametrize(
    ("bounds", "count", "method", "sentence"),
    [
        ("20:2", 8, "sobol", "a=20:2: the range is empty or reversed; expected least:greatest"),
        ("2:2", 8, "sobol", "a=2:2: the range is empty or reversed; expected least:greatest"),
        ("2:20:8", 8, "sobol", "a=2:20:8: expected least:greatest, such as 2:20"),
        ("2:20", 1000, "sobol", "1000 Sobol samples are not balanced; expected a power of two: 512 or 1024"),
        ("2:20", 0, "latin-hypercube", "0 samples were asked for; expected 1 to 100000000"),
        ("2:20", 8, "sobl", "there is no way of sampling 'sobl'; did you mean 'sobol'?"),
    ],
)
def test_samples_that_make_no_sense_are_refused(bounds: str, count: int, method: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        sampled({"a": bounds}, count, method, 0)
    assert str(refused.value) == sentence


def test_a_seed_is_no_less_than_nothing() -> None:
    with pytest.raises(InputError, match=r"^the seed is -1; expected a whole number >= 0$"):
        sampled({"a": "2:20"}, 8, "sobol", -1)


@pytest.mark.parametrize(
    ("axes", "along", "branch", "sentence"),
    [
        ([], None, "rest", "there is nothing to vary; expected a grid or samples"),
        ([SPEEDS, SPEEDS], None, "rest", "plant.Omega is varied twice; expected each name once"),
        ([SPEEDS], None, "upp", "there is no branch 'upp'; did you mean 'up'?"),
        ([SPEEDS], "plant.Omga", "up", "runs cannot be continued along 'plant.Omga'; did you mean 'plant.Omega'?"),
        (
            [SPEEDS], "plant.Omega", "rest",
            "runs from rest are not continued along plant.Omega; expected the branch up or down",
        ),
        (
            [Axis("plant.Omega", {"plant.Omega": [4.0, 2.0]})], None, "up",
            "runs cannot be continued along plant.Omega; expected increasing numbers",
        ),
        (
            [Axis(SAMPLES, {"plant.Omega": [4.0, 2.0]})], None, "up",
            "runs cannot be continued along 'sample'",
        ),
    ],
)  # fmt: skip
def test_axes_that_do_not_make_a_sweep_are_refused(axes: list[Axis], along: str, branch: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        product(axes, along, branch)
    assert str(refused.value) == sentence


def test_saltelli_samples_differ_from_the_first_of_their_pair_in_one_variable() -> None:
    axis = sampled({"a": "0:1", "b": (2.0, 3.0), "c": "4:5"}, 8, "saltelli", seed=3)
    assert axis.size == 8 * 5
    blocks = np.array(list(axis.values.values())).T.reshape(8, 5, 3)
    for first, *others, second in blocks:
        assert (first != second).all()
        for variable, other in enumerate(others):
            mixed = first.copy()
            mixed[variable] = second[variable]
            assert other.tolist() == mixed.tolist()
    assert axis == sampled({"a": "0:1", "b": (2.0, 3.0), "c": "4:5"}, 8, "saltelli", seed=3)
    # dyadic numbers of a scrambled Sobol sequence, the same on every processor
    assert blocks[0, 0, 0] == 0.6994058797135949
    with pytest.raises(InputError, match=r"^12 Sobol samples are not balanced; expected a power of two: 8 or 16$"):
        sampled({"a": "0:1"}, 12, "saltelli", seed=3)
