"""Reports as files: what is in them, that nothing in them acts, and that they are small and the same each time."""

from __future__ import annotations

import base64
import json
import re
import shlex
import shutil
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import html
from numpy.typing import NDArray
from typer.testing import CliRunner

from cosim import open_series, open_sweep, open_variants, sweep
from cosim.cli.app import app
from cosim.cli.reports import write_report
from cosim.drilling.severity_map import Map
from cosim.errors import InputError, MissingPackageError, OutputError
from cosim.report.diagram import in_order, lay_out, ways
from cosim.report.lines import kept_rows, line, packed_fully, shares
from cosim.sweeps.told import gather
from cosim.system.signals import FloatArray
from models.plant.parameters import DrillstringParameters
from models.theory.stability.chart import stability_boundary
from tests.cosim.report.conftest import changed
from tests.cosim.run.jobs import sketch

pytestmark = pytest.mark.slow

EVIL = '</script><script>alert(1)</script>"\x1b[31m\u202e$$x$$'


def read(path: Path) -> Any:
    return html.fromstring(path.read_bytes(), parser=html.HTMLParser(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(run_of_two: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report([run_of_two], tmp_path_factory.mktemp("page") / "report.html")


def test_a_run_is_told_whole(page: Path, run_of_two: Path) -> None:
    tree = read(page)
    text = " ".join(tree.text_content().split())
    record = open_variants(run_of_two)["heavy"].record
    for told in (
        "Two weights",
        "light",
        "heavy",
        record["components"]["plant"]["sha256"],
        record["commit"] or "not known",
    ):
        assert told in text
    verdicts = [each.text_content().split()[:2] for each in tree.xpath("//ul[@class='verdicts']/li")]
    assert verdicts == [["light", "steady"], ["heavy", "stick-slip"]]
    rows = tree.xpath("//section[@id='parameters']//tbody/tr")
    given = {row[0].text_content().split()[0]: [cell.text for cell in row[1:4]] for row in rows}
    assert given["L"] == ["m", "1172", "1172"]
    assert given["WOB"] == ["N", "30000", "97347"]
    assert "plant" in tree.xpath("//*[local-name()='svg'][@class='diagram']")[0].text_content()


def test_two_variants_of_10_001_rows_stay_below_2_mb(page: Path, run_of_two: Path) -> None:
    assert open_variants(run_of_two)["light"].time.size == 10_001
    assert page.stat().st_size < 2_000_000


def test_the_same_run_gives_the_same_bytes(page: Path, run_of_two: Path, tmp_path: Path) -> None:
    assert write_report([run_of_two], tmp_path / "again.html").read_bytes() == page.read_bytes()


def test_a_page_can_be_read_without_eyes_and_without_a_mouse(page: Path) -> None:
    tree = read(page)
    assert tree.get("lang") == "en"
    for landmark in ("header", "nav", "main", "footer", "h1"):
        assert len(tree.xpath(f"//{landmark}")) == 1, landmark
    assert all(table.xpath("./caption") and table.xpath(".//th[@scope]") for table in tree.xpath("//table"))
    ids = tree.xpath("//@id")
    assert len(ids) == len(set(ids))
    for reference in tree.xpath("//@aria-labelledby | //a/@href"):
        assert reference.removeprefix("#") in ids
    for field in tree.xpath("//input | //select"):
        assert field.xpath("ancestor::label"), field.get("id")
    assert all(each.get("tabindex") == "0" for each in tree.xpath("//div[@class='scrolled']"))
    for drawn in tree.xpath("//div[@class='panel'] | //*[local-name()='svg'][@role='img']"):
        assert drawn.get("aria-labelledby") in ids
    levels = [int(each.tag[1]) for each in tree.iter("h1", "h2", "h3")]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_only_scripts_that_are_named_by_their_hashes_run_and_nothing_is_asked_for(page: Path) -> None:
    tree = read(page)
    policy = tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
    assert "default-src 'none'" in policy
    assert len(re.findall("sha256-", policy)) == 2
    assert "unsafe-inline" not in policy.partition("script-src")[2]
    assert not tree.xpath("//@src | //link | //@onclick")


def test_texts_of_a_run_act_upon_nothing(run_of_two: Path, tmp_path: Path) -> None:
    def poison(content: dict[str, Any]) -> None:
        content["title"] = EVIL
        content["commit"] = EVIL
        first = content["variants"][0]
        first["variant"] = EVIL
        first["components"]["plant"]["model"] = EVIL
        first["components"]["plant"]["parameters"][EVIL] = EVIL
        first["guards"] = {EVIL: {"points": 1, "first": 0.0, "last": 1.0}}
        first["connections"] = [f"plant.{EVIL} -> plant.{EVIL}"]
        first["loops"] = [f"plant.{EVIL} -> plant.{EVIL}"]
        first["units"]["plant.bit_speed"] = EVIL

    poisoned = changed(run_of_two, tmp_path / "run", poison)
    content = json.loads((poisoned / "manifest.json").read_text())
    content["variants"] = content["variants"][:1]  # units have to agree
    changed(poisoned, tmp_path / "one", lambda told: told.update(variants=told["variants"][:1]))
    page = write_report([tmp_path / "one"], tmp_path / "report.html", title=EVIL)
    text = page.read_text(encoding="utf-8")
    assert "\x1b" not in text
    assert "\u202e" not in text
    assert len(read(page).xpath("//script")) == 3
    assert "alert(1)</script>" not in text
    assert "\\x1b[31m" in read(page).xpath("//h1")[0].text_content()


def test_runs_are_compared_by_the_names_of_their_folders_in_units_of_the_field(
    run_of_two: Path, tmp_path: Path
) -> None:
    other = changed(run_of_two, tmp_path / "other", lambda told: told.update(title="Other"))
    tree = read(write_report([run_of_two, other], tmp_path / "both.html", units="field"))
    assert tree.xpath("//h1")[0].text == "Runs compared"
    names = [each.text for each in tree.xpath("//ul[@class='verdicts']/li/b")]
    assert names == [f"{folder}, {name}" for folder in (run_of_two, other) for name in ("light", "heavy")]
    assert "plant.bit_speed [rpm]" in tree.xpath("//figcaption")[0].text


def test_a_league_is_told_whole(league: Path, tmp_path: Path) -> None:
    tree = read(write_report([league], tmp_path / "league.html"))
    rows = [[cell.text_content() for cell in row] for row in tree.xpath("//table[@class='standings']//tr")]
    assert rows[0] == ["condition", "soft", "ordinary"]
    assert rows[1] == ["10 rad/s", "2.7 sSSI 4e-07", "stuckSSI 1.6"]
    assert rows[2] == ["7 rad/s", "fails", "stuckSSI 2.8"]
    assert rows[3] == ["conditions mastered", "1 of 2", "0 of 2"]
    text = tree.text_content()
    assert "soft, slow: the motor burnt" in text
    assert "0.4+" in text
    assert not tree.xpath("//script")


def test_a_sweep_is_told_whole(sweep_of_six: Path, tmp_path: Path) -> None:
    page = write_report([sweep_of_six], tmp_path / "map.html", units="field", folds=0)
    tree = read(page)
    assert "Over plant.Omega, 2 values from 47.7465 to 143.239 rpm, and plant.WOB, 3 values" in tree.text_content()
    (told,) = drawn(page)["groups"]
    stored = open_sweep(sweep_of_six)
    program, *arguments = shlex.split(tree.xpath("//pre/code")[0].text)
    assert program == "cosim"
    done = CliRunner().invoke(app, [*arguments, "--workers", "1", "--output", str(tmp_path / "again.zarr")])
    assert done.exit_code == 0, done.output
    assert open_sweep(tmp_path / "again.zarr").attrs["sha256"] == stored.attrs["sha256"]
    assert told["axes"][1]["values"] == pytest.approx([4.49618, 13.48854, 22.4809], rel=1e-6)
    speeds = next(each for each in told["measures"] if each["name"] == "bit_speed_max")
    (values,) = speeds["values"]
    assert unpacked(values) == pytest.approx(stored["bit_speed_max"].values.ravel() * 30.0 / np.pi, abs=values[1])
    again = write_report([sweep_of_six], tmp_path / "again.html", units="field", folds=0)
    assert again.read_bytes() == page.read_bytes()


def drawn(page: Path) -> Any:
    """Return what the script of a page reads."""
    return json.loads(read(page).xpath("//script[@id='data']")[0].text)


def unpacked(told: list[Any]) -> NDArray[np.float64]:
    """Read numbers as the script does."""
    least, part, text = told
    if least is None:
        return np.frombuffer(base64.b64decode(text), dtype="<f4").astype(np.float64)
    parts = np.frombuffer(base64.b64decode(text), dtype="<u2")
    return np.where(parts == 65535, np.nan, least + parts * part)


def test_lines_of_theory_are_those_of_the_string_at_each_place_of_other_axes(
    sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    (group,) = drawn(write_report([sweeps("cube")], tmp_path / "cube.html"))["groups"]
    assert group["axes"][0]["values"] == [0.03, 60.0]  # in their order, which the sweep's is not
    (lines,) = group["lines"]
    assert [each["at"] for each in lines] == [{"0": 0}, {"0": 1}]
    assert all(each["kind"] == "threshold" and each["plane"] == [1, 2] for each in lines)
    for damping, each in zip((0.03, 60.0), lines, strict=True):
        weights = unpacked(each["y"]) * 1e3
        speeds = stability_boundary(replace(DrillstringParameters(), c_b=damping), weights)
        assert unpacked(each["x"]) == pytest.approx(speeds, abs=2e-3, nan_ok=True)


def test_cells_are_called_bistable_of_one_system_alone(sweeps: Callable[..., Path], tmp_path: Path) -> None:
    branches = [sweeps("plane"), sweeps("plane", "--branch", "down")]
    assert "the sweeps disagree: bistable" in read(write_report(branches, tmp_path / "a.html", folds=0)).text_content()
    others = [sweeps("plane"), sweeps("plane", "--set", "plant.c_b=60")]
    text = read(write_report(others, tmp_path / "b.html", folds=0)).text_content()
    assert "the sweeps disagree" in text
    assert "bistable" not in text


def test_there_are_no_lines_of_theory_where_a_string_cannot_be(sweeps: Callable[..., Path], tmp_path: Path) -> None:
    (group,) = drawn(write_report([sweeps("refused")], tmp_path / "refused.html", folds=0))["groups"]
    assert group["failed"] == [[0, 1, 2, 3]]  # mu_sb is less than mu_cb there
    assert [each["at"] for each in group["lines"][0]] == [{"0": 1}]


def test_the_fold_of_a_string_is_looked_for_once_for_all_sweeps_of_it(
    sweep_of_six: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def fold(found: Map, count: int, progress: object = None) -> tuple[FloatArray, FloatArray]:
        del found, progress
        asked.append(count)
        return np.array([8.0, 12.0]), np.array([3e4, 9e4])

    monkeypatch.setattr("cosim.drilling.severity_map.find_folds", fold)
    other = tmp_path / "other.zarr"
    shutil.copytree(sweep_of_six, other)
    page = write_report([sweep_of_six, other], tmp_path / "map.html", folds=2)
    (group,) = drawn(page)["groups"]
    assert asked == [2]
    for lines in group["lines"]:
        assert [each["kind"] for each in lines] == ["threshold", "fold"]
        assert unpacked(lines[1]["x"]) == pytest.approx([8.0, 12.0], abs=1e-3)
        assert unpacked(lines[1]["y"]) == pytest.approx([30.0, 90.0], abs=1e-2)
    assert "end of the cycles" in read(page).text_content()
    bare = write_report([sweep_of_six], tmp_path / "bare.html", folds=0)
    assert "end of the cycles" not in read(bare).text_content()
    assert asked == [2]


@pytest.mark.parametrize(
    ("name", "title", "over"),
    [
        ("line", "Lines", "Over plant.Omega, 2 values from 5 to 15 rad/s."),
        ("cube", "Map", "Over plant.c_b, 2 values from 0.03 to 60 N.m.s/rad; plant.Omega, 3 values from 5 to 15 rad/s"),
        ("samples", "Samples", "8 samples of plant.mu_sb."),
        ("maybe", "Map", "from 20 to 100 kN, each with 4 samples of plant.mu_sb."),
        ("linemaybe", "Lines", "from 5 to 15 rad/s, each with 4 samples of plant.mu_sb."),
        ("packagings", "Map", "Over plant, 2 values: DrillstringNeutral, DrillstringDistributed, and plant.WOB"),
    ],
)
def test_a_sweep_over_any_number_of_dimensions_is_told(
    name: str, title: str, over: str, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    tree = read(write_report([sweeps(name)], tmp_path / "page.html", folds=0))
    assert tree.xpath("//section/h2")[0].text.startswith(f"{title}: {name}.zarr")
    assert over in " ".join(tree.text_content().split())
    for reference in tree.xpath("//@aria-labelledby | //a/@href"):
        assert reference.removeprefix("#") in tree.xpath("//@id")
    for field in tree.xpath("//input | //select"):
        assert field.xpath("ancestor::label"), field.get("id")


def test_a_sweep_too_large_for_a_page_is_shown_in_part(
    sweep_of_six: Path, sweeps: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cosim.sweeps.told.MOST_NUMBERS", 7 * 3)
    page = write_report([sweep_of_six], tmp_path / "part.html", folds=0)
    (group,) = drawn(page)["groups"]
    assert group["axes"][1]["values"] == [20.0, 100.0]
    assert "Shown: every other value of plant.Omega, every other value of plant.WOB" in read(page).text_content()
    page = write_report([sweeps("samples")], tmp_path / "few.html")
    assert drawn(page)["groups"][0]["count"] == 2
    assert "2 of 8 samples" in read(page).text_content()


def test_the_command_of_a_sweep_draws_its_samples_and_keeps_its_series_again(tmp_path: Path) -> None:
    uncertain = tmp_path / "uncertain.toml"
    uncertain.write_text('"plant.c_b" = { kind = "lognormal", median = 0.03, factor = 2.0 }\n', encoding="utf-8")
    words = ["stick-slip", "--grid", "plant.Omega=5,15", "--sample", "plant.mu_sb=0.6:1", "--uncertain", str(uncertain)]
    more = ["--count", "2", "--seed", "3", "--stop-time", "30", "--workers", "1", "--keep", "plant.bit_speed"]
    done = CliRunner().invoke(app, ["sweep", *words, *more, "--output", str(tmp_path / "first.zarr")])
    assert done.exit_code == 0, done.output
    tree = read(write_report([tmp_path / "first.zarr"], tmp_path / "page.html"))
    command, distributions = tree.xpath("//pre/code/text()")
    uncertain.write_text(distributions, encoding="utf-8")
    _, *arguments = shlex.split(command.replace("uncertain.toml", str(uncertain)))
    done = CliRunner().invoke(app, [*arguments, "--workers", "1", "--output", str(tmp_path / "second.zarr")])
    assert done.exit_code == 0, done.output
    first, second = (open_sweep(tmp_path / f"{name}.zarr").load() for name in ("first", "second"))
    assert first.attrs["sha256"] == second.attrs["sha256"]
    assert first.equals(second)
    assert open_series(tmp_path / "first.zarr").equals(open_series(tmp_path / "second.zarr"))


def test_the_command_of_a_sweep_over_true_and_false_keeps_as_many_points_again(tmp_path: Path) -> None:
    grid = {"law.enabled": "false,true", "plant.WOB": "2e4:1e5:4"}
    given: dict[str, Any] = {"workers": 1, "stop_time": 20.0, "keep": ["plant.bit_speed"], "keep_points": 4}
    sweep("soft-torque", tmp_path / "s.zarr", grid=grid, **given)
    kept = open_series(tmp_path / "s.zarr")
    assert (kept.sizes["law.enabled"], kept.sizes["plant.WOB"]) == (2, 2)
    (told,) = gather([tmp_path / "s.zarr"], "si")["sweeps"]
    assert "--keep-points 4 " in told["command"]


def test_series_are_left_out_where_there_is_no_room_for_them(
    sweeps: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cosim.sweeps.told.MOST_SERIES", 4)
    page = write_report([sweeps("kept")], tmp_path / "kept.html", folds=0)
    (series,) = drawn(page)["groups"][0]["series"]
    assert [len(each) for each in series["lines"]] == [2, 2]
    assert "series of 2 of 4 points" in read(page).text_content()


def test_numbers_far_apart_are_written_in_full() -> None:
    values = np.array([0.1, 0.2, 0.3, 1e9, np.inf])
    assert unpacked(packed_fully(values)) == pytest.approx([*values[:4], np.nan], rel=1e-6, nan_ok=True)
    assert packed_fully(values[:3])[0] is not None


def test_a_damaged_store_is_a_sentence(sweep_of_six: Path, tmp_path: Path) -> None:
    store = tmp_path / "map.zarr"
    shutil.copytree(sweep_of_six, store)
    chunk = next(path for path in sorted((store / "ssi").iterdir()) if not path.name.startswith("."))
    chunk.write_bytes(b"damage")
    with pytest.raises(InputError, match=r"map\.zarr holds a sweep that is damaged"):
        write_report([store], tmp_path / "report.html")


def test_what_cannot_be_reported_is_a_sentence(run_of_two: Path, league: Path, tmp_path: Path) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    target = tmp_path / "report.html"
    with pytest.raises(InputError, match="empty holds no finished run, league or sweep"):
        write_report([empty], target)
    with pytest.raises(InputError, match=r"holds a run and .* a league; expected folders of one kind"):
        write_report([run_of_two, league], target)
    with pytest.raises(InputError, match="unfinished run"):
        write_report([changed(run_of_two, tmp_path / "part", lambda told: told.update(state="unfinished"))], target)
    with pytest.raises(InputError, match=r"manifest.json is damaged: .* missing .* \'connections\'"):
        write_report([changed(run_of_two, tmp_path / "torn", lambda t: t["variants"][0].pop("connections"))], target)
    with pytest.raises(InputError, match=r"report\.txt: expected a name that ends in \.html"):
        write_report([run_of_two], tmp_path / "report.txt")
    with pytest.raises(InputError, match="there are no units 'imperial'"):
        write_report([run_of_two], target, units="imperial")
    with pytest.raises(InputError, match="told in SI units"):
        write_report([league], target, units="field")
    with pytest.raises(OutputError, match="cannot be written"):
        write_report([league], tmp_path / "absent" / "report.html")
    (league / "scores.csv").write_text("law,condition\nsoft\n")
    with pytest.raises(InputError, match="holds a league that is damaged"):
        write_report([league], target)
    assert not target.exists()


def test_a_missing_package_is_named_with_what_brings_it(
    run_of_two: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "bokeh.models", None)
    with pytest.raises(MissingPackageError, match=r"a report needs the package bokeh.*drillstring-cosim\[report\]"):
        write_report([run_of_two], tmp_path / "report.html")


def test_the_command_in_a_report_repeats_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.drilling.reporting.draw", sketch)

    def cosim(*arguments: object) -> None:
        done = CliRunner().invoke(app, list(map(str, arguments)))
        assert done.exit_code == 0, done.output

    changes = ["--set", "plant.L=1500", "--set", "plant.WOB=80 kN", "--step-size", "0.05", "--stop-time", "3"]
    cosim("run", "bit-damping", *changes, "--output", tmp_path / "first")
    cosim("report", tmp_path / "first", "--output", tmp_path / "report.html")
    (command,) = read(tmp_path / "report.html").xpath("//section[@id='reproduce']/pre/code/text()")
    program, *arguments = shlex.split(command)
    assert (program, arguments[:2]) == ("cosim", ["run", "bit-damping"])
    cosim(*arguments, "--output", tmp_path / "second")
    first, second = open_variants(tmp_path / "first"), open_variants(tmp_path / "second")
    assert list(first) == list(second)
    assert all(first[name] == second[name] for name in first)


def test_a_line_keeps_extremes_and_ends_of_a_run() -> None:
    values = np.random.default_rng(3).normal(size=10_001)
    values[[17, 9000]] = 50.0, -50.0
    rows = kept_rows(values, 400)
    assert rows.size <= 400
    assert {0, 17, 9000, 10_000} <= set(rows.tolist())
    assert np.all(np.diff(rows) > 0)
    assert kept_rows(np.ones(10_001), 400).tolist() == [0, 10_000]
    assert kept_rows(values, 10_001).size == 10_001


def test_a_line_is_packed_to_a_part_in_65_000_of_its_range() -> None:
    times = np.linspace(0.0, 100.0, 5001)
    values = np.sin(times)
    values[100] = np.nan
    found = line(times, values, 9999)
    assert found is not None
    least, part, text = found.to_json()["y"]
    parts = np.frombuffer(base64.b64decode(text), dtype="<u2")
    assert parts[100] == 65535
    there = np.arange(5001) != 100
    assert np.abs(least + parts * part - values)[there].max() <= 2.0 / 65000
    assert line(times, np.array(["a"] * 5001, dtype=object), 100) is None


def test_points_are_shared_out_and_signals_without_any_left_out() -> None:
    names = [f"a.{number}" for number in range(10_000)]
    points = shares(names, ["a.7"], 2, 90_000)
    assert sum(points.values()) * 2 <= 90_000
    assert points["a.7"] > points["a.8"] >= 60
    assert "a.9999" not in points


def test_components_stand_below_what_they_take_from_and_loops_are_marked() -> None:
    connections = ["law.u -> drive.u", "drive.v -> plant.v", "plant.w -> law.w", "plant.t -> drive.t"]
    found = ways(["plant", "drive", "law"], connections, ["drive.v -> plant.v -> plant.t -> drive.t -> drive.v"])
    assert [(way.source, way.target, way.looped) for way in found] == [
        ("law", "drive", False), ("drive", "plant", True), ("plant", "law", False), ("plant", "drive", True),
    ]  # fmt: skip
    order = in_order(["plant", "drive", "law"], found)
    drawn = lay_out({name: [name.upper()] for name in ("plant", "drive", "law")}, found)
    assert drawn is not None
    assert [box.name for box in drawn.boxes] == order
    assert len(drawn.arrows) == 4
    places = [(box.y, box.y + box.height) for box in drawn.boxes]
    assert all(above[1] < below[0] for above, below in pairwise(places))


def test_a_system_too_large_is_not_drawn() -> None:
    assert lay_out({f"c{number}": [] for number in range(500)}, ()) is None
