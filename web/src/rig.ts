/** The string with the law that acts on it: what the page shows and what the map is made of. */

import type { Core, Model } from "./core";
import type { Law, Settings } from "./settings";
import { bitTorque, evenSpeed, STRING_NAMES } from "./theory";

interface Coupling {
  readonly model: string;
  readonly parameters: Readonly<Record<string, number>>;
  /** inputs of the law that are outputs of the plant */
  readonly measured: readonly string[];
  /** s, time between exchanges */
  readonly step: number;
}

const TOP = ["top_speed", "top_torque"] as const;
const COUPLINGS: Record<Exclude<Law, "none">, Coupling> = {
  // Its answer to the top's speed is at once, so it is sampled more often.
  tracking: { model: "DissipativeLaw", parameters: { form: 2 }, measured: ["top_speed", "bit_speed"], step: 0.005 },
  weight: { model: "WeightOnBitLaw", parameters: {}, measured: ["bit_speed"], step: 0.01 },
  soft_torque: { model: "SoftTorque", parameters: { mode: 1, enabled: 1 }, measured: TOP, step: 0.01 },
  z_torque: { model: "SoftTorque", parameters: { mode: 2, enabled: 1 }, measured: TOP, step: 0.01 },
  absorber: { model: "TopAbsorber", parameters: { enabled: 1 }, measured: TOP, step: 0.01 },
};
const STEP = 0.01; // s, of the plant alone

/** Part of the speed that is missing at a start from steady rotation: else an unstable one would last for long. */
const NUDGE = 0.01;

/** Approach a target at a rate for a time; a rate of 0 is without limit. */
function approach(value: number, target: number, rate: number, time: number): number {
  const reach = rate > 0 ? rate * time : Infinity;
  return Math.abs(target - value) <= reach ? target : value + Math.sign(target - value) * reach;
}

export class Rig {
  readonly plant: Model;
  readonly step: number;
  time = 0;
  /** rad/s and N, as the ramps have come so far */
  omega: number;
  weight: number;
  readonly #law: Model | null;
  readonly #coupling: Coupling | null;
  #count = 0;

  constructor(
    core: Core,
    public settings: Settings,
  ) {
    this.#coupling = settings.law === "none" ? null : COUPLINGS[settings.law];
    this.step = this.#coupling?.step ?? STEP;
    this.omega = settings.omega;
    this.weight = settings.weight;
    this.plant = core.model("DrillstringNeutral");
    this.#law = this.#coupling ? core.model(this.#coupling.model) : null;
    try {
      this.#start();
    } catch (error) {
      this.release();
      throw error;
    }
  }

  /** Go to a time that is a multiple of the step, hearing of every exchange; the plant alone may go in one step. */
  advance(): void {
    const from = this.#count * this.step;
    const end = (this.#count + 1) * this.step;
    const omega = approach(this.omega, this.settings.omega, this.settings.omegaRamp, this.step);
    const weight = approach(this.weight, this.settings.weight, this.settings.weightRamp, this.step);
    if (this.#law && this.#coupling) {
      this.#exchange(this.#law);
      this.#law.step(from, end);
      this.#obey(this.#law);
    } else {
      this.#ramp("Omega", this.omega, omega, end - from);
      this.#ramp("WOB", this.weight, weight, end - from);
    }
    this.plant.step(from, end);
    [this.omega, this.weight, this.time] = [omega, weight, end];
    this.#count += 1;
  }

  /** Go on with inputs as they are for many steps at once; so can the plant alone. */
  leap(steps: number): void {
    if (this.#law) {
      for (let step = 0; step < steps; ++step) {
        this.advance();
      }
      return;
    }
    const end = (this.#count + steps) * this.step;
    this.plant.step(this.time, end);
    this.#count += steps;
    this.time = end;
  }

  release(): void {
    this.plant.release();
    this.#law?.release();
  }

  #start(): void {
    const { plant, settings } = this;
    const law = this.#law;
    STRING_NAMES.forEach((name) => plant.set(name, settings.string[name]));
    if (settings.from === "steady") {
      const speed = this.#steadySpeed();
      plant.set("initial_speed", speed * (1 - NUDGE));
      plant.set("initial_torque", bitTorque(settings.string, this.#weightAt(speed), speed));
    }
    plant.set("Omega", this.omega);
    plant.set("WOB", this.weight);
    if (law && this.#coupling) {
      STRING_NAMES.filter((name) => law.has(name)).forEach((name) => law.set(name, settings.string[name]));
      Object.entries(this.#coupling.parameters).forEach(([name, value]) => law.set(name, value));
      plant.start(0);
      this.#exchange(law);
      law.start(0);
      this.#obey(law);
    }
    plant.start(0);
  }

  #steadySpeed(): number {
    if (this.settings.law === "tracking") {
      return this.omega; // the law asks the drive for what the bit needs beside it
    }
    const { string } = this.settings;
    if (this.settings.law !== "weight") {
      return evenSpeed(string, this.omega, this.weight) ?? 0;
    }
    let speed = this.omega;
    for (let round = 0; round < 50; ++round) {
      speed = evenSpeed(string, this.omega, this.#weightAt(speed)) ?? 0;
    }
    return speed;
  }

  #weightAt(speed: number): number {
    const law = this.#law;
    return this.settings.law === "weight" && law
      ? Math.min(law.get("K_w") * speed + this.weight, law.get("WOB_max"))
      : this.weight;
  }

  #exchange(law: Model): void {
    this.#coupling?.measured.forEach((name) => law.set(name, this.plant.get(name)));
    if (law.has("speed_ref")) {
      law.set("speed_ref", this.omega);
    }
    if (law.has("bit_speed_ref")) {
      law.set("bit_speed_ref", this.omega);
      law.set("bit_torque_ref", bitTorque(this.settings.string, this.weight, this.omega));
    }
    if (law.has("WOB_0")) {
      law.set("WOB_0", Math.max(this.weight, 1));
      law.set("WOB_max", Math.max(300000, this.weight));
    }
  }

  #obey(law: Model): void {
    this.plant.set("Omega", law.has("Omega") ? law.get("Omega") : this.omega);
    this.plant.set("WOB", law.has("WOB") ? law.get("WOB") : this.weight);
  }

  #ramp(name: string, value: number, next: number, time: number): void {
    const jumps = this.settings[name === "Omega" ? "omegaRamp" : "weightRamp"] === 0;
    this.plant.set(name, jumps ? next : value);
    this.plant.setSlope(name, jumps || next === value ? 0 : (next - value) / time);
  }
}
