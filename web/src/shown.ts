/** What is recorded and shown of a run beside the string: of the law, the drive and the driller. */

import { LAWS } from "./laws";
import type { Settings } from "./settings";
import { hasDrive, hasDriller } from "./system";

export interface Shown {
  /** a variable by its part, as it stands in the CSV file */
  readonly port: string;
  /** with its unit, among the numbers */
  readonly label?: string;
  readonly unit?: string;
  /** as a line of a trace */
  readonly trace?: "speed" | "torque";
  readonly line?: string;
  /** whose limit or guard it tells of */
  readonly flag?: string;
}

const LAW: Readonly<Record<string, readonly Shown[]>> = {
  SoftTorque: [{ port: "law.enabled" }, { port: "law.limit_active", flag: "law" }],
  TopAbsorber: [{ port: "law.enabled" }, { port: "law.limit_active", flag: "law" }],
  DissipativeLaw: [{ port: "law.limit_active", flag: "law" }, { port: "law.guard_active", flag: "guard" }],
  SpeedPid: [{ port: "law.enabled" }, { port: "law.limit_active", flag: "law" }],
  WeightOnBitLaw: [],
  MudPulse: [{ port: "link.measured", label: "Severity received", unit: "1" }],
  BitSpeedObserver: [{ port: "observer.bit_speed", trace: "speed", line: "bit, as the top shows it" }],
  SpeedSupervisor: [
    { port: "supervisor.enabled" },
    { port: "supervisor.severity", label: "Severity measured", unit: "1" },
    { port: "supervisor.limit_active", flag: "supervisor" },
  ],
};
const DRIVE: readonly Shown[] = [
  { port: "drive.motor_torque_applied", label: "Motor torque", unit: "N.m", trace: "torque", line: "of the motor" },
  { port: "drive.limit_active", flag: "drive" },
];
const DRILLER: readonly Shown[] = [
  { port: "driller.rop", label: "Rate of penetration", unit: "m/s, drilled" },
  { port: "driller.depth", label: "Depth drilled", unit: "m" },
  { port: "driller.limit_active", flag: "autodriller" },
];

export function shown(settings: Settings): readonly Shown[] {
  return [
    ...Object.values(LAWS[settings.law].parts).flatMap((model) => LAW[model] ?? []),
    ...(hasDrive(settings) ? DRIVE : []),
    ...(hasDriller(settings) ? DRILLER : []),
  ];
}
