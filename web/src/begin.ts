/** When a run or a map is to be begun anew, and what the map is made for. */

import { LAWS } from "./laws";
import type { Settings } from "./settings";

/** Whether the law takes minutes to act, or never lets the string come to an end that could be told. */
export function hasNoMap({ law }: Settings): boolean {
  return law === "supervisor" || law === "top_supervisor" || law === "printed";
}

/** What the map is made for: the law switched on, or the string without it. */
export function mapped(settings: Settings): Settings {
  return { ...settings, enabled: true, law: hasNoMap(settings) ? "none" : settings.law };
}

function isTunable(gain: string): boolean {
  const [model = "", name = ""] = gain.split(".");
  return TABLES[model]?.[name]?.tunable === true;
}

/** What a run has to be begun anew for. */
export function begun({ law, drive, feed, gains, string, omega }: Settings): string {
  const begins = LAWS[law].gives?.endsWith("speed_ref") === true; // a supervisor begins with the speed
  const fixed = Object.entries(gains).filter(([gain]) => !isTunable(gain)).sort();
  return JSON.stringify([law, drive, feed, fixed, string, begins ? omega : 0]);
}

/** What a map has to be made anew for. */
export function mapKey({ law, drive, feed, gains, string }: Settings): string {
  return JSON.stringify([law, drive, feed, Object.entries(gains).sort(), string]);
}
