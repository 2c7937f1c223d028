"""A league: laws under conditions, judged the same whatever their number of processes, and refused by sentences."""

from __future__ import annotations

import csv
import logging
import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cosim.errors import InputError, OutputError, RunError
from cosim.league.entries import Condition, League, load_league
from cosim.league.playing import play, score
from cosim.league.rig import Rig
from cosim.league.table import FIGURE, LIMITS, SCORES, headings, prepare, rows, write

pytestmark = pytest.mark.slow

USUAL = load_league()
LEAST = """
settle = 60.0
judge = 90.0
step_size = 0.01
[laws.soft]
fmu = "SoftTorque"
[conditions.nominal]
speed = 10.0
weight = 97347.0
"""


def of(law: str, condition: str, **changes: object) -> tuple[League, Condition]:
    league = USUAL.only([law], [condition])
    return league, replace(league.conditions[0], **changes)


def test_soft_torque_frees_the_string_with_a_real_drive_and_an_ordinary_drive_does_not() -> None:
    league, condition = of("soft-torque", "eight")
    freed = score(league, league.laws[0], condition)
    assert 0.0 < freed.time_to_free < 20.0
    assert freed.ssi < 1e-3
    assert freed.stuck_fraction == 0.0
    assert freed.penetration == pytest.approx(6.71, abs=0.005)  # at the equilibrium of 4.160 rad/s
    league, condition = of("ordinary", "eight")
    stuck = score(league, league.laws[0], condition)
    assert math.isinf(stuck.time_to_free)
    assert stuck.stuck_fraction > 0.5
    assert stuck.drive_swing == 0.0


def test_a_weight_that_rises_too_fast_makes_soft_torque_stick_where_an_ordinary_drive_turns_on() -> None:
    """The dip is about dT/dt / K: in 20 s it leaves the bit turning."""
    league, fast = of("soft-torque", "loading")
    soft = league.laws[0]
    assert score(league, soft, fast).least_bit_speed == 0.0
    assert score(league, soft, replace(fast, load_time=20.0)).least_bit_speed > 3.0
    league, fast = of("ordinary", "loading")
    ordinary = score(league, league.laws[0], fast)
    assert ordinary.least_bit_speed > 5.0
    assert ordinary.dip == pytest.approx(10.0 - ordinary.least_bit_speed, abs=0.5)


def test_what_laws_assume_is_told_to_the_law_and_not_to_the_string() -> None:
    league, condition = of("soft-torque", "mistaken", plant={"L": 2000.0})
    parts = {part.name: part.parameters for part in Rig(league, league.laws[0], condition).scenario.system.components}
    assert parts["plant"] == {"L": 2000.0}
    assert parts["law"]["L"] == 2000.0
    assert parts["law"]["G"] == 0.5 * 79.3e9
    assert parts["law"]["I"] == 0.5 * 0.095


def test_the_number_of_processes_changes_no_digit(tmp_path: Path) -> None:
    league = replace(USUAL.only(["soft-torque", "ordinary"], ["nominal", "weak"]), settle=20.0, judge=25.0)
    texts: list[bytes] = []
    for workers in (1, 2):
        files = write(play(league, workers), tmp_path / str(workers))
        assert all(path.stat().st_size > 0 for path in files)
        texts.append((tmp_path / str(workers) / SCORES).read_bytes())
    assert texts[0] == texts[1]
    with (tmp_path / "1" / SCORES).open(newline="") as file:
        found = list(csv.DictReader(file))
    assert [(row["law"], row["condition"]) for row in found] == [
        ("ordinary", "nominal"), ("ordinary", "weak"), ("soft-torque", "nominal"), ("soft-torque", "weak"),
    ]  # fmt: skip


UNGUARDED = """
from dataclasses import replace
from cosim.league.entries import load_league
from cosim.league.playing import play
print("begun")
league = replace(load_league().only(["soft-torque", "ordinary"], ["nominal"]), settle=20.0, judge=25.0)
print(len(play(league, 2).scores))
"""


def test_players_do_not_run_the_script_of_the_league_again(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(UNGUARDED)
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=240)
    assert (done.returncode, done.stdout, done.stderr) == (0, "begun\n2\n", "")


def test_a_search_ends_at_the_first_value_that_is_too_hard(tmp_path: Path) -> None:
    search = next(each for each in USUAL.searches if each.vary == "speed")
    league = replace(
        USUAL.only(["soft-torque"], ["nominal"]), searches=(replace(search, values=(10.0, 9.0, 5.0, 10.0)),)
    )
    standings = play(league, 1)
    assert standings.limits["soft-torque", search.name].value == 9.0
    write(standings, tmp_path)
    assert (tmp_path / LIMITS).read_text().splitlines()[1] == f"soft-torque,{search.name},9.0,False"
    assert headings(standings) == ("condition", "soft-torque")
    assert [row[1] for row in rows(standings)][-2:] == ["1/1", "9"]


def test_a_run_that_fails_is_a_score_that_says_why() -> None:
    league, condition = of("ordinary", "nominal", drive={"delay": 5.0})
    failed = score(league, league.laws[0], condition)
    assert "delay is 5 s; expected at most 64 sample times" in failed.failure
    assert not failed.free


REFUSED = {
    "settle = 60.0\n": ("settle = -1.0\n", "settle is -1; expected a number > 0"),
    "speed = 10.0\n": ("sped = 10.0\n", "unknown key 'conditions.nominal.sped'; did you mean 'speed'?"),
    'fmu = "SoftTorque"': ('fmu = "SoftTorqe"', "did you mean 'SoftTorque'?"),
    "[laws.soft]\n": ("[laws.soft]\nparameters = { P = 'x' }\n", "law.P"),
    "weight = 97347.0\n": ("weight = 'much'\n", "conditions.nominal.weight is 'much'; expected a number"),
}


@pytest.mark.parametrize("was", REFUSED)
def test_a_file_that_is_not_understood_is_refused_by_its_key(was: str, tmp_path: Path) -> None:
    becomes, sentence = REFUSED[was]
    path = tmp_path / "own.toml"
    path.write_text(LEAST.replace(was, becomes))
    with pytest.raises(InputError) as refused:
        play(load_league(path), 1)
    assert sentence in str(refused.value)


def test_laws_and_conditions_that_are_not_there_are_named() -> None:
    with pytest.raises(InputError, match="there is no law 'soft-torqe'; did you mean 'soft-torque'"):
        USUAL.only(["soft-torqe"], [])
    with pytest.raises(InputError, match="there is no condition 'nominel'; did you mean 'nominal'"):
        USUAL.only([], ["nominel"])


def test_a_folder_that_cannot_be_made_is_named_before_anything_is_played(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(OutputError, match=r"output folder .*taken cannot be made"):
        prepare(tmp_path / "taken")


def test_hundreds_of_runs_warn_of_nothing(caplog: pytest.LogCaptureFixture) -> None:
    league, condition = of("soft-torque", "noise")
    score(replace(league, judge=25.0), league.laws[0], condition)
    assert not caplog.records
    logging.getLogger("cosim").warning("heard again")
    assert len(caplog.records) == 1


def test_names_and_titles_are_drawn_as_they_stand(tmp_path: Path) -> None:
    league = USUAL.only(["ordinary"], ["nominal"])
    law, condition = replace(league.laws[0], name="a $x_{$ b"), replace(league.conditions[0], title="$\\frac{")
    strange = replace(league, title="\x1b[2J $", settle=20.0, judge=25.0, laws=(law,), conditions=(condition,))
    write(play(strange, 1), tmp_path)
    assert (tmp_path / FIGURE).read_bytes().startswith(b"\x89PNG")


class Fatal(Condition):
    """Ends the process that it comes to."""

    def __reduce__(self) -> tuple[object, ...]:
        return os._exit, (3,)


def test_a_process_that_is_gone_is_a_sentence() -> None:
    league, _ = of("ordinary", "nominal")
    deadly = replace(league, conditions=(Fatal("a", "a", 1.0, 1.0), Fatal("b", "b", 1.0, 1.0)))
    with pytest.raises(RunError, match="has ended before its time, or was killed"):
        play(deadly, 2)
