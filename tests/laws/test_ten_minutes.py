"""Ten minutes under weights and formations that change at random, as `make endurance` takes a day of: all is borne."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import typer

import tests.endurance.__main__ as command
from cosim.system.structure import Port
from tests.endurance.endure import Outcome, endure
from tests.endurance.rigs import EVERY, RIGS, Draws

TEN_MINUTES = 1.0 / 6.0


@pytest.mark.slow
@pytest.mark.parametrize("law", RIGS)
def test_a_law_bears_ten_minutes_of_changing_formations(law: str) -> None:
    """Finite, within limits, with a state that stays as large as it was, and in the end as if nothing had been."""
    outcome = endure(RIGS[law], TEN_MINUTES)
    assert outcome.faults == ()
    assert outcome.hours == pytest.approx(TEN_MINUTES)
    assert 0.0 <= outcome.stuck < 1.0


@pytest.mark.slow
def test_a_limit_that_is_passed_and_a_speed_that_is_another_are_faults() -> None:
    """A narrower limit, and a driller asked again before his integrator has forgotten, are found out."""
    narrow = replace(RIGS["soft-torque"], bounds={**RIGS["soft-torque"].bounds, "drive.Omega": (9.0, 11.0)})
    (fault,) = endure(narrow, 0.02).faults
    assert fault.startswith("drive.Omega went from ")
    hasty = replace(RIGS["autodriller"], afterwards=30.0)
    (fault,) = endure(hasty, 0.02).faults
    assert fault.startswith("plant.bit_speed is ")


def test_what_is_drawn_is_held_and_ends_nominal() -> None:
    draws = Draws((1.0, 2.0, 3.0))
    times = np.array([0.0, 0.5 * EVERY, EVERY, 2.0 * EVERY, 100.0 * EVERY])
    assert draws.values(times).tolist() == [1.0, 1.0, 2.0, 3.0, 3.0]
    assert draws.left_values(times).tolist() == [1.0, 1.0, 1.0, 2.0, 3.0]
    assert draws.breakpoints == (EVERY, 2.0 * EVERY)
    target = Port.parse("plant.WOB")
    first, again, other = (RIGS["soft-torque"].system(9, seed).inputs[target] for seed in (1, 1, 2))
    assert first == again != other


@pytest.mark.parametrize(("faults", "code"), [((), 0), (("plant.bit_speed at t = 3.00 s is no finite number",), 1)])
def test_the_command_tells_by_its_exit_code_whether_all_was_borne(
    faults: tuple[str, ...], code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "endure", lambda *_: Outcome(24.0, 1500.0, 1.0, 20.0, 0.1, 0.2, faults))
    with pytest.raises(typer.Exit) as ended:
        command.main(["soft-torque"], 24.0, 1)
    assert ended.value.exit_code == code
    said = capsys.readouterr().out
    assert ("failed" in said, faults[0] in said if faults else False) == (bool(code), bool(code))
