"""The reference experiments as committed: those of oracle and closed forms, and fit to try what they are there for."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

from fmu_src.fmus import MODELS as TABLES
from tests.reference import dissipative_law as law
from tests.reference.catalogue import MODELS, folder_of
from tests.reference.drillstring_neutral import Plant
from tests.reference.experiment import Experiment
from tests.reference.files import reference_files

CASES = [(model, experiment.name) for model, experiments in MODELS.items() for experiment in experiments]
METHOD = {"cells_used", "breaks_folded", "folded_energy"}
"""Outputs that tell of the method, about which an independent solution knows nothing."""


@cache
def made_anew(model: str) -> Mapping[str, bytes]:
    return reference_files(model, MODELS[model])


def table(content: bytes) -> dict[str, np.ndarray]:
    rows = list(csv.reader(io.StringIO(content.decode())))
    return {name: np.array(column, dtype=float) for name, *column in zip(*rows, strict=True)}


def experiment(model: str, name: str) -> Experiment:
    return next(case for case in MODELS[model] if case.name == name)


def plant_events(name: str) -> Plant:
    return experiment("DrillstringNeutral", name).answer.__self__


@pytest.mark.parametrize("model", MODELS)
def test_committed_descriptions_and_inputs_are_those_made_anew(model):
    committed = {path.name: path.read_text(encoding="utf-8").encode() for path in folder_of(model).iterdir()}
    assert set(committed) == set(made_anew(model))
    for name, content in made_anew(model).items():
        if not name.endswith("_ref.csv"):
            assert committed[name] == content, name


@pytest.mark.parametrize(("model", "name"), CASES)
def test_committed_results_are_those_made_anew_to_ten_digits(model, name):
    committed = table((folder_of(model) / f"{name}_ref.csv").read_bytes())
    anew = table(made_anew(model)[f"{name}_ref.csv"])
    assert list(committed) == list(anew)
    for column, values in anew.items():
        assert np.abs(committed[column] - values).max() <= 1e-10 * np.abs(values).max(), column


@pytest.mark.parametrize("model", MODELS)
def test_every_output_has_a_reference_unless_it_tells_of_the_method(model):
    outputs = {variable.name for variable in TABLES[model].select("output")} - METHOD
    for case in MODELS[model]:
        assert set(case.tolerances) == outputs


@pytest.mark.parametrize(("model", "name"), CASES)
def test_every_tolerance_has_a_reason_and_is_far_below_what_it_judges(model, name):
    values = table((folder_of(model) / f"{name}_ref.csv").read_bytes())
    for variable, tolerance in experiment(model, name).tolerances.items():
        assert tolerance.reason
        reach = np.abs(values[variable]).max()
        assert tolerance.absolute + tolerance.relative * reach <= 1e-5 * max(reach, 1.0)


def test_plant_experiments_hold_what_they_are_there_for():
    sticks = plant_events("stick-slip").solution()
    assert sticks.releases[1] == pytest.approx(5.577898395, abs=1e-9)
    assert plant_events("higher-speed").solution().stops.max() < 10.0
    thrown = plant_events("reverse-slip").solution()
    assert len(thrown.crossings) == 6
    assert thrown.bit_speed_extremes(0.0, 20.0)[0] < -12.0
    assert plant_events("input-changes").solution().releases[1] == pytest.approx(5.0, abs=1e-12)
    assert [case.name for case in MODELS["DrillstringNeutral"] if case.interpolated] == ["ramps"]


@pytest.mark.parametrize("case", MODELS["DrillstringNeutral"], ids=lambda case: case.name)
def test_plant_has_at_most_the_events_its_tolerances_speak_of(case):
    solution = plant_events(case.name).solution()
    assert 4 <= len(solution.releases) + len(solution.stops) <= 20 or case.name == "higher-speed"


def test_no_sample_of_a_law_is_near_a_threshold():
    for case in law.EXPERIMENTS:
        files = made_anew("DissipativeLaw")
        omega = table(files[f"{case.name}_ref.csv"])
        limit = 40.0 if case.name == "printed" else law.TRACKING["Omega_max"]
        free = omega["limit_active"] == 0
        assert (limit - np.abs(omega["Omega"][free])).min() > 1e-6
        assert (omega["Omega"][~free] == np.copysign(limit, omega["Omega"][~free])).all()
        assert free.any()
        assert not free.all()
        top = np.abs(table(files[f"{case.name}_in.csv"])["top_speed"])
        assert np.abs(top - 0.01).min() > 1e-6


def test_law_as_printed_is_tried_at_both_ends_of_guard_and_limit():
    omega = table(made_anew("DissipativeLaw")["printed_ref.csv"])
    assert {omega["Omega"].min(), omega["Omega"].max()} == {-40.0, 40.0}
    assert omega["guard_active"].sum() >= 3
