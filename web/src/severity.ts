/** How a run ends: its stick-slip index, and whether the bit still sticks. */

import type { Core } from "./core";
import type { Gain } from "./laws";
import { Rig } from "./rig";
import type { From, Settings } from "./settings";
import { hasDrive } from "./system";

const SETTLING = 50; // s
const WINDOW = 10; // s
const MOST_WINDOWS = 25; // near the threshold a swing takes minutes to grow or to die away
const SETTLED = 1e-3; // SSI of a swing that dies away
const STEADY = 0.05; // SSI of even rotation that noise of the sensors does not let settle

export interface Severity {
  /** (peak - minimum) / (2 mean) of the bit speed; infinite for a bit that does not turn */
  readonly ssi: number;
  readonly sticks: boolean;
}

/** Return how the bit turns in 10 s with speed and weight held, 50 s after the start or once it sticks or has settled. */
export function severity(core: Core, settings: Settings, from: From): Severity {
  const rig = new Rig(core, { ...settings, from, omegaRamp: 0, weightRamp: 0 });
  try {
    rig.leap(Math.round(SETTLING / rig.step));
    const settled = isNoisy(settings) ? STEADY : SETTLED;
    let found = watch(rig);
    for (let window = 1; window < MOST_WINDOWS && !found.sticks && found.ssi > settled; ++window) {
      found = watch(rig);
    }
    return found;
  } finally {
    rig.release();
  }
}

/** Whether there are sensors that have noise: gains outlive a drive that is not there any more. */
function isNoisy(settings: Settings): boolean {
  const noise: readonly Gain[] = ["TopDrive.speed_noise", "TopDrive.torque_noise"];
  return hasDrive(settings) && noise.some((gain) => (settings.gains[gain] ?? 0) > 0);
}

function watch(rig: Rig): Severity {
  const { plant } = rig;
  const [angle, stuck] = [plant.get("bit_angle"), plant.get("stuck_time")];
  let [least, most] = [Infinity, -Infinity];
  // the extremes are those since the last exchange with the law
  const leaps = rig.isAlone ? 1 : Math.round(WINDOW / rig.step);
  for (let leap = 0; leap < leaps; ++leap) {
    rig.leap(Math.round(WINDOW / rig.step / leaps));
    least = Math.min(least, plant.get("bit_speed_min"));
    most = Math.max(most, plant.get("bit_speed_max"));
  }
  const mean = (plant.get("bit_angle") - angle) / WINDOW;
  return { ssi: mean > 1e-9 ? (most - least) / (2 * mean) : Infinity, sticks: plant.get("stuck_time") > stuck };
}
