/** The rows of a run that have come in, the newest last; the oldest make room. */

import { COLUMNS, WIDTH } from "./orders";

const MOST = 60000; // rows: 600 s of the plant alone

export class History {
  readonly columns: Record<(typeof COLUMNS)[number], number[]> = Object.fromEntries(
    COLUMNS.map((name) => [name, []]),
  ) as unknown as Record<(typeof COLUMNS)[number], number[]>;

  get length(): number {
    return this.columns.time.length;
  }

  clear(): void {
    COLUMNS.forEach((name) => (this.columns[name].length = 0));
  }

  take(rows: Float64Array): void {
    for (let place = 0; place < rows.length; place += WIDTH) {
      COLUMNS.forEach((name, column) => this.columns[name].push(rows[place + column] as number));
    }
    if (this.length > 1.1 * MOST) {
      COLUMNS.forEach((name) => this.columns[name].splice(0, this.length - MOST));
    }
  }

  last(name: (typeof COLUMNS)[number]): number {
    return this.columns[name].at(-1) ?? 0;
  }

  /** Index of the first row within so many seconds before the last. */
  since(seconds: number): number {
    const { time } = this.columns;
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
    const lines = [COLUMNS.join(",")];
    for (let row = 0; row < this.length; ++row) {
      lines.push(COLUMNS.map((name) => String(this.columns[name][row])).join(","));
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
  const { bit_speed: speed, bit_angle: angle, stuck_time: stuck, time } = history.columns;
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
