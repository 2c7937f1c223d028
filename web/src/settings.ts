/** What the driller has set: defaults, presets, units, and how all of it stands in the page's address. */

import type { Tables } from "./core";
import { DRIVES, FEEDS, LAWS, type Drive, type Feed, type Gain, type Law } from "./laws";
import { gains, models, offered, standard as standardGain } from "./system";
import { STRING_NAMES, type DrillString } from "./theory";

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
  /** whether the law acts; those without a switch always do */
  enabled: boolean;
  drive: Drive;
  feed: Feed;
  /** parameters of the law, the drive and the driller that have been set */
  gains: Readonly<Record<Gain, number>>;
  from: From;
  /** simulated seconds in a second */
  speed: number;
  units: UnitSystem;
  string: DrillString;
}

export function defaults(tables: Tables): Settings {
  const table = tables["DrillstringNeutral"] ?? {};
  const start = (name: string): number => table[name]?.start ?? 0;
  const string = Object.fromEntries(STRING_NAMES.map((name) => [name, start(name)])) as unknown as DrillString;
  return {
    omega: start("Omega"), weight: start("WOB"), omegaRamp: 5, weightRamp: 20000,
    law: "none", enabled: true, drive: "ideal", feed: "direct", gains: {}, from: "rest", speed: 1, units: "si", string,
  };
}

type Changes = Partial<Omit<Settings, "string">> & { readonly string?: Partial<DrillString> };

export interface Preset {
  readonly name: string;
  readonly changes: Changes;
  /** the scenario of cosim that it is, if it is one with a law */
  readonly scenario?: string;
}

const NOISE = { "TopDrive.speed_noise": 0.05, "TopDrive.torque_noise": 150 } as const;

export const PRESETS: Readonly<Record<string, readonly Preset[]>> = {
  "Figures of the paper": [
    { name: "Fig. 2: stick-slip from rest", changes: {}, scenario: "stick-slip" },
    { name: "The same, from steady rotation", changes: { from: "steady" } },
    { name: "Fig. 3: less weight", changes: { weight: 31649 }, scenario: "lower-wob" },
    { name: "Fig. 4: higher speed", changes: { omega: 20 }, scenario: "higher-speed" },
    { name: "Fig. 5: weight law", changes: { law: "weight" }, scenario: "wob-law" },
    { name: "Fig. 6: damping at the bit, c_b = 150", changes: { string: { c_b: 150 } } },
    { name: "Fig. 7: energy law, tracking form", changes: { law: "tracking" } },
  ],
  "Cures to switch on": [
    {
      name: "Soft torque", scenario: "soft-torque",
      changes: { law: "soft_torque", omega: 8, drive: "top_drive", enabled: false, gains: NOISE },
    },
    {
      name: "Tuned table at the top", scenario: "top-absorber",
      changes: { law: "absorber", omega: 9, drive: "top_drive", enabled: false, gains: NOISE },
    },
    {
      name: "Speed controller, 3000 m", scenario: "speed-pid",
      changes: { law: "speed_pid", omega: 12, enabled: false, string: { L: 3000 }, gains: { "TopDrive.J_r": 500 } },
    },
  ],
  "Cures at work": [
    { name: "Soft torque at 8 rad/s", changes: { law: "soft_torque", omega: 8 } },
    { name: "Supervisor, by mud pulse", scenario: "supervision", changes: { law: "supervisor" } },
    {
      name: "Supervisor, from the top", scenario: "top-supervision",
      changes: { law: "top_supervisor", gains: NOISE },
    },
    {
      name: "Autodriller with soft torque", scenario: "autodriller",
      changes: { law: "soft_torque", omega: 8, feed: "autodriller" },
    },
  ],
};

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
    W: { symbol: "kW", factor: 1e-3 },
    m: { symbol: "m", factor: 1 },
    "m/s, drilled": { symbol: "m/h", factor: 3600 },
  },
  field: {
    "rad/s": RPM,
    "rad/s2": { symbol: "rpm/s", factor: RPM.factor },
    N: KLBF,
    "N/s": { symbol: "klbf/s", factor: KLBF.factor },
    "N.m": { symbol: "kft·lbf", factor: 1 / 1355.8179483314 },
    J: { symbol: "kft·lbf", factor: 1 / 1355.8179483314 },
    W: { symbol: "hp", factor: 1 / 745.69987158227 },
    m: { symbol: "ft", factor: 1 / 0.3048 },
    "m/s": { symbol: "ft/s", factor: 1 / 0.3048 },
    "m/s, drilled": { symbol: "ft/h", factor: 3600 / 0.3048 },
  },
};
/** Those that are as they are in either system, but for how they are written. */
function written(name: string): string {
  return name === "1" ? "" : name === "x" ? "× real time" : name.replaceAll(".", "·").replace("m2", "m²").replace("s2", "s²");
}

export function unit(system: UnitSystem, name: string): Unit {
  return UNITS[system][name] ?? { symbol: written(name), factor: 1 };
}

const NUMBERS = ["omega", "weight", "omegaRamp", "weightRamp", "speed"] as const;

/** Write what differs from the defaults, as the part of an address behind "#"; of gains, those of the law that is chosen. */
export function toAddress(settings: Settings, standard: Settings, tables: Tables): string {
  const words = new URLSearchParams();
  for (const name of NUMBERS) {
    if (settings[name] !== standard[name]) {
      words.set(name, String(settings[name]));
    }
  }
  for (const name of ["law", "drive", "feed", "from", "units"] as const) {
    if (settings[name] !== standard[name]) {
      words.set(name, settings[name]);
    }
  }
  if (!settings.enabled) {
    words.set("enabled", "0");
  }
  for (const name of STRING_NAMES) {
    if (settings.string[name] !== standard.string[name]) {
      words.set(name, String(settings.string[name]));
    }
  }
  for (const gain of allGains(settings, tables)) {
    const value = settings.gains[gain];
    if (value !== undefined && value !== standardGain(settings, tables, gain)) {
      words.set(gain, String(value));
    }
  }
  return words.toString();
}

function allGains(settings: Settings, tables: Tables): readonly Gain[] {
  return models(settings).flatMap((model) => gains(settings, tables, model).map((name): Gain => `${model}.${name}`));
}

/** A gain as near to what was asked for as its interface table allows; null for what is no number or no item. */
export function gainWithin(settings: Settings, tables: Tables, gain: Gain, asked: number): number | null {
  const [model = "", name = ""] = gain.split(".");
  const { low = -Infinity, high = Infinity, items, whole } = tables[model]?.[name] ?? {};
  if (!Number.isFinite(asked) || (items !== undefined && !offered(settings, tables, gain).includes(asked))) {
    return null;
  }
  const kept = Math.min(high, Math.max(low, asked));
  return whole === true ? Math.round(kept) : kept;
}

export type Limits = Readonly<Record<(typeof NUMBERS)[number] | keyof DrillString, readonly [number, number]>>;

/** Least and greatest value of every number, in SI: for the string those of its interface table. */
export function limits(tables: Tables): Limits {
  const table = tables["DrillstringNeutral"] ?? {};
  const string = STRING_NAMES.map((name) => {
    const { low = 0, high = Infinity } = table[name] ?? {};
    return [name, [low, high]];
  });
  return {
    ...(Object.fromEntries(string) as Record<keyof DrillString, readonly [number, number]>),
    omega: [0, 1e3], weight: [0, 1e7], omegaRamp: [0, 1e4], weightRamp: [0, 1e8], speed: [0.1, 100],
  };
}

/** Read settings from an address; what is missing or cannot be is as in the defaults. */
export function fromAddress(address: string, standard: Settings, bounds: Limits, tables: Tables): Settings {
  const words = new URLSearchParams(address.replace(/^#/, ""));
  const settings = changed(standard, {});
  const numeric = (name: string): number => {
    const text = words.get(name);
    return text === null || text.trim() === "" ? NaN : Number(text);
  };
  const number = (name: keyof Limits): number | null => {
    const [low, high] = bounds[name];
    const value = numeric(name);
    return value >= low && value <= high ? value : null;
  };
  const one = <Name extends string>(name: string, all: Readonly<Record<Name, unknown>>, other: Name): Name => {
    const word = words.get(name);
    return word !== null && Object.hasOwn(all, word) ? (word as Name) : other;
  };
  for (const name of NUMBERS) {
    settings[name] = number(name) ?? standard[name];
  }
  for (const name of STRING_NAMES) {
    settings.string[name] = number(name) ?? standard.string[name];
  }
  settings.law = one("law", LAWS, standard.law);
  settings.drive = one("drive", DRIVES, standard.drive);
  settings.feed = one("feed", FEEDS, standard.feed);
  settings.from = one("from", { rest: 0, steady: 0 }, standard.from);
  settings.units = one("units", UNITS, standard.units);
  settings.enabled = words.get("enabled") !== "0";
  const set = allGains(settings, tables).map((gain) => [gain, numeric(gain)] as const);
  settings.gains = Object.fromEntries(set.filter(([gain, value]) => gainWithin(settings, tables, gain, value) === value));
  return settings;
}
