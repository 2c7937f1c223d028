"""Values of every type pass along connections, come from signals, and are recorded, in every algorithm and process."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import Component, Connection, Constant, Scenario, Step, System, load_scenario, simulate, stream
from cosim.drilling import reporting
from cosim.errors import InputError, RunInterruptedError, SystemDefinitionError
from cosim.master.run import Snapshot
from cosim.run.checkpoint import read_checkpoint, write_checkpoint
from cosim.run.trajectory import open_trajectory
from cosim.scenario.ssp.reading import open_ssp
from cosim.scenario.ssp.writing import export_ssp
from cosim.system.signals import Signal

pytestmark = pytest.mark.usefixtures("no_leftovers")

Maker = Callable[..., Path]
STRING = (
    '<ScalarVariable name="{}" valueReference="{}" causality="{}" variability="discrete"><String{}/></ScalarVariable>'
)
TALKING = {
    "</ModelVariables>": STRING.format("said", 1, "input", ' start=""') + STRING.format("heard", 2, "output", "")
    + "</ModelVariables>",
    "</Outputs>": '<Unknown index="15" dependencies=""/></Outputs>',
    "</InitialUnknowns>": '<Unknown index="15"/></InitialUnknowns>',
}  # fmt: skip
CHOOSING = {
    'causality="input" variability="discrete"><Integer start="0"/>':
        'causality="input" variability="discrete"><Enumeration declaredType="Mode" start="1"/>',
    'causality="output" variability="discrete"><Integer/>':
        'causality="output" variability="discrete"><Enumeration declaredType="Mode"/>',
}  # fmt: skip
SWITCHED = {
    'causality="parameter" variability="fixed"><Enumeration': 'causality="input" variability="discrete"><Enumeration'
}
ALGORITHMS: list[dict[str, Any]] = [
    {}, {"algorithm": "gauss-seidel"}, {"algorithm": "implicit"}, {"tolerance": 1e-3},
    {"algorithm": "implicit", "tolerance": 1e-3}, {"isolate": True},
]  # fmt: skip


def chain(fmu: Path, variables: tuple[str, str], inputs: dict[str, Signal]) -> Scenario:
    """Two probes, the first of which drives an input of the second, and both with a Real connection beside it."""
    connections = (Connection(f"a.{variables[0]}", f"b.{variables[1]}"), Connection("a.u_seen", "b.u"))
    signals = {"a.u": Constant(1.0), "a.v": Constant(0.0), "b.v": Constant(0.0), **inputs}
    return Scenario("chain", System((Component("a", fmu), Component("b", fmu)), connections, signals), 1.0, 0.25)


@pytest.mark.parametrize("options", ALGORITHMS)
def test_strings_pass_along_connections(make_probe: Maker, options: dict[str, Any]) -> None:
    scenario = chain(make_probe(replace=TALKING), ("heard", "said"), {"a.said": Step("rot", "grün", 0.5)})
    result = simulate(scenario, **options)
    late = result.time.searchsorted(0.5, side="right")
    assert result["a.heard"].tolist() == ["", *["rot"] * (late - 1), *["grün"] * (result.time.size - late)]
    assert set(result["b.said"][1:late]) <= {"", "rot"}
    assert result["b.heard"][-1] == "grün"
    assert result["a.said"][-1] == result["b.said"][-1] == "grün"


def test_the_loop_to_read_is_taken_where_there_are_strings(make_probe: Maker) -> None:
    record = simulate(chain(make_probe(replace=TALKING), ("heard", "said"), {})).record
    assert (record["step_loop"], record["step_loop_reason"]) == ("python", "a.heard is a String")


@pytest.mark.parametrize("options", ALGORITHMS)
def test_integers_pass_along_connections(probe: Path, options: dict[str, Any]) -> None:
    result = simulate(chain(probe, ("n_next", "n"), {"a.n": Step(3, 7, 0.5)}), **options)
    assert result["b.n_next"].dtype == np.int32
    assert (result["a.n_next"][-1], result["b.n"][-1], result["b.n_next"][-1]) == (8, 8, 9)


@pytest.mark.parametrize("options", ALGORITHMS)
def test_enumerations_pass_along_connections_and_take_items_by_name(make_probe: Maker, options: dict[str, Any]) -> None:
    scenario = chain(make_probe(replace=CHOOSING), ("n_next", "n"), {"a.n": Step("slow", "fast", 0.5)})
    result = simulate(scenario, **options)
    assert result["a.n"].tolist().count(5) == np.count_nonzero(result.time > 0.5)
    assert (result["a.n_next"][-1], result["b.n"][-1], result["b.n_next"][-1]) == (6, 6, 7)


@pytest.mark.parametrize("options", ALGORITHMS)
def test_booleans_pass_along_connections(probe: Path, options: dict[str, Any]) -> None:
    result = simulate(chain(probe, ("not_flag", "flag"), {"a.flag": Step(False, True, 0.5)}), **options)
    assert (result["a.not_flag"][-1], result["b.flag"][-1], result["b.not_flag"][-1]) == (False, False, True)


SCENARIO = """
stop_time = 1.0
step_size = 0.25
[components.a]
fmu = "probe.fmu"
[inputs]
a.said = "plain"
a.mode = {}
[[variants]]
name = "other"
[variants.set]
a.said = "other"
a.mode = "slow"
"""


@pytest.mark.parametrize(("mode", "number"), [('"fast"', 5), ("5", 5), ("1", 1)])
def test_inputs_of_a_file_may_be_strings_and_names_of_items(make_probe: Maker, mode: str, number: int) -> None:
    path = make_probe(replace={**TALKING, **SWITCHED}).with_name("inputs.toml")
    path.write_text(SCENARIO.format(mode).replace('a.mode = "slow"', 'a.mode = "slow"'), encoding="utf-8")
    base = load_scenario(path)
    bare = simulate(Scenario("bare", base.system, base.stop_time, base.step_size, folder=base.folder))
    assert (bare["a.heard"][-1], bare["a.mode"].tolist()) == ("plain", [number] * 5)
    variant = simulate(base, variant="other")
    assert (variant["a.heard"][-1], variant["a.mode"].tolist()) == ("other", [1] * 5)


@pytest.mark.parametrize(
    ("target", "signal", "sentence"),
    [
        ("a.said", Constant(1.0), r"a\.said is 1\.0; expected a string"),
        ("a.said", Constant("a\0b"), r"a\.said has a NUL at 1; expected a string without one"),
        ("a.mode", Constant("medium"), r"a\.mode is 'medium'; expected one of 'slow' \(1\), 'fast' \(5\)"),
        ("a.u", Constant("one"), r"a\.u is 'one'; expected a number"),
    ],
)
def test_signals_of_another_type_are_refused(make_probe: Maker, target: str, signal: Signal, sentence: str) -> None:
    scenario = chain(make_probe(replace={**TALKING, **SWITCHED}), ("n_next", "n"), {target: signal})
    with pytest.raises(SystemDefinitionError, match=sentence):
        simulate(scenario)


def test_a_step_is_of_one_type() -> None:
    with pytest.raises(InputError, match=r"before is 'a' and after is 1\.0; expected the same type"):
        Step("a", 1.0, 0.5)


ODD = ('a,b "c"', "two\nlines", "", "µ")


def test_strings_read_back_from_csv(make_probe: Maker, tmp_path: Path) -> None:
    fmu = make_probe(replace=TALKING)
    for text in ODD:
        result = simulate(chain(fmu, ("heard", "said"), {"a.said": Constant(text)}))
        result.to_csv(tmp_path / "out.csv")
        with (tmp_path / "out.csv").open(newline="", encoding="utf-8") as file:
            header, *rows = list(csv.reader(file))
        assert {len(row) for row in rows} == {len(header)}
        assert [row[header.index("b.heard")] for row in rows] == result["b.heard"].tolist() == ["", "", *[text] * 3]


@pytest.mark.parametrize("text", ODD)
def test_strings_read_back_from_zarr(make_probe: Maker, tmp_path: Path, text: str) -> None:
    scenario = chain(make_probe(replace=TALKING), ("heard", "said"), {"a.said": Constant(text)})
    tail = stream(scenario, tmp_path / "run")
    with open_trajectory(tmp_path / "run") as dataset:
        assert dataset["b.heard"].values.tolist() == ["", "", *[text] * 3]
    assert tail.time.size == 5


def test_strings_read_back_from_a_checkpoint(tmp_path: Path) -> None:
    values = np.array([["a", "longer"], ["", "µ"]], object)
    write_checkpoint(tmp_path / "checkpoint.npz", Snapshot({}, {"block a 3": values}))
    kept = np.empty_like(values)
    kept[:] = read_checkpoint(tmp_path / "checkpoint.npz").arrays["block a 3"]
    assert kept.tolist() == values.tolist()
    assert all(type(text) is str for text in kept.ravel())


@pytest.mark.parametrize("as_csv", [False, True])
def test_strings_survive_an_interrupt(make_suspect: Maker, tmp_path: Path, as_csv: bool) -> None:
    fmu = make_suspect()
    scenario = Scenario(
        "named", System((Component("a", fmu),), inputs={"a.u": Step(1.0, 2.0, 0.5)}), 2.0, 0.01, signals=("a.name",)
    )

    def interrupt(done: float) -> None:
        if done > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(RunInterruptedError):
        stream(scenario, tmp_path / "run", csv=as_csv, progress=interrupt)
    tail = stream(scenario, tmp_path / "run", resume=True)
    assert tail["a.name"].tolist() == ["suspect"] * 201
    if as_csv:
        with (tmp_path / "run" / "trajectory.csv").open(newline="", encoding="utf-8") as file:
            assert [row["a.name"] for row in csv.DictReader(file)] == ["suspect"] * 201
        return
    with open_trajectory(tmp_path / "run") as dataset:
        assert dataset["a.name"].values.tolist() == ["suspect"] * 201


def test_a_figure_shows_strings(make_probe: Maker, tmp_path: Path) -> None:
    scenario = chain(make_probe(replace=TALKING), ("heard", "said"), {"a.said": Step("rot", "grün", 0.5)})
    result = simulate(scenario)
    for name in ("a.heard", "b.heard", "a.said"):
        reporting.draw(tmp_path / f"{name}.png", "strings", {"chain": result}, [name])
    drawn = {path.read_bytes() for path in tmp_path.glob("*.png")}
    assert len(drawn) == 3
    assert all(content.startswith(b"\x89PNG") for content in drawn)


def test_a_null_string_is_an_empty_one(make_suspect: Maker) -> None:
    fmu = make_suspect("null string")
    scenario = Scenario("null", System((Component("a", fmu),), inputs={"a.u": Constant(1.0)}), 0.1, 0.05)
    assert simulate(scenario)["a.name"].tolist() == ["", "", ""]


def test_constant_strings_and_items_are_exported_and_read_back(make_probe: Maker, tmp_path: Path) -> None:
    inputs = {"a.said": Constant("a <b> & c"), "a.mode": Constant("fast")}
    scenario = chain(make_probe(replace={**TALKING, **SWITCHED}), ("heard", "said"), inputs)
    export_ssp(scenario, tmp_path / "chain.ssp")
    with open_ssp(tmp_path / "chain.ssp") as again:
        assert simulate(again)["b.heard"].tolist() == simulate(scenario)["b.heard"].tolist()
        assert simulate(again)["a.mode"].tolist() == [5] * 5
