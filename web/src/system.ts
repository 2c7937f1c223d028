/** What is coupled with what, in the order in which `cosim` steps it by Gauss-Seidel. */

import type { Tables } from "./core";
import { DRILLER, DRIVE, DRIVE_MODES, LAWS, type Gain, type Signal } from "./laws";
import type { Settings } from "./settings";
import { bitTorque, STRING_NAMES, type DrillString } from "./theory";

export interface Part {
  readonly name: string;
  readonly model: string;
  readonly parameters: Readonly<Record<string, number>>;
}

export interface System {
  /** in stepping order */
  readonly parts: readonly Part[];
  readonly connections: readonly { readonly from: string; readonly to: string }[];
  readonly signals: Readonly<Record<string, Signal>>;
  /** s, between communication points */
  readonly step: number;
}

export const PLANT = "DrillstringNeutral";
const STEP = 0.01; // s

/** What the law gives: a speed, a torque of the motor, a weight, or nothing. */
function given(settings: Settings): string | undefined {
  return LAWS[settings.law].gives?.split(".")[1];
}

export function hasDrive(settings: Settings): boolean {
  return settings.drive === "top_drive" || LAWS[settings.law].needsDrive === true;
}

export function hasDriller(settings: Settings): boolean {
  return settings.feed === "autodriller" && given(settings) !== "WOB";
}

/** Models beside the string, each once, the law's first. */
export function models(settings: Settings): readonly string[] {
  const beside = [...(hasDrive(settings) ? [DRIVE] : []), ...(hasDriller(settings) ? [DRILLER] : [])];
  return [...Object.values(LAWS[settings.law].parts), ...beside];
}

/** What the console sets itself, from the string, the speed and the weight. */
const OURS: readonly Gain[] = [
  "DissipativeLaw.form", "WeightOnBitLaw.WOB_0", "Autodriller.WOB_initial", "SpeedPid.torque_initial", "SpeedPid.J_r",
  "SpeedSupervisor.speed_initial",
];

/** Parameters that can be set for a model with the law that is chosen, in the order of its table. */
export function gains(settings: Settings, tables: Tables, model: string): readonly string[] {
  const law = LAWS[settings.law];
  return Object.entries(tables[model] ?? {})
    .filter(([name, row]) => row.text !== undefined && !(STRING_NAMES as readonly string[]).includes(name))
    .map(([name]) => name)
    .filter((name) => ![...OURS, ...(law.idle ?? [])].includes(`${model}.${name}`))
    .filter((name) => offered(settings, tables, `${model}.${name}`).length !== 1);
}

/** The values of a choice that there are with the law; none of a number. */
export function offered(settings: Settings, tables: Tables, gain: Gain): readonly number[] {
  const [model = "", name = ""] = gain.split(".");
  if (gain === "TopDrive.mode") {
    const { speed, servo, torque } = DRIVE_MODES;
    return given(settings) === "motor_torque" ? [torque] : [speed, servo];
  }
  const items = tables[model]?.[name]?.items ?? [];
  return LAWS[settings.law].offered?.[gain] ?? items.map((_, place) => place + 1);
}

/** What holds where nothing has been set. */
export function standard(settings: Settings, tables: Tables, gain: Gain): number {
  const [model = "", name = ""] = gain.split(".");
  const value = LAWS[settings.law].standard?.[gain] ?? tables[model]?.[name]?.start ?? 0;
  const choices = offered(settings, tables, gain);
  return choices.length > 0 && !choices.includes(value) ? (choices[0] as number) : value;
}

/** The value of a parameter beside the string. */
export function gainValue(settings: Settings, tables: Tables, gain: Gain): number {
  const value = settings.gains[gain];
  const choices = offered(settings, tables, gain);
  const can = value !== undefined && (choices.length === 0 || choices.includes(value));
  return can ? value : standard(settings, tables, gain);
}

/** Whether a parameter counts, as some do with an item of a choice alone. */
export function counts(settings: Settings, tables: Tables, gain: Gain): boolean {
  const [model = "", name = ""] = gain.split(".");
  const row = tables[model]?.[name];
  if (row?.by === undefined) {
    return true;
  }
  const chosen = gainValue(settings, tables, `${model}.${row.by}`);
  return row.with?.includes(tables[model]?.[row.by]?.items?.[chosen - 1] ?? "") === true;
}

function parameters(settings: Settings, tables: Tables, model: string): Record<string, number> {
  const table = tables[model] ?? {};
  const values: Record<string, number> = {};
  for (const [name] of Object.entries(table).filter(([, each]) => each.text !== undefined)) {
    const ofString = (STRING_NAMES as readonly string[]).includes(name);
    values[name] = ofString ? settings.string[name as keyof DrillString] : gainValue(settings, tables, `${model}.${name}`);
  }
  return { ...values, ...ours(settings, tables, model, values) };
}

function ours(settings: Settings, tables: Tables, model: string, values: Record<string, number>): Record<string, number> {
  const { omega, weight, string } = settings;
  switch (model) {
    case "WeightOnBitLaw":
      return { WOB_0: Math.max(weight, 1), WOB_max: Math.max(values["WOB_max"] ?? 0, weight) };
    case "Autodriller":
      return { WOB_initial: weight, WOB_max: Math.max(values["WOB_max"] ?? 0, weight) };
    case "SpeedSupervisor":
      return { speed_initial: omega };
    case "SpeedPid": {
      const torque = settings.from === "steady" ? bitTorque(string, weight, omega) : 0;
      return { J_r: gainValue(settings, tables, `${DRIVE}.J_r`), torque_initial: torque };
    }
    default:
      return {};
  }
}

/** Lay out the system that the settings ask for. */
export function system(settings: Settings, tables: Tables): System {
  const law = LAWS[settings.law];
  const [drive, driller] = [hasDrive(settings), hasDriller(settings)];
  const part = (name: string, model: string): Part => ({ name, model, parameters: parameters(settings, tables, model) });
  const parts = Object.entries(law.parts).map(([name, model]) => part(name, model));
  // A law of the speed answers at once: without a drive between it and the string, it comes first.
  const gives = given(settings);
  const before = gives === "motor_torque" || (gives === "Omega" && !drive);
  return {
    parts: [
      ...(drive ? [part("drive", DRIVE)] : []),
      ...(before && drive ? parts : []),
      ...(driller ? [part("driller", DRILLER)] : []),
      ...(before && !drive ? parts : []),
      part("plant", PLANT),
      ...(before ? [] : parts),
    ],
    ...wired(settings),
    step: law.step ?? STEP,
  };
}

function wired(settings: Settings): Pick<System, "connections" | "signals"> {
  const law = LAWS[settings.law];
  const drive = hasDrive(settings);
  const connections: { from: string; to: string }[] = [];
  const signals: Record<string, Signal> = { ...law.set };
  const connect = (from: string, to: string): void => void connections.push({ from, to });
  const sensed = (name: string): string => (drive ? `drive.${name}_measured` : `plant.${name}`);
  if (drive) {
    connect("plant.top_speed", "drive.top_speed");
    connect("plant.top_torque", "drive.top_torque");
    connect("drive.Omega", "plant.Omega");
  }
  Object.entries(law.takes ?? {}).forEach(([to, from]) => connect(from.includes(".") ? from : sensed(from), to));
  const turned = drive ? "drive.Omega_command" : "plant.Omega";
  if (given(settings) === "motor_torque") {
    connect("law.motor_torque", "drive.motor_torque");
    signals[turned] = "start";
  } else if (law.gives && given(settings) !== "WOB") {
    connect(law.gives, turned);
  } else {
    signals[turned] = "omega";
  }
  if (given(settings) === "WOB") {
    connect("law.WOB", "plant.WOB");
  } else if (hasDriller(settings)) {
    connect("plant.bit_speed", "driller.bit_speed");
    connect("driller.WOB", "plant.WOB");
    signals["driller.WOB_ref"] = "weight";
  } else {
    signals["plant.WOB"] = "weight";
  }
  return { connections, signals };
}
