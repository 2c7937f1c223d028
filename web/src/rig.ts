/** The string with what acts on it, coupled by Gauss-Seidel: what the page shows and what the map is made of. */

import type { Core, Model } from "./core";
import type { Gain, Signal } from "./laws";
import type { Settings } from "./settings";
import { gainValue, system, type System } from "./system";
import { bitTorque, evenSpeed } from "./theory";

/** Part of the speed that is missing at a start from steady rotation: else an unstable one would last for long. */
const NUDGE = 0.01;
const MOST_ROUNDS = 5000; // of the exchange at the start, as cosim has them
const ROUNDING = 1e-13;

/** Approach a target at a rate for a time; a rate of 0 is without limit. */
function approach(value: number, target: number, rate: number, time: number): number {
  const reach = rate > 0 ? rate * time : Infinity;
  return Math.abs(target - value) <= reach ? target : value + Math.sign(target - value) * reach;
}

interface Flow {
  readonly to: number;
  readonly from: Model;
  readonly output: number;
}

/** A model of the system, where its inputs come from, and what the driller does to the others. */
interface Seat {
  readonly model: Model;
  readonly flows: readonly Flow[];
  readonly signals: readonly (readonly [string, Signal])[];
}

export class Rig {
  readonly plant: Model;
  readonly step: number;
  readonly system: System;
  time = 0;
  /** rad/s and N, as the ramps have come so far */
  omega: number;
  weight: number;
  readonly #models = new Map<string, Model>();
  readonly #seats: readonly Seat[];
  #count = 0;

  constructor(
    readonly core: Core,
    public settings: Settings,
  ) {
    this.system = system(settings, core.tables);
    this.step = this.system.step;
    this.omega = settings.omega;
    this.weight = settings.weight;
    this.system.parts.forEach(({ name, model }) => this.#models.set(name, core.model(model)));
    this.plant = this.part("plant");
    this.#seats = this.system.parts.map(({ name }) => this.#seat(name));
    try {
      this.#start();
    } catch (error) {
      this.release();
      throw error;
    }
  }

  /** Whether nothing but driller and string is there, which alone can go far in one step. */
  get isAlone(): boolean {
    return this.#seats.length === 1;
  }

  part(name: string): Model {
    const model = this.#models.get(name);
    if (!model) {
      throw new Error(`the system has no ${name}`);
    }
    return model;
  }

  /** Return the value of a variable by its part: `drive.Omega`. */
  get(port: string): number {
    const [name = "", variable = ""] = port.split(".");
    return this.part(name).get(variable);
  }

  /** Go on by a step: every part in turn is given what those before it have put out at its end. */
  advance(): void {
    // the time of an FMU: where its last step has ended, and the communication point plus the step
    const end = this.#count * this.step + this.step;
    const { omega, weight } = this;
    const next = approach(omega, this.settings.omega, this.settings.omegaRamp, this.step);
    const load = approach(weight, this.settings.weight, this.settings.weightRamp, this.step);
    for (const { model, flows, signals } of this.#seats) {
      for (const [name, signal] of signals) {
        if (signal === "omega") {
          this.#ramp(model, name, omega, next, this.settings.omegaRamp);
        } else if (signal === "weight" && !model.isParameter(name)) {
          this.#ramp(model, name, weight, load, this.settings.weightRamp);
        } else {
          this.#hold(model, name, signal);
        }
      }
      gather(model, flows);
      model.step(this.time, end);
    }
    [this.omega, this.weight, this.time] = [next, load, end];
    this.#count += 1;
  }

  /** Go on with inputs as they are for many steps at once; so can the plant alone. */
  leap(steps: number): void {
    if (!this.isAlone) {
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

  /** Take up other settings, with parameters that can be tuned; the others are as at the start. */
  tune(settings: Settings): void {
    this.settings = settings;
    for (const { name, parameters } of system(settings, this.core.tables).parts) {
      const model = this.part(name);
      Object.entries(parameters)
        .filter(([parameter]) => model.row(parameter).tunable === true && name !== "plant")
        .forEach(([parameter, value]) => model.set(parameter, value));
    }
  }

  release(): void {
    this.#models.forEach((model) => model.release());
  }

  #seat(name: string): Seat {
    const model = this.part(name);
    const own = <Value>(all: readonly (readonly [string, Value])[]): (readonly [string, Value])[] =>
      all.filter(([port]) => port.startsWith(`${name}.`)).map(([port, value]) => [port.slice(name.length + 1), value]);
    const flows = own(this.system.connections.map(({ from, to }) => [to, from] as const)).map(([input, port]) => {
      const [source = "", output = ""] = port.split(".");
      const from = this.part(source);
      return { to: model.reference(input), from, output: from.reference(output) };
    });
    return { model, flows, signals: own(Object.entries(this.system.signals)) };
  }

  #start(): void {
    const { plant, settings } = this;
    for (const { name, parameters } of this.system.parts) {
      const model = this.part(name);
      Object.entries(parameters).forEach(([parameter, value]) => model.set(parameter, value));
    }
    if (settings.from === "steady") {
      const speed = this.#steadySpeed();
      plant.set("initial_speed", speed * (1 - NUDGE));
      plant.set("initial_torque", bitTorque(settings.string, this.#weightAt(speed), speed));
    }
    for (const { model, signals } of this.#seats) {
      signals.forEach(([name, signal]) => this.#hold(model, name, signal));
      model.start(0);
    }
    this.#exchange();
  }

  /** Hand on values until none changes, or those of a loop that has no solution have been handed on often enough. */
  #exchange(): void {
    for (let round = 1; round <= MOST_ROUNDS && !this.isAlone; ++round) {
      let [moving, rounding] = [false, true];
      for (const { model, flows } of this.#seats) {
        const before = flows.map(({ to }) => model.values[to] as number);
        gather(model, flows);
        const after = flows.map(({ to }) => model.values[to] as number);
        if (after.some((value, place) => !Object.is(value, before[place]))) {
          moving = true;
          rounding &&= after.every((value, place) => isNear(value, before[place] as number));
          model.start(0);
        }
      }
      if (!moving || (rounding && round > 100)) {
        return;
      }
    }
  }

  #steadySpeed(): number {
    const { string, law } = this.settings;
    const compensated = ["SoftTorque", "TopAbsorber"].some((model) => {
      const gain: Gain = `${model}.slip`;
      return this.system.parts.some((part) => part.model === model) && gainValue(this.settings, this.core.tables, gain) === 2;
    });
    if (law === "tracking" || compensated) {
      return this.omega; // the law asks the drive for what the bit needs beside it
    }
    if (law !== "weight") {
      return evenSpeed(string, this.omega, this.weight) ?? 0;
    }
    let speed = this.omega;
    for (let round = 0; round < 50; ++round) {
      speed = evenSpeed(string, this.omega, this.#weightAt(speed)) ?? 0;
    }
    return speed;
  }

  #weightAt(speed: number): number {
    if (this.settings.law !== "weight") {
      return this.weight;
    }
    const law = this.part("law");
    return Math.min(law.get("K_w") * speed + law.get("WOB_0"), law.get("WOB_max"));
  }

  #value(signal: Signal): number {
    switch (signal) {
      case "omega":
        return this.omega;
      case "weight":
        return this.weight;
      case "torque":
        return bitTorque(this.settings.string, this.weight, this.omega);
      case "enabled":
        return this.settings.enabled ? 1 : 0;
      case "start":
        return this.settings.from === "steady" ? this.settings.omega : 0;
    }
  }

  /** Set an input, or a parameter that can be tuned, to what it is now. */
  #hold(model: Model, name: string, signal: Signal): void {
    const { low = -Infinity, high = Infinity } = model.row(name);
    model.set(name, Math.min(high, Math.max(low, this.#value(signal))));
  }

  #ramp(model: Model, name: string, value: number, next: number, rate: number): void {
    model.set(name, rate === 0 ? next : value);
    model.setSlope(name, rate === 0 || next === value ? 0 : (next - value) / this.step);
  }
}

function gather(model: Model, flows: readonly Flow[]): void {
  const { values } = model;
  for (const { to, from, output } of flows) {
    values[to] = from.values[output] as number;
  }
}

/** Whether values differ by rounding alone; what has grown beyond all numbers has not settled. */
function isNear(one: number, two: number): boolean {
  return Number.isFinite(one) && Math.abs(one - two) <= ROUNDING * Math.max(Math.abs(one), Math.abs(two));
}
