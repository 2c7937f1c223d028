"""Tuning: the same by seed, processes and interruptions; within margins; and by what it is refused.

Most of it is played by a stand-in whose least severity is known; the FMUs play where it says so.
"""

from __future__ import annotations

import math
import os
import random
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim.cli.app import app
from cosim.errors import CheckpointError, CosimError, InputError, RunError, TuningInterruptedError
from cosim.files import locked
from cosim.league.entries import League, Range, load_league
from cosim.league.playing import Game, Played, score
from cosim.league.score import Score
from cosim.league.tuning.gains import Gain
from cosim.league.tuning.journal import FILE
from cosim.league.tuning.search import Candidate, Tuned, Tuning, prepare, tune
from cosim.league.tuning.severity import overall, severity
from cosim.league.tuning.table import CANDIDATES, FIGURE, PARAMETERS, write
from models.controllers.delay import reflection
from models.controllers.speed_pid import tuned as tuned_pid
from models.controllers.virtual_drive import Gains, TopOfString, absorber, soft_torque

STRING = TopOfString()
ROOT = Path(__file__).parents[3]
BEST = {"P": 520.0, "K": 260.0}
"""Where the stand-in frees the string at once."""
SHORT = """
title = "Short"
settle = 20.0
judge = 25.0
step_size = 0.01
[laws.soft]
fmu = "SoftTorque"
[laws.ordinary]
[conditions.nominal]
speed = 10.0
weight = 97347.0
[conditions.heavy]
speed = 14.0
weight = 140e3
"""


class StandIn:
    """Plays in no time: the string is freed the later the farther the gains are from the best ones."""

    def __init__(self, best: dict[str, float] = BEST) -> None:
        self.best = best
        self.games: list[Game] = []

    @contextmanager
    def __call__(self, workers: int) -> Generator[Played]:
        yield self._played

    def _played(self, games: Sequence[Game]) -> Iterator[tuple[Game, Score]]:
        for game in reversed(games):  # not in the order in which they were given
            self.games.append(game)
            yield game, self._score(game)

    def _score(self, game: Game) -> Score:
        has = {"P": 449.12, "K": 187.4, "filter_time": 0.04, **game.law.parameters}
        far = sum(math.log(float(has[name]) / best) ** 2 for name, best in self.best.items())
        slower = 1.0 if game.what.name == "nominal" else 1.5
        return Score(time_to_free=10.0 * slower * far, ssi=0.0, stuck_fraction=0.0, drive_swing=0.0, mean_top_speed=9.0)


@pytest.fixture(autouse=True)
def soon(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what takes time and is looked at elsewhere: drawing, and waiting for the disk."""
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr("os.fsync", lambda descriptor: None)
        if "figure" not in request.node.name:
            monkeypatch.setattr("cosim.league.tuning.table.save_figure", lambda path, compose: path.touch())


@cache
def usual() -> Tuning:
    return prepare("soft-torque", conditions=["nominal", "eight"], gains=["P=200:1100", "K=20:750"], budget=40)


def asked(**changes: object) -> Tuning:
    """A tuning of SoftTorque under two conditions, with two gains that are free, and margins that take no time."""
    return replace(usual(), linear=(), **changes)


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in (PARAMETERS, CANDIDATES)}


def made(tuning: Tuning, folder: Path, play: StandIn | None = None) -> tuple[Tuned, dict[str, bytes]]:
    """What comes of a tuning, and the files with its numbers."""
    tuned = tune(tuning, folder, 1, play=play or StandIn())
    write(tuned, folder)
    return tuned, contents(folder)


def test_the_known_best_gains_are_found(tmp_path: Path) -> None:
    tuned, _ = made(asked(budget=200), tmp_path)
    assert {name: tuned.after.values[name] for name in BEST} == pytest.approx(BEST, rel=0.02)
    assert tuned.after.severity < 0.01 * tuned.before.severity
    assert len(tuned.trials) <= 200


def test_a_seed_gives_the_same_bits_and_another_seed_other_candidates(tmp_path: Path) -> None:
    found = [made(asked(seed=seed), tmp_path / str(number))[1] for number, seed in enumerate((1, 1, 2))]
    assert found[0] == found[1]
    assert found[0][CANDIDATES] != found[2][CANDIDATES]


def test_the_law_as_it_is_comes_first_and_nothing_worse_comes_of_it(tmp_path: Path) -> None:
    at_best = soft_torque(STRING)
    tuned, _ = made(asked(), tmp_path, StandIn({"P": at_best.damping * 1.0000001, "K": at_best.stiffness}))
    assert tuned.trials[0].values == {"P": 449.1, "K": 187.4}  # its own gains, to the digits that are tried
    assert tuned.after.severity <= tuned.before.severity
    _, files = made(asked(), tmp_path / "none", StandIn({"filter_time": 0.04}))
    assert tomllib.loads(files[PARAMETERS].decode())["parameters"] == {
        "mode": "own", "P": at_best.damping, "K": at_best.stiffness, "J_v": 0.0,
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_a_tuning_that_is_cut_anywhere_goes_on_to_the_same_bits(seed: int, tmp_path: Path) -> None:
    whole = StandIn()
    _, expected = made(asked(), tmp_path, whole)
    journal = (tmp_path / FILE).read_bytes()
    first = journal.index(b"\n") + 1
    cut = random.Random(seed).randrange(first, len(journal))
    (tmp_path / FILE).write_bytes(journal[:cut])
    kept = journal[:cut].count(b"\n") - 1
    rest = StandIn()
    assert made(asked(), tmp_path, rest)[1] == expected
    assert len(rest.games) == len(whole.games) - kept
    again = StandIn()
    assert made(asked(), tmp_path, again)[1] == expected
    assert not again.games


def test_an_interruption_keeps_what_was_played_and_says_so(tmp_path: Path) -> None:
    _, expected = made(asked(), tmp_path / "whole")
    told: list[float] = []

    def stop(done: str, part: float) -> None:
        told.append(part)
        if len(told) == 30:
            raise KeyboardInterrupt

    with pytest.raises(TuningInterruptedError, match=r"interrupted; \d+ runs are kept in .*cut") as interrupted:
        tune(asked(), tmp_path / "cut", 1, stop, StandIn())
    assert interrupted.value.runs == (tmp_path / "cut" / FILE).read_bytes().count(b"\n") - 1 > 10
    assert told == sorted(told)
    assert made(asked(), tmp_path / "cut")[1] == expected


def test_a_greater_budget_goes_on_from_a_smaller_one(tmp_path: Path) -> None:
    few, many = StandIn(), StandIn()
    small, _ = made(asked(), tmp_path, few)
    large, _ = made(asked(budget=80), tmp_path, many)
    assert [each.values for each in large.trials[: len(small.trials)]] == [each.values for each in small.trials]
    assert large.after.severity <= small.after.severity
    assert len({(game.key, *game.law.parameters.items()) for game in (*few.games, *many.games)}) == len(
        [*few.games, *many.games]
    )


def test_no_candidate_is_run_that_amplifies_waves(tmp_path: Path) -> None:
    """The best gains lie beyond: with little filtering behind 70 ms, against the formula of the delay criterion."""
    tuning = prepare("soft-torque", conditions=["nominal"], gains=["P=300:600", "filter_time=0.01:0.5"], budget=100)
    condition = replace(tuning.league.conditions[0], drive={"lag": 0.0, "delay": 0.07})
    league = replace(tuning.league, conditions=(condition,))
    law = replace(league.laws[0], parameters={"slip": "compensated"})
    tuning = prepare_again(tuning, replace(league, laws=(law,)), tmp_path)
    stand_in = StandIn({"P": 450.0, "filter_time": 0.01})
    tuned, _ = made(tuning, tmp_path / "out", stand_in)

    def greatest(trial: Candidate) -> float:
        gains = Gains(trial.values["P"], soft_torque(STRING).stiffness, 0.0)
        frequencies = [0.01 * 1e5 ** (part / 1199) for part in range(1200)]
        T_f = trial.values["filter_time"]
        return max(reflection(STRING.impedance, 2000.0, gains, T_f, 0.075, w) for w in frequencies)

    run = [trial for trial in tuned.trials if trial.scores]
    assert 10 < len(run) < len(tuned.trials)
    assert len(stand_in.games) == len(run) + 1
    assert all(greatest(trial) <= 1.0 + 1e-5 for trial in run)  # margins have six digits
    amplifying = [trial for trial in tuned.trials if greatest(trial) > 1.0 + 1e-5]
    assert amplifying
    assert not any(trial.scores for trial in amplifying)
    assert not tuned.before.kept
    assert tuned.after.kept
    assert tuned.after.margin is not None
    assert tuned.after.margin.reflection == pytest.approx(greatest(tuned.after), rel=1e-5)


def prepare_again(tuning: Tuning, league: League, folder: Path) -> Tuning:
    """The same of a league with other conditions, by a file."""
    folder.mkdir(exist_ok=True)
    (condition,), (law,) = league.conditions, league.laws
    path = folder / "own.toml"
    path.write_text(
        f"settle = 60.0\njudge = 90.0\nstep_size = 0.01\n[laws.{law.name}]\nfmu = '{law.fmu}'\n"
        f"parameters = {{ slip = '{law.parameters['slip']}' }}\n[conditions.{condition.name}]\n"
        f"speed = {condition.speed}\nweight = {condition.weight}\n"
        f"drive = {{ lag = {condition.drive['lag']}, delay = {condition.drive['delay']} }}\n"
    )
    gains = [f"{gain.name}={gain.low}:{gain.high}" for gain in tuning.gains]
    return prepare(law.name, path, gains=gains, budget=tuning.budget)


def test_where_no_candidate_keeps_the_margin_a_sentence_says_how_near_it_was(tmp_path: Path) -> None:
    stand_in = StandIn()
    tuning = prepare("soft-torque", conditions=["nominal"], budget=10, reflection=0.1)
    sentence = r"none of 1\d candidates keeps the margin; the nearest reflects 0\.\d+ \(at most 0\.1\)"
    with pytest.raises(RunError, match=sentence):
        tune(tuning, tmp_path, 1, play=stand_in)
    assert {game.law.name: game.law.parameters for game in stand_in.games} == {"soft-torque": {}}


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ("soft-torque", {"mode": "own", **dict(zip(("P", "K", "J_v"), soft_torque(STRING), strict=True))}),
        ("z-torque", {"mode": "own", **dict(zip(("P", "K", "J_v"), soft_torque(STRING, 1.0), strict=True))}),
        ("absorber", {"mode": "own", **dict(zip(("c_f", "k_f", "J_a"), absorber(STRING), strict=True))}),
        ("tuned-pi-light", {"mode": "own", **dict(zip(("K_p", "K_i", "K_d"), tuned_pid(STRING, 500.0), strict=True))}),
    ],
)
def test_a_law_begins_with_what_it_is_by_formula(law: str, expected: dict[str, object]) -> None:
    tuning = prepare(law)
    assert dict(tuning.fixed) == expected
    assert len(tuning.linear) == len(tuning.league.conditions) == 7
    for gain in tuning.gains:
        assert gain.start == expected.get(gain.name, gain.start)
        assert gain.low < gain.start < gain.high


def test_what_is_not_free_stays_with_the_formula() -> None:
    tuning = prepare("soft-torque", gains=["filter_time=0.02:0.3"])
    assert tuning.fixed == {}
    assert tuning.candidate({"filter_time": 0.1}).parameters == {"filter_time": 0.1}


def test_an_fmu_is_tuned_as_it_comes_and_laws_that_are_not_known_have_no_margin(tmp_path: Path) -> None:
    pid, other = prepare("SpeedPid"), prepare("DissipativeLaw", conditions=["nominal"])
    assert pid.law.drive == {"mode": "torque"}
    assert pid.linear
    assert other.linear == ()
    tuned, files = made(replace(other, budget=20), tmp_path, StandIn({"P": 1.0}))
    assert all(trial.margin is None and trial.kept for trial in tuned.trials)
    assert tomllib.loads(files[PARAMETERS].decode())["provenance"]["margin"] == {"known": False}


def test_gains_are_spread_by_their_logarithm_and_written_with_four_digits() -> None:
    gain = Gain("P", "N.m.s/rad", 449.12, 200.0, 800.0)
    assert [gain.at(part) for part in (0.0, 0.5, 1.0)] == [200.0, 400.0, 800.0]
    assert gain.at(0.3) == float(f"{200 * 4**0.3:.4g}")
    assert gain.place_of(400.0) == pytest.approx(0.5)
    assert (gain.place_of(1.0), gain.place_of(1e9)) == (0.0, 1.0)
    level = Gain("c_1", "1", 0.3, 0.0, 0.8)
    assert level.at(0.25) == 0.2
    assert level.place_of(0.2) == pytest.approx(0.25)


def test_severity_orders_what_engineers_order() -> None:
    quick = Score(time_to_free=2.0, ssi=0.01, stuck_fraction=0.0, drive_swing=0.5, mean_top_speed=6.0)
    slow, rough = replace(quick, time_to_free=9.0), replace(quick, ssi=0.3)
    busy = replace(quick, drive_swing=3.0)
    stuck = replace(quick, time_to_free=math.inf, stuck_fraction=0.3, ssi=2.0)
    worse, failed = replace(stuck, stuck_fraction=0.6), Score(failure="it broke")
    assert severity(quick, 90.0) == pytest.approx(2.0 / 90.0 + 0.01 + 0.1 * 0.5 / 12.0)
    assert severity(quick, 90.0) < severity(slow, 90.0) < severity(rough, 90.0) < severity(stuck, 90.0)
    assert severity(quick, 90.0) < severity(busy, 90.0)
    assert severity(stuck, 90.0) < severity(worse, 90.0) < severity(failed, 90.0)
    assert overall([quick, failed], 90.0) == pytest.approx(0.75 * 4.0 + 0.25 * severity(quick, 90.0))


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "law": (
        lambda: prepare("soft-torqe"),
        "nor an FMU of that name; did you mean 'soft-torque'?",
    ),
    "drive": (lambda: prepare("ordinary"), "law 'ordinary' is the drive alone, which has nothing to tune"),
    "no law": (
        lambda: prepare("MudPulse", gains=["delay=0:1"]),
        "law 'MudPulse' gives none of Omega, motor_torque, WOB",
    ),
    "file": (lambda: prepare("none.fmu"), "none.fmu: there is no such file"),
    "condition": (lambda: prepare("soft-torque", conditions=["nominel"]), "did you mean 'nominal'?"),
    "gain": (lambda: prepare("soft-torque", gains=["filter_tim=1:2"]), "SoftTorque has no parameter 'filter_tim'; did"),
    "kind": (
        lambda: prepare("soft-torque", gains=["mode=1:2"]),
        "SoftTorque.mode is of type Enumeration; expected",
    ),
    "output": (lambda: prepare("soft-torque", gains=["Omega=1:2"]), "SoftTorque has no parameter 'Omega'"),
    "form": (lambda: prepare("soft-torque", gains=["P=1-2"]), "--gain P=1-2: expected the form name=low:high"),
    "reversed": (lambda: prepare("soft-torque", gains=["P=900:150"]), "goes from 900 to 150; expected the lesser num"),
    "endless": (lambda: prepare("soft-torque", gains=["P=1:inf"]), "goes from 1 to inf; expected finite numbers"),
    "beyond": (lambda: prepare("soft-torque", gains=["P=0:900"]), "goes from 0 to 900; SoftTorque.P is between 0.001"),
    "unknown": (lambda: prepare("soft-torque", gains=["c_a"]), "--gain c_a: its range is not known; expected the form"),
    "twice": (lambda: prepare("soft-torque", gains=["P", "P=1:2"]), "name a parameter twice; expected each once"),
    "nothing": (lambda: prepare("Autodriller"), "nothing is known of what to tune of Autodriller; expected --gain"),
    "budget": (lambda: prepare("soft-torque", budget=3), "--budget is 3; expected at least 10 candidates"),
    "seed": (lambda: prepare("soft-torque", seed=-1), "--seed is -1; expected a whole number >= 0"),
    "margin": (lambda: prepare("soft-torque", reflection=math.nan), "--reflection is nan; expected a finite number"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_tuned_is_refused_by_a_sentence(what: str) -> None:
    refused, sentence = WRONG[what]
    with pytest.raises(InputError) as error:
        refused()
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


OTHERS: dict[str, tuple[dict[str, object], str]] = {
    "seed": ({"seed": 2}, r"by seed \(1\)"),
    "margin": ({"reflection": 0.9, "damping": 0.1}, r"by reflection \(1\.0\), damping \(0\.0\)"),
    "gains": ({"gains": (Gain("P", "N.m.s/rad", 449.0, 200.0, 900.0),)}, "by gains"),
}


@pytest.mark.parametrize("other", OTHERS)
def test_a_folder_goes_on_with_the_tuning_it_holds_alone(other: str, tmp_path: Path) -> None:
    made(asked(budget=10), tmp_path)
    changes, sentence = OTHERS[other]
    with pytest.raises(CheckpointError, match=f"{sentence}.*expected the same, or another --output"):
        made(asked(**changes), tmp_path)


@pytest.mark.parametrize("line", [b"{}\n", b'{"values": {"P": 1.0}, "condition": "eight", "score": {}}\n', b"\xff\n"])
def test_a_damaged_journal_is_named_by_its_line(line: bytes, tmp_path: Path) -> None:
    made(asked(budget=10), tmp_path)
    lines = (tmp_path / FILE).read_bytes().splitlines(keepends=True)
    (tmp_path / FILE).write_bytes(b"".join([*lines[:3], line, *lines[4:]]))
    with pytest.raises(CheckpointError, match=r"evaluations\.jsonl, line 4: it is damaged"):
        made(asked(budget=10), tmp_path)


def test_a_folder_that_cannot_be_used_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(CosimError, match=r"output folder .*taken cannot be used"):
        tune(asked(), tmp_path / "taken", 1, play=StandIn())


@pytest.mark.skipif(sys.platform == "win32", reason="no locks on folders")
def test_two_programs_do_not_tune_in_one_folder(tmp_path: Path) -> None:
    with locked(tmp_path), pytest.raises(CheckpointError, match="another program is tuning there"):
        tune(asked(), tmp_path, 1, play=StandIn())


def test_what_is_refused_is_one_line_and_an_exit_code(tmp_path: Path) -> None:
    for arguments, sentence in (
        (
            ("soft-torque", "--gain", "P=900:150"),
            "error: --gain P=900:150 goes from 900 to 150; expected the lesser num",
        ),
        (("soft-torque", "--league", str(tmp_path / "none.toml")), "there is no such file"),
    ):
        done = CliRunner().invoke(app, ["tune", *arguments])
        assert done.exit_code == 2
        assert sentence in done.stderr
        assert done.stderr.count("\n") == 1


def test_ranges_are_read_from_a_league_and_refused_by_their_key(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(SHORT + "[tunes.soft]\nP = [200.0, 900.0]\nK = { times = [0.5, 2.0] }\n")
    assert load_league(path).tunes == {"soft": {"P": Range(200.0, 900.0), "K": Range(0.5, 2.0, times=True)}}
    found = {gain.name: (gain.low, gain.high) for gain in prepare("soft", path).gains}
    assert found == {"P": (200.0, 900.0), "K": pytest.approx((0.5 * 187.408, 2.0 * 187.408), rel=1e-5)}
    for written, sentence in {
        "P = [9, 2]": "tunes.soft.P goes from 9 to 2; expected the lesser number first",
        "P = [9]": "tunes.soft.P is [9]; expected two numbers, the least and the greatest",
        "P = { times = ['a', 2] }": "tunes.soft.P.times is ['a', 2]; expected two numbers",
        "P = { time = [1, 2] }": "unknown key 'tunes.soft.P.time'; did you mean 'times'?",
    }.items():
        path.write_text(f"{SHORT}[tunes.soft]\n{written}\n")
        with pytest.raises(InputError) as error:
            load_league(path)
        assert sentence in str(error.value)


def test_a_figure_is_drawn(tmp_path: Path) -> None:
    files = write(tune(asked(budget=10), tmp_path, 1, play=StandIn()), tmp_path)
    assert [path.name for path in files] == [PARAMETERS, CANDIDATES, FIGURE]
    assert (tmp_path / FILE).stat().st_size > 0
    assert files[-1].read_bytes().startswith(b"\x89PNG")


def test_help_says_what_can_be_asked_for() -> None:
    help_ = CliRunner().invoke(app, ["tune", "--help"], env={"COLUMNS": "200", "NO_COLOR": "1"})
    assert help_.exit_code == 0
    for option in ("--league", "--condition", "--gain", "--seed", "--budget", "--reflection", "--damping", "--workers"):
        assert option in help_.output


# From here on the FMUs play.


@pytest.mark.slow
def test_gains_by_formula_that_are_given_are_the_law_to_the_bit() -> None:
    for law in ("z-torque", "absorber", "tuned-pi-light"):
        tuning = prepare(law, conditions=["fast-heavy"])
        league = replace(tuning.league, settle=20.0, judge=25.0)
        start = {gain.name: gain.start for gain in tuning.gains}
        before, given = (score(league, each, league.conditions[0]) for each in (tuning.law, tuning.candidate(start)))
        assert before == replace(given, dip=before.dip) or (math.isnan(before.dip) and str(before) == str(given))


@pytest.mark.slow
def test_processes_and_kills_change_no_bit_and_run_and_league_take_what_comes_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("short.toml").write_text(SHORT)
    tuning = prepare("soft", Path("short.toml"), conditions=["heavy"], gains=["P", "K=50:600"], budget=12)
    for workers in (1, 2):
        write(tune(tuning, Path(str(workers)), workers), Path(str(workers)))
    assert contents(Path("1")) == contents(Path("2"))
    options = ["--condition", "heavy", "--gain", "P", "--gain", "K=50:600", "--budget", "12", "--workers", "2"]
    arguments = ["tune", "soft", "--league", "short.toml", *options, "--output", "3"]
    killed(tmp_path, signal.SIGKILL, *arguments)
    cut = killed(tmp_path, signal.SIGINT, *arguments)
    assert "runs are kept in 3, and the same command goes on from there" in cut
    assert "Traceback" not in cut
    table = finished(*arguments)
    assert "cosim league --parameters 3/parameters.toml" in table
    assert contents(Path("3")) == contents(Path("1"))
    lines = Path("3", FILE).read_text().splitlines()
    assert len(lines) == len(set(lines))
    parameters = tomllib.loads(Path("3", PARAMETERS).read_text())
    told = parameters["provenance"]
    assert told["severity"]["after"] <= told["severity"]["before"]
    assert "soft-tuned" in finished("league", "short.toml", "--parameters", f"3/{PARAMETERS}", "--law", "soft")
    scores = Path("runs", "league", "scores.csv").read_text()
    assert f"soft-tuned,heavy,{told['time_to_free']['heavy'][1]!r}," in scores


def finished(*arguments: str) -> str:
    """What a command says that succeeds, in this process."""
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    return done.output


def killed(folder: Path, how: signal.Signals, *arguments: str) -> str:
    """What a tuning says that gets a signal when it has played two runs more."""
    journal = folder / arguments[-1] / FILE
    enough = 2 + (journal.read_bytes().count(b"\n") if journal.exists() else 1)
    command = [sys.executable, "-c", "from cosim.cli.app import main; main()", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, cwd=folder, env=environment)
    while process.poll() is None and (not journal.exists() or journal.read_bytes().count(b"\n") < enough):
        time.sleep(0.005)
    process.send_signal(how)
    _, errors = process.communicate()  # which waits for the others too: they end with it
    assert process.returncode == (-how if how == signal.SIGKILL else 130), errors
    return errors
