/** The rows of a run that have come in, the newest last; the oldest make room. */

import { COLUMNS } from "./orders";

const MOST = 60000; // rows: 600 s of the plant alone

export class History {
  #names: readonly string[] = COLUMNS;
  #columns = new Map<string, number[]>(COLUMNS.map((name) => [name, []]));

  get length(): number {
    return this.column("time").length;
  }

  /** Begin anew, with columns beside those of the string. */
  begin(more: readonly string[]): void {
    this.#names = [...COLUMNS, ...more];
    this.#columns = new Map(this.#names.map((name) => [name, []]));
  }

  /** Values by row; none of a column that there is not. */
  column(name: string): readonly number[] {
    return this.#columns.get(name) ?? [];
  }

  take(rows: Float64Array): void {
    const all = [...this.#columns.values()];
    for (let place = 0; place < rows.length; place += all.length) {
      all.forEach((values, column) => values.push(rows[place + column] as number));
    }
    if (this.length > 1.1 * MOST) {
      const excess = this.length - MOST;
      all.forEach((values) => values.splice(0, excess));
    }
  }

  last(name: string): number {
    return this.column(name).at(-1) ?? 0;
  }

  /** Index of the first row within so many seconds before the last. */
  since(seconds: number): number {
    const time = this.column("time");
    const begin = this.last("time") - seconds;
    let [low, high] = [0, time.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((time[middle] as number) < begin - 1e-9) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

  csv(): string {
    const lines = [this.#names.join(",")];
    const all = [...this.#columns.values()];
    for (let row = 0; row < this.length; ++row) {
      lines.push(all.map((values) => String(values[row])).join(","));
    }
    return `${lines.join("\n")}\n`;
  }
}

/** How the bit has turned lately. */
export interface Motion {
  readonly ssi: number;
  readonly state: "starting" | "steady" | "vibrating" | "sticking" | "stuck";
}

const WINDOW = 10; // s
const STEADY = 0.05; // SSI below which rotation is called steady
const EARLY = 2; // s after the start in which nothing is said

export function motion(history: History): Motion {
  const [speed, angle, stuck, time] = ["bit_speed", "bit_angle", "stuck_time", "time"].map((name) => history.column(name)) as [
    readonly number[], readonly number[], readonly number[], readonly number[]];
  const first = history.since(WINDOW);
  const last = history.length - 1;
  const duration = (time[last] ?? 0) - (time[first] ?? 0);
  if (duration <= 0) {
    return { ssi: NaN, state: "starting" };
  }
  let [least, most] = [Infinity, -Infinity];
  for (let row = first; row <= last; ++row) {
    least = Math.min(least, speed[row] as number);
    most = Math.max(most, speed[row] as number);
  }
  const mean = ((angle[last] as number) - (angle[first] as number)) / duration;
  const ssi = mean > 1e-9 ? (most - least) / (2 * mean) : Infinity;
  const held = (stuck[last] as number) - (stuck[first] as number);
  if ((time[last] as number) < EARLY) {
    return { ssi, state: "starting" };
  }
  if (held > 0) {
    return { ssi, state: held > 0.999 * duration ? "stuck" : "sticking" };
  }
  return { ssi, state: ssi < STEADY ? "steady" : "vibrating" };
}
