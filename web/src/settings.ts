/** What the driller has set: defaults, presets, units, and how all of it stands in the page's address. */

import { STRING_NAMES, type DrillString } from "./theory";
import type { Tables } from "./core";

export const LAWS = {
  none: "none",
  tracking: "energy law (9), tracking form",
  weight: "weight law (22)",
  soft_torque: "soft torque",
  z_torque: "impedance matching",
  absorber: "tuned table at the top",
} as const;
export type Law = keyof typeof LAWS;
export type From = "rest" | "steady";
export type UnitSystem = "si" | "field";

export interface Settings {
  /** rad/s, rotary speed asked for */
  omega: number;
  /** N */
  weight: number;
  /** rad/s2, 0: at once */
  omegaRamp: number;
  /** N/s, 0: at once */
  weightRamp: number;
  law: Law;
  from: From;
  /** simulated seconds in a second */
  speed: number;
  units: UnitSystem;
  string: DrillString;
}

export function defaults(tables: Tables): Settings {
  const table = tables["DrillstringNeutral"] ?? {};
  const start = (name: string): number => table[name]?.[1] ?? 0;
  const string = Object.fromEntries(STRING_NAMES.map((name) => [name, start(name)])) as unknown as DrillString;
  return {
    omega: start("Omega"), weight: start("WOB"), omegaRamp: 5, weightRamp: 20000,
    law: "none", from: "rest", speed: 1, units: "si", string,
  };
}

type Changes = Partial<Omit<Settings, "string">> & { readonly string?: Partial<DrillString> };

export const PRESETS: readonly { readonly name: string; readonly changes: Changes }[] = [
  { name: "Fig. 2: stick-slip from rest", changes: {} },
  { name: "The same, from steady rotation", changes: { from: "steady" } },
  { name: "Fig. 3: less weight", changes: { weight: 31649 } },
  { name: "Fig. 4: higher speed", changes: { omega: 20 } },
  { name: "Fig. 5: weight law", changes: { law: "weight" } },
  { name: "Fig. 6: damping at the bit, c_b = 150", changes: { string: { c_b: 150 } } },
  { name: "Fig. 7: energy law, tracking form", changes: { law: "tracking" } },
  { name: "Soft torque at 8 rad/s", changes: { law: "soft_torque", omega: 8 } },
];

export function changed(settings: Settings, changes: Changes): Settings {
  return { ...settings, ...changes, string: { ...settings.string, ...changes.string } };
}

export interface Unit {
  readonly symbol: string;
  /** shown = value times factor */
  readonly factor: number;
}

const RPM: Unit = { symbol: "rpm", factor: 30 / Math.PI };
const KLBF: Unit = { symbol: "klbf", factor: 1 / 4448.2216152605 };
const UNITS: Record<UnitSystem, Record<string, Unit>> = {
  si: {
    "rad/s": { symbol: "rad/s", factor: 1 },
    "rad/s2": { symbol: "rad/s²", factor: 1 },
    N: { symbol: "kN", factor: 1e-3 },
    "N/s": { symbol: "kN/s", factor: 1e-3 },
    "N.m": { symbol: "kN·m", factor: 1e-3 },
    J: { symbol: "kJ", factor: 1e-3 },
    m: { symbol: "m", factor: 1 },
  },
  field: {
    "rad/s": RPM,
    "rad/s2": { symbol: "rpm/s", factor: RPM.factor },
    N: KLBF,
    "N/s": { symbol: "klbf/s", factor: KLBF.factor },
    "N.m": { symbol: "kft·lbf", factor: 1 / 1355.8179483314 },
    J: { symbol: "kft·lbf", factor: 1 / 1355.8179483314 },
    m: { symbol: "ft", factor: 1 / 0.3048 },
  },
};
const OTHERS: Record<string, string> = { "kg.m2": "kg·m²", "N.m.s/rad": "N·m·s/rad", "1": "" };

export function unit(system: UnitSystem, name: string): Unit {
  return UNITS[system][name] ?? { symbol: OTHERS[name] ?? name, factor: 1 };
}

const NUMBERS = ["omega", "weight", "omegaRamp", "weightRamp", "speed"] as const;

/** Write what differs from the defaults, as the part of an address behind "#". */
export function toAddress(settings: Settings, standard: Settings): string {
  const words = new URLSearchParams();
  for (const name of NUMBERS) {
    if (settings[name] !== standard[name]) {
      words.set(name, String(settings[name]));
    }
  }
  for (const name of ["law", "from", "units"] as const) {
    if (settings[name] !== standard[name]) {
      words.set(name, settings[name]);
    }
  }
  for (const name of STRING_NAMES) {
    if (settings.string[name] !== standard.string[name]) {
      words.set(name, String(settings.string[name]));
    }
  }
  return words.toString();
}

export type Limits = Readonly<Record<(typeof NUMBERS)[number] | keyof DrillString, readonly [number, number]>>;

/** Least and greatest value of every number, in SI: for the string those of its interface table. */
export function limits(tables: Tables): Limits {
  const table = tables["DrillstringNeutral"] ?? {};
  const string = STRING_NAMES.map((name) => {
    const [, , low = 0, high = Infinity] = table[name] ?? [];
    return [name, [low, high]];
  });
  return {
    ...(Object.fromEntries(string) as Record<keyof DrillString, readonly [number, number]>),
    omega: [0, 1e3], weight: [0, 1e7], omegaRamp: [0, 1e4], weightRamp: [0, 1e8], speed: [0.1, 100],
  };
}

/** Read settings from an address; what is missing or cannot be is as in the defaults. */
export function fromAddress(address: string, standard: Settings, bounds: Limits): Settings {
  const words = new URLSearchParams(address.replace(/^#/, ""));
  const settings = changed(standard, {});
  const number = (name: keyof Limits): number | null => {
    const [low, high] = bounds[name];
    const text = words.get(name);
    const value = text === null || text.trim() === "" ? NaN : Number(text);
    return value >= low && value <= high ? value : null;
  };
  for (const name of NUMBERS) {
    settings[name] = number(name) ?? standard[name];
  }
  for (const name of STRING_NAMES) {
    settings.string[name] = number(name) ?? standard.string[name];
  }
  const [law, from, units] = [words.get("law"), words.get("from"), words.get("units")];
  settings.law = law !== null && Object.hasOwn(LAWS, law) ? (law as Law) : standard.law;
  settings.from = from === "steady" || from === "rest" ? from : standard.from;
  settings.units = units === "field" || units === "si" ? units : standard.units;
  return settings;
}
