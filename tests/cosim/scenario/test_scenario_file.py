from __future__ import annotations

import math
import pickle
from pathlib import Path

import pytest

import cosim
from cosim import (
    Component,
    Connection,
    Constant,
    InputError,
    Method,
    PowerBond,
    Ramp,
    Step,
    Table,
    load_scenario,
    scenario_names,
    simulate,
)
from cosim.errors import FmuFileError, ScenarioError, SystemDefinitionError
from cosim.fmi2.locate import locate_fmu
from cosim.run.assembly import refuse_unfit_variants

GOOD = """
title = "A title"
stop_time = 2
step_size = 0.5
algorithm = "gauss-seidel"
order = ["law", "plant"]
tolerance = 1e-3
on_failure = "halve"
iteration_tolerance = 1e-8
guards = ["law.limit_active"]
power_bonds = [{ input = "law.u", output = "law.y" }]
connections = [{ from = "plant.y", to = "law.u" }]

[components.plant]
fmu = "Plant"
parameters = { c_b = 1, table = { file = "program.csv" } }

[components.law]
fmu = "law.fmu"

[inputs]
plant.a = 1.5
"plant.b" = true
"plant.c" = { kind = "step", before = 1, after = 2, at = 0.5 }
"plant.d" = { kind = "ramp", initial = 0, final = 1, start = 2, duration = 3 }
"plant.e" = { kind = "table", points = [[0, 1], [1, 2]] }
"plant.f" = { kind = "table", file = "program.csv", column = "WOB" }

[[variants]]
name = "c_b=1"
set = { "plant.c_b" = 1, "plant.a" = 2 }

[figure]
signals = ["plant.y"]
"""


@pytest.fixture
def write(tmp_path: Path):
    (tmp_path / "program.csv").write_text("time,speed,WOB\n0,10,1e5\n1,20,2e5\n")

    def write(text: str, *replacements: tuple[str, str]) -> Path:
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "mine.toml"
        path.write_text(text)
        return path

    return write


def test_a_file_becomes_plain_data(write) -> None:
    path = write(GOOD)
    scenario = load_scenario(path)
    assert scenario.name == "mine"
    assert (scenario.stop_time, scenario.step_size) == (2.0, 0.5)
    assert scenario.method == Method("gauss-seidel", ("law", "plant"), 1e-3, "halve", 1e-8)
    assert scenario.system.guards == ("law.limit_active",)
    assert scenario.system.power_bonds == (PowerBond("law.u", "law.y"),)
    plant = Component("plant", "Plant", {"c_b": 1, "table": str(path.parent / "program.csv")})
    assert scenario.system.components == (plant, Component("law", "law.fmu"))
    assert scenario.system.connections == (Connection("plant.y", "law.u"),)
    assert scenario.system.inputs == {
        "plant.a": Constant(1.5),
        "plant.b": Constant(True),
        "plant.c": Step(1, 2, 0.5),
        "plant.d": Ramp(0.0, 1.0, 2.0, 3.0),
        "plant.e": Table((0.0, 1.0), (1.0, 2.0)),
        "plant.f": Table((0.0, 1.0), (1e5, 2e5)),
    }
    assert scenario.variant() is scenario.variants[0]
    assert scenario.variants[0].values == {"plant.c_b": 1, "plant.a": 2}
    assert scenario.signals == ("plant.y",)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("stop_time", "stoptime", r"mine\.toml: unknown key 'stoptime'; did you mean 'stop_time'\?"),
        ("stop_time = 2\n", "", "'stop_time' is missing"),
        ("stop_time = 2", 'stop_time = "2"', "stop_time is '2'; expected a number"),
        ("c_b = 1, table", "c_b = [1], table", r"components\.plant\.parameters\.c_b is \[1\]; expected a number"),
        ('fmu = "Plant"', 'fnu = "Plant"', r"unknown key 'components\.plant\.fnu'; did you mean 'fmu'"),
        ("from =", "form =", r"unknown key 'connections\.form'; did you mean 'from'"),
        ("before =", "befor =", r"unknown key 'inputs\.plant\.c\.befor'; did you mean 'before'"),
        ('kind = "ramp"', 'kind = "rmap"', r"inputs\.plant\.d\.kind is 'rmap'; did you mean 'ramp'"),
        ("duration = 3", "duration = -3", r"inputs\.plant\.d: ramp: duration is -3 s; expected a number >= 0"),
        ("[[0, 1], [1, 2]]", "[[0, 1], [1]]", r"inputs\.plant\.e: points hold \[1\]; expected pairs"),
        ("[[0, 1], [1, 2]]", '[["x", 1]]', r"inputs\.plant\.e: points hold \['x', 1\]"),
        ('column = "WOB"', 'column = "wob"', "there is no column 'wob'"),
        ("set = {", "sets = {", r"unknown key 'variants\.sets'; did you mean 'set'"),
        ('"c_b=1"', '"a/b"', "variant 'a/b': expected a name of letters"),
        ('{ "plant.c_b"', '{ "plent.c_b"', r"plent\.c_b: there is no component 'plent'"),
        ('to = "law.u"', 'to = "low.u"', r"low\.u: there is no component 'low'; did you mean 'law'"),
        ('["law", "plant"]', '["law", 1]', "order holds 1; expected strings"),
        ('"halve"', '"halv"', "on_failure is 'halv'; did you mean 'halve'"),
        ("tolerance = 1e-3", "tolerance = 10", "tolerance is 10; expected a number > 0 and < 1"),
        ('["law.limit_active"]', '["low.limit_active"]', "there is no component 'low'; did you mean 'law'"),
        ('output = "law.y"', 'outputs = "law.y"', r"unknown key 'power_bonds\.outputs'; did you mean 'output'"),
        ('"gauss-seidel"', '"gauss-seidl"', "there is no algorithm 'gauss-seidl'; did you mean 'gauss-seidel'"),
        ('["plant.y"]', '"plant.y"', r"figure\.signals is 'plant\.y'; expected an array"),
        ('file = "program.csv" }', 'file = "absent.csv" }', r"absent\.csv: there is no such file"),
        ("[components.law]", "[components.law", r"mine\.toml: cannot be read"),
    ],
)
def test_a_mistake_is_refused_by_its_key(write, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario(write(GOOD, (old, new)))


def test_a_target_driven_twice_is_refused(write) -> None:
    with pytest.raises(SystemDefinitionError, match=r"law\.u is driven by a signal and by plant\.y"):
        load_scenario(write(GOOD, ("plant.a = 1.5", "law.u = 1.5")))


def test_an_unknown_scenario_is_refused_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="there is no scenario 'stickslip'; did you mean 'stick-slip'"):
        load_scenario("stickslip")
    with pytest.raises(ScenarioError, match=r"none\.toml: there is no such file"):
        load_scenario(tmp_path / "none.toml")


def test_an_unknown_variant_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"bit-damping: there is no variant 'c_b=0\.9'; did you mean 'c_b=0\.8'"):
        load_scenario("bit-damping").variant("c_b=0.9")


def test_every_scenario_that_comes_with_the_package_loads_and_has_a_plant() -> None:
    assert set(scenario_names()) >= {
        "stick-slip", "lower-wob", "higher-speed", "wob-law", "bit-damping", "dissipative-law"
    }  # fmt: skip
    for name in scenario_names():
        scenario = load_scenario(name)
        assert "plant" in [component.name for component in scenario.system.components]
        assert scenario.title


def test_a_missing_fmu_is_refused_with_where_it_was_looked_for() -> None:
    with pytest.raises(FmuFileError, match=r"Xyz\.fmu is not in .*native"):
        locate_fmu("Xyz", "native")
    with pytest.raises(InputError, match="there is no packaging 'natve'; did you mean 'native'"):
        locate_fmu("Xyz", "natve")


def test_a_missing_fmu_names_what_makes_it_or_the_one_that_may_be_meant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cosim.fmi2.locate.fmu_folders", lambda packaging: [tmp_path])
    with pytest.raises(FmuFileError, match=r"Plent\.fmu is not in .*; `python build_fmu\.py` makes the FMUs"):
        locate_fmu("Plent", "native")
    (tmp_path / "Plant.fmu").touch()
    with pytest.raises(FmuFileError, match=r"Plent\.fmu is not in .*; did you mean 'Plant'\?"):
        locate_fmu("Plent", "native")


def test_what_was_built_beside_the_package_is_found_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    beside = Path(cosim.__file__).parents[1] / "dist" / "native" / "DrillstringNeutral.fmu"
    assert locate_fmu("DrillstringNeutral", "native") == beside.resolve()


def test_fmus_are_found_in_the_working_directory_before_the_package_and_by_the_environment_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("dist/native", "elsewhere/native", "elsewhere/python"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "Plant.fmu").touch()
    monkeypatch.chdir(tmp_path)
    assert locate_fmu("Plant", "native") == tmp_path / "dist/native/Plant.fmu"
    monkeypatch.setenv("COSIM_FMU_PATH", str(tmp_path / "elsewhere"))
    assert locate_fmu("Plant", "native") == tmp_path / "elsewhere/native/Plant.fmu"
    assert locate_fmu("Plant", "python") == tmp_path / "elsewhere/python/Plant.fmu"
    assert locate_fmu("native/Plant.fmu", "native", tmp_path / "elsewhere") == tmp_path / "elsewhere/native/Plant.fmu"


def test_a_table_takes_units_gaps_and_names_of_columns(tmp_path: Path) -> None:
    (tmp_path / "field.csv").write_text("depth;Uhr;WOB\n9;0;1,5\n9;1;\n8;2;2,5\n")
    table = """{ kind = "table", file = "field.csv", column = "WOB", time = "Uhr", unit = "klbf", factor = 2,
        separator = ";", decimal = ",", gaps = "interpolate" }""".replace("\n", "")
    points = '{ kind = "table", points = [[0, 60]], unit = "rpm" }'
    path = tmp_path / "field.toml"
    path.write_text(
        'stop_time = 1\nstep_size = 1\n[components.plant]\nfmu = "Plant"\n'
        f'[inputs]\n"plant.WOB" = {table}\n"plant.Omega" = {points}\n'
    )
    inputs = load_scenario(path).system.inputs
    assert inputs["plant.WOB"] == Table((0.0, 2.0), (3.0, 5.0), "klbf")
    assert inputs["plant.Omega"] == Table((0.0,), (60.0,), "rpm")
    path.write_text(path.read_text().replace('unit = "rpm"', 'gaps = "hold"'))
    with pytest.raises(ScenarioError, match=r"inputs\.plant\.Omega: gaps is for a file"):
        load_scenario(path)


def test_a_string_that_names_a_file_beside_the_scenario_is_its_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "program.csv").write_text("time,speed,WOB\n0,10,1e5\n")
    (tmp_path / "mine" / "printed").touch()
    path = tmp_path / "mine" / "program.toml"
    path.write_text(
        "stop_time = 1\nstep_size = 1\n[components.program]\nfmu = 'DrillingProgram'\n"
        "parameters = { table = 'program.csv', form = 'printed', other = 'absent.csv' }\n"
        "[[variants]]\nname = 'one'\nset = { 'program.table' = 'program.csv' }\n"
    )
    monkeypatch.chdir(tmp_path)
    scenario = load_scenario(path)
    full = str(tmp_path / "mine" / "program.csv")
    assert dict(scenario.system.components[0].parameters) == {"table": full, "form": "printed", "other": "absent.csv"}
    assert dict(scenario.variants[0].values) == {"program.table": full}


VARYING = """
stop_time = 2.0
step_size = 0.5
[components.plant]
fmu = "DrillstringNeutral"
parameters = { c_b = 0.5 }
[inputs]
"plant.Omega" = 10.0
[[variants]]
name = "plain"
[[variants]]
name = "other"
[variants.set]
"plant.Omega" = { kind = "table", points = [[0, "60 rpm"], [4, "120 rpm"]] }
"plant.c_b" = { kind = "step", before = 0.03, after = 50.0, at = 1.0 }
"""


def test_a_variant_sets_signals_in_the_place_of_signals_and_values(tmp_path: Path) -> None:
    path = tmp_path / "varying.toml"
    path.write_text(VARYING)
    turn = math.pi / 30.0
    plain, other = (simulate(path, variant=name) for name in ("plain", "other"))
    assert plain["plant.Omega"].tolist() == [10.0] * 5
    assert other["plant.Omega"].tolist() == pytest.approx([turn * rpm for rpm in (60.0, 67.5, 75.0, 82.5, 90.0)])
    assert other["plant.c_b"].tolist() == [0.03, 0.03, 0.03, 50.0, 50.0]  # held over the step that led to each row
    assert pickle.loads(pickle.dumps(load_scenario(path))).variants == load_scenario(path).variants


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("before = 0.03", "before = -1", r"plant\.c_b is -1 .*; expected a finite number"),
        ("60 rpm", "60 kN", r"plant\.Omega is '60 kN', in kN .*; expected rad/s"),
        ('"plant.c_b"', '"plant.L"', r"plant\.L is a fixed parameter; a signal drives"),
        ("before = 0.03", "befor = 0.03", r"unknown key 'variants\.set\.plant\.c_b\.befor'; did you mean 'before'"),
    ],
)
def test_a_signal_of_a_later_variant_that_does_not_fit_is_refused_before_the_first_is_run(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = tmp_path / "varying.toml"
    path.write_text(VARYING.replace(old, new))
    with pytest.raises(InputError, match=message):
        refuse_unfit_variants(load_scenario(path), ["plain", "other"], "native")
