"""Ten minutes under weights and frictions that change at random: finite, within limits, nothing wound up."""

from __future__ import annotations

import numpy as np
import pytest

from tests.laws.rig import STEP, WEIGHT, engaged_behind_a_drive
from tests.plant.drive import PLANT, Drive

pytestmark = pytest.mark.slow

NOISE = {"speed_noise": 0.05, "torque_noise": 150.0}
SECONDS = 600.0


@pytest.mark.parametrize("law", ["SoftTorque", "TopAbsorber"])
def test_a_law_bears_ten_minutes_of_changing_formations(law: str) -> None:
    """After ten minutes of it, a minute at the nominal weight ends as if nothing had been."""
    random = np.random.default_rng(3)
    rotor = Drive("TopDrive", {"Omega_command": 10.0, **NOISE})
    with Drive(PLANT, {}) as plant, rotor, Drive(law, {"speed_ref": 10.0}) as soft:
        sizes: set[int] = set()
        bit: list[float] = []
        for k in range(round((SECONDS + 90.0) / STEP)):
            now = (k + 1) * STEP
            if k % 500 == 0 and now < SECONDS:
                plant.put(WOB=float(random.uniform(0.0, 1.2 * WEIGHT)), mu_sb=float(random.uniform(0.5, 0.9)))
                soft.put(enabled=bool(random.random() < 0.8))
                sizes |= {len(soft.serialized()), len(rotor.serialized())}
            if now >= SECONDS and k % 500 == 0:
                plant.put(WOB=WEIGHT, mu_sb=0.8)
                soft.put(enabled=True)
            top = {name: plant.get(name) for name in ("top_speed", "top_torque")}
            soft.put(**{name: rotor.get(f"{name}_measured") for name in top})
            soft.go(now)
            rotor.put(Omega_command=soft.get("Omega"), **top)
            rotor.go(now)
            plant.put(Omega=rotor.get("Omega"))
            plant.go(now)
            assert abs(soft.get("Omega")) <= 40.0
            assert 0.0 <= rotor.get("motor_torque_applied") <= 6e4
            bit.append(plant.get("bit_speed"))
    assert len(sizes) == 2
    assert np.isfinite(bit).all()
    assert np.mean(bit[-2000:]) == pytest.approx(6.205, abs=0.02)
    fresh = engaged_behind_a_drive(law, 10.0, 0.0, drive=NOISE)
    assert np.ptp(bit[-2000:]) <= 1.5 * np.ptp(fresh.columns["bit_speed"][-2000:])
