/** The laws that there are, and what else may stand between the driller and the string. */

export type Law =
  | "none" | "soft_torque" | "z_torque" | "absorber" | "tracking" | "printed" | "speed_pid" | "weight" | "supervisor"
  | "top_supervisor";

/** What an input follows: speed and weight as the ramps have come, the torque these take, a switch, or what is at the start. */
export type Signal = "omega" | "weight" | "torque" | "enabled" | "start";

/** A parameter by its model: `SoftTorque.P`. */
export type Gain = `${string}.${string}`;

export interface Kind {
  readonly title: string;
  readonly group: string;
  /** models by the names of the parts they are */
  readonly parts: Readonly<Record<string, string>>;
  /** outputs by the inputs they go to; without a part's name, what is seen of the top: by the drive's sensors if there is one */
  readonly takes?: Readonly<Record<string, string>>;
  /** what the driller sets */
  readonly set?: Readonly<Record<string, Signal>>;
  /** what of it the next one is given: a speed, a torque of the motor, or a weight */
  readonly gives?: `${string}.${"Omega" | "motor_torque" | "WOB" | "speed_ref"}`;
  /** s, time between exchanges */
  readonly step?: number;
  readonly needsDrive?: boolean;
  /** values that hold where none has been set, other than those of the tables */
  readonly standard?: Readonly<Record<Gain, number>>;
  /** items of choices that are offered, if not all */
  readonly offered?: Readonly<Record<Gain, readonly number[]>>;
  /** what has no meaning for it */
  readonly idle?: readonly Gain[];
}

const ENDS = { "law.top_speed": "top_speed", "law.top_torque": "top_torque" } as const;
const SWITCHED = { "law.speed_ref": "omega", "law.enabled": "enabled" } as const;
const ENERGY = {
  parts: { law: "DissipativeLaw" }, gives: "law.Omega",
  takes: { "law.top_speed": "top_speed", "law.bit_speed": "plant.bit_speed" },
  set: { "law.bit_speed_ref": "omega", "law.bit_torque_ref": "torque" },
} as const;

const SPEED = "Acting on the drive speed";
const TORQUE = "Acting on the motor torque";
const WEIGHT = "Acting on the weight on bit";
const SUPERVISED = "Raising the set point";

export const LAWS: Readonly<Record<Law, Kind>> = {
  none: { title: "none", group: "", parts: {} },
  soft_torque: {
    title: "soft torque", group: SPEED, parts: { law: "SoftTorque" }, takes: ENDS, set: SWITCHED, gives: "law.Omega",
    offered: { "SoftTorque.mode": [1, 3] },
  },
  z_torque: {
    title: "impedance matching", group: SPEED, parts: { law: "SoftTorque" }, takes: ENDS, set: SWITCHED, gives: "law.Omega",
    standard: { "SoftTorque.mode": 2 }, offered: { "SoftTorque.mode": [2, 3] },
  },
  absorber: {
    title: "tuned table at the top", group: SPEED, parts: { law: "TopAbsorber" }, takes: ENDS, set: SWITCHED, gives: "law.Omega",
  },
  // Its answer to the top's speed is at once, so it is sampled more often.
  tracking: {
    ...ENERGY, title: "energy law (9), tracking form", group: SPEED, step: 0.005,
    standard: { "DissipativeLaw.form": 2 }, idle: ["DissipativeLaw.c_2", "DissipativeLaw.top_speed_min"],
  },
  printed: {
    ...ENERGY, title: "energy law (9), as printed", group: SPEED, step: 0.001,
    standard: { "DissipativeLaw.form": 1 },
  },
  speed_pid: {
    title: "speed controller (PID)", group: TORQUE, parts: { law: "SpeedPid" }, takes: { "law.Omega": "drive.Omega_measured" },
    set: SWITCHED, gives: "law.motor_torque", needsDrive: true,
  },
  weight: {
    title: "weight law (22)", group: WEIGHT, parts: { law: "WeightOnBitLaw" }, takes: { "law.bit_speed": "plant.bit_speed" },
    set: { "law.WOB_0": "weight" }, gives: "law.WOB",
  },
  supervisor: {
    title: "supervisor, by mud pulse", group: SUPERVISED, parts: { link: "MudPulse", supervisor: "SpeedSupervisor" },
    takes: {
      "supervisor.bit_speed": "plant.bit_speed", "link.value": "supervisor.severity", "supervisor.measured": "link.measured", "supervisor.valid": "link.valid",
    },
    set: { "supervisor.enabled": "enabled" }, gives: "supervisor.speed_ref", standard: { "MudPulse.range": 5 },
  },
  top_supervisor: {
    title: "supervisor, from the top", group: SUPERVISED,
    parts: { observer: "BitSpeedObserver", supervisor: "SpeedSupervisor" },
    takes: {
      "observer.top_speed": "top_speed", "observer.top_torque": "top_torque", "supervisor.bit_speed": "observer.bit_speed",
      "supervisor.measured": "supervisor.severity",
    },
    set: { "supervisor.enabled": "enabled" }, gives: "supervisor.speed_ref", needsDrive: true,
    standard: { "BitSpeedObserver.jump": 10 },
  },
};

export const DRIVES = { ideal: "ideal", top_drive: "with lag, limits and sensors" } as const;
export type Drive = keyof typeof DRIVES;
export const FEEDS = { direct: "set directly", autodriller: "held by an autodriller" } as const;
export type Feed = keyof typeof FEEDS;

export const DRIVE = "TopDrive";
export const DRILLER = "Autodriller";
export const DRIVE_MODES = { speed: 1, servo: 2, torque: 3 } as const;

/** Titles of what a law consists of and what stands beside it, over their parameters. */
export const TITLES: Readonly<Record<string, string>> = {
  SoftTorque: "Virtual drive", TopAbsorber: "Table", DissipativeLaw: "Energy law", SpeedPid: "Speed controller",
  WeightOnBitLaw: "Weight law", SpeedSupervisor: "Supervisor", MudPulse: "Mud pulse", BitSpeedObserver: "Observer",
  TopDrive: "Drive", Autodriller: "Autodriller",
};
