"""The console in Chromium: what a driller sees and does, and what it must never do."""

from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from fmu_src.fmus import MODELS
from models.parameters import DrillstringParameters
from models.theory import critical_omega
from tests.web.programs import PROGRAMS, as_json, bits, native

pytestmark = [pytest.mark.slow]
HERE = Path(__file__).parent
LIMIT = 400e3  # bytes of the page
WEIGHT = 97347.0  # N, of the paper


@pytest.fixture(scope="module")
def report(node: str, chromium: str, console: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What tests/web/browser.mjs has seen."""
    folder = tmp_path_factory.mktemp("browser")
    command = [node, HERE / "browser.mjs", console / "console.html", chromium, folder]
    subprocess.run(command, input=as_json(), text=True, check=True, timeout=240)
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


def test_it_is_one_small_file_that_asks_nobody_for_anything(report: dict[str, Any], console: Path) -> None:
    assert (console / "console.html").stat().st_size < LIMIT
    assert report["requests"] == []
    assert report["errors"] == []


def test_it_is_there_at_once_and_keeps_real_time(report: dict[str, Any]) -> None:
    assert report["first_picture_ms"] < 1000.0
    assert report["per_second"] > 57.0  # of 60 that the browser asks for: a busy machine loses one now and then
    assert report["pace"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_browser_gives_the_bits_of_the_native_fmu(report: dict[str, Any], name: str) -> None:
    assert base64.b64decode(report["rows"][name]) == bits(native(PROGRAMS[name]))


def test_at_10_rad_s_the_bit_sticks_from_rest_and_not_from_steady_rotation(report: dict[str, Any]) -> None:
    assert report["from_rest"] == "sticking"
    assert report["from_steady"] == "steady"
    assert report["live_from_rest"].startswith("Sticking and slipping, SSI ")


def test_the_threshold_is_that_of_the_theory(report: dict[str, Any]) -> None:
    assert (
        report["threshold"]
        == f"linear threshold: {critical_omega(DrillstringParameters(), WEIGHT):.3f} rad/s at this weight"
    )
    assert "8.345" in report["threshold"]


@pytest.mark.parametrize("law", ["tracking", "weight", "soft_torque", "z_torque", "absorber"])
def test_each_law_holds_the_bit_at_speed_from_rest(report: dict[str, Any], law: str) -> None:
    assert report["laws"][law] == "steady"


def test_a_speed_controller_with_a_heavy_rotor_does_not_free_the_bit(report: dict[str, Any]) -> None:
    assert report["laws"]["speed_pid"] == "sticking"


def test_a_law_switched_on_during_the_run_frees_the_bit(report: dict[str, Any]) -> None:
    assert report["switched_off"] == "sticking"
    assert report["went_on"], "the run began anew"
    assert report["switched_on"] == "steady"
    assert "enabled=0" not in report["switched"]
    assert "law=soft_torque" in report["switched"]
    assert "TopDrive.speed_noise=0.05" in report["switched"]


def test_what_is_typed_is_kept_within_the_ranges_of_the_interface_tables(report: dict[str, Any]) -> None:
    low = next(each.minimum for each in MODELS["SoftTorque"].variables if each.name == "Omega_max")
    assert low is not None
    assert report["typed"] == {
        "number-omega abc": "8", "number-weight -3": "0", "number-speed 1000": "100", "number-omegaRamp 1e9": "10000",
        "gain-SoftTorque-filter_time 0.05": "0.05", "gain-SoftTorque-Omega_max -1": f"{low:g}",
        "gain-TopDrive-seed 2.7": "3",
    }  # fmt: skip
    assert report["tuned"] == [True, 2], "the run began anew for a parameter that can be tuned"
    assert report["own"], "the gains that mode own takes are not shown"
    gains = {"SoftTorque.filter_time": 0.05, "SoftTorque.Omega_max": low, "TopDrive.seed": 3, "SoftTorque.mode": 3}
    assert gains.items() <= report["gains"].items()


def test_garbage_in_the_address_is_as_nothing(report: dict[str, Any]) -> None:
    confused = report["confused"]
    assert (confused["omega"], confused["weight"], confused["speed"], confused["string"]["L"]) == (10, WEIGHT, 1, 1172)
    assert (confused["law"], confused["drive"], confused["gains"]) == ("none", "ideal", {})


def test_inside_another_page_it_fits_and_leads_out_of_it(report: dict[str, Any]) -> None:
    height, heading = report["inside"]
    assert height <= 720
    assert heading == 1, "the heading is for readers alone"
    assert report["alone"] == "console.html#speed=10&law=absorber"


def test_the_map_tells_the_bistable_region_from_the_rest(report: dict[str, Any]) -> None:
    def at(omega: float, weight: float) -> dict[str, Any]:
        column, row = (omega - 1.0) / 24.0 * 64.0, (weight - 5000.0) / 195000.0 * 64.0
        finest = [
            square for square in report["squares"]
            if square["column"] <= column < square["column"] + square["size"]
            and square["row"] <= row < square["row"] + square["size"]
        ]  # fmt: skip
        return min(finest, key=lambda square: square["size"])

    def sticks(omega: float, weight: float) -> tuple[bool, bool]:
        return at(omega, weight)["restSticks"], at(omega, weight)["steadySticks"]

    assert sticks(10.0, WEIGHT) == (True, False)
    assert sticks(7.0, WEIGHT) == (True, True)
    assert sticks(20.0, WEIGHT) == (False, False)
    assert sticks(10.0, 31649.0) == (False, False)


def test_settings_come_from_the_address_and_go_there(report: dict[str, Any]) -> None:
    shared = report["shared"]
    assert (shared["omega"], shared["weight"], shared["units"], shared["string"]["L"]) == (12.5, 80000, "field", 2000)
    assert (shared["law"], shared["string"]["c_b"]) == ("none", 0.03), "what cannot be is as it was"
    assert float(report["shown"]) == pytest.approx(12.5 * 30.0 / 3.141592653589793, abs=1e-3)
    assert "omega=10.47" in report["address"]


def test_what_the_core_refuses_is_told_in_its_words(report: dict[str, Any]) -> None:
    assert report["trouble"].startswith("This cannot be run: ")
    assert "mu_sb" in report["trouble"]


def test_the_run_is_saved_with_names_and_start(report: dict[str, Any]) -> None:
    names, first = (line.split(",") for line in report["csv"])
    assert names[:4] == ["time", "Omega", "WOB", "bit_speed"]
    assert dict(zip(names, map(float, first), strict=True))["time"] == 0.0


def test_the_map_takes_fingers_and_arrow_keys_and_presets_are_the_figures(report: dict[str, Any]) -> None:
    speed, weight = report["tapped"]
    assert 20.0 < speed < 25.0
    assert 80e3 < weight < 140e3
    assert report["moved"] == pytest.approx([speed - 0.25, weight + 2500.0])
    assert report["preset"] == [20.0, WEIGHT]


def test_the_space_bar_pauses(report: dict[str, Any]) -> None:
    assert report["paused"] == "Resume"


@pytest.mark.parametrize("look", ["wide", "narrow", "dark", "law", "embedded"])
def test_axe_finds_nothing_and_nothing_sticks_out(report: dict[str, Any], look: str) -> None:
    assert report["axe"][look] == []
    assert report["scroll"][look] == 0
