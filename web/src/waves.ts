/** The waves that have left the ends of the string in the last travel time, and the torque they make along it. */

import { STATIONS } from "./orders";
import type { Rig } from "./rig";
import { impedance, travelTime } from "./theory";

export class Waves {
  readonly #down: Float64Array;
  readonly #up: Float64Array;
  readonly #z: number;
  readonly #delay: number;
  #newest = 0;

  constructor(rig: Rig) {
    const { string } = rig.settings;
    this.#z = impedance(string);
    this.#delay = travelTime(string) / rig.step;
    const size = Math.ceil(this.#delay) + 2;
    this.#down = new Float64Array(size);
    this.#up = new Float64Array(size);
    const [speed, twist] = [0.5 * rig.plant.get("initial_speed"), rig.plant.get("initial_torque") / (2 * this.#z)];
    this.#down.fill(speed + twist);
    this.#up.fill(speed - twist);
    this.record(rig);
  }

  record(rig: Rig): void {
    const { plant } = rig;
    const down = 0.5 * (plant.get("top_speed") + plant.get("top_torque") / this.#z);
    this.#newest = (this.#newest + 1) % this.#down.length;
    this.#down[this.#newest] = down;
    this.#up[this.#newest] = plant.get("bit_speed") - this.#at(this.#down, 1);
  }

  /** Torque from the top to the bit [N m]. */
  torque(): Float64Array {
    return Float64Array.from({ length: STATIONS }, (_, station) => {
      const depth = station / (STATIONS - 1);
      return this.#z * (this.#at(this.#down, depth) - this.#at(this.#up, 1 - depth));
    });
  }

  /** A wave at a part of the travel time from where it came from. */
  #at(wave: Float64Array, part: number): number {
    const back = part * this.#delay;
    const whole = Math.floor(back);
    const size = wave.length;
    const one = wave[(this.#newest - whole + size) % size] ?? 0;
    const two = wave[(this.#newest - whole - 1 + size) % size] ?? 0;
    return one + (back - whole) * (two - one);
  }
}
