/** The worker of the run: goes on when asked to, and hands back rows of outputs and the torque along the string. */

import { Core } from "./core";
import { COLUMNS, STATIONS, type Answer, type Order } from "./orders";
import { replay } from "./replay";
import { Rig } from "./rig";
import type { Settings } from "./settings";
import { impedance, travelTime } from "./theory";

/** The waves that have left the ends of the string in the last travel time. */
class Waves {
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

let core: Core | null = null;
let rig: Rig | null = null;
let waves: Waves | null = null;
let run = 0;

function row(now: Rig): number[] {
  return COLUMNS.map((name) => (name === "time" ? now.time : now.plant.get(name)));
}

function answer(rows: number[]): void {
  if (waves) {
    const message: Answer = { kind: "rows", run, rows: Float64Array.from(rows), torque: waves.torque() };
    postMessage(message, { transfer: [message.rows.buffer, message.torque.buffer] });
  }
}

function start(settings: Settings): void {
  rig?.release();
  rig = null;
  if (core) {
    rig = new Rig(core, settings);
    waves = new Waves(rig);
    answer(row(rig));
  }
}

function advance(time: number): void {
  if (!rig || !waves) {
    return;
  }
  const rows: number[] = [];
  while (rig.time + rig.step <= time + 1e-9) {
    rig.advance();
    waves.record(rig);
    rows.push(...row(rig));
  }
  answer(rows);
}

async function obey(order: Order): Promise<void> {
  switch (order.kind) {
    case "load":
      core = await Core.load(order.bytes, order.tables);
      break;
    case "start":
      run = order.run;
      start(order.settings);
      break;
    case "set":
      if (rig) {
        rig.settings = order.settings;
      }
      break;
    case "advance":
      if (order.run === run) {
        advance(order.time);
      }
      break;
    case "replay":
      if (core) {
        postMessage({ kind: "replayed", rows: replay(core, order.program) } satisfies Answer);
      }
  }
}

let last: Promise<void> = Promise.resolve();
onmessage = (event: MessageEvent<Order>): void => {
  last = last
    .then(() => obey(event.data))
    .catch((error: unknown) => {
      postMessage({ kind: "failed", reason: error instanceof Error ? error.message : String(error) } satisfies Answer);
    });
};
