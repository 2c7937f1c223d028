/** What the page asks of its workers, and what they answer. */

import type { Tables } from "./core";
import type { Program } from "./replay";
import type { Settings } from "./settings";

export const COLUMNS = [
  "time", "Omega", "WOB", "bit_speed", "top_speed", "bit_torque", "top_torque", "energy", "bit_stuck", "stuck_time",
  "bit_angle", "top_angle",
] as const;
/** Places along the string at which its torque is shown. */
export const STATIONS = 96;

export type Order =
  | { readonly kind: "load"; readonly bytes: ArrayBuffer; readonly tables: Tables }
  | { readonly kind: "start"; readonly settings: Settings; readonly run: number }
  | { readonly kind: "set"; readonly settings: Settings }
  | { readonly kind: "advance"; readonly time: number; readonly run: number }
  | { readonly kind: "replay"; readonly program: Program };

export type Answer =
  | { readonly kind: "rows"; readonly run: number; readonly rows: Float64Array; readonly torque: Float64Array }
  | { readonly kind: "replayed"; readonly rows: Float64Array }
  | { readonly kind: "failed"; readonly reason: string };

/** Axes of the map [rad/s, N] and its finest grid. */
export const AXES = { omega: [1, 25], weight: [5000, 200000], cells: 64 } as const;

export type MapOrder =
  | { readonly kind: "load"; readonly bytes: ArrayBuffer; readonly tables: Tables }
  | { readonly kind: "map"; readonly settings: Settings; readonly run: number };

/** What a square of the map shows: its corner and size in cells of the finest grid. */
export interface Square {
  readonly column: number;
  readonly row: number;
  readonly size: number;
  readonly rest: number;
  readonly steady: number;
  readonly restSticks: boolean;
  readonly steadySticks: boolean;
}

export const KINDS = ["steady", "bistable", "sticks", "still"] as const;
export type Kind = (typeof KINDS)[number];

export function kind(square: Square): Kind {
  if (!square.restSticks && !square.steadySticks) {
    return "steady";
  }
  if (square.rest === Infinity && square.steady === Infinity) {
    return "still";
  }
  return square.steadySticks ? "sticks" : "bistable";
}

/** Squares of a map, and which part of the grid of this size of square is done with them. */
export interface MapAnswer {
  readonly run: number;
  readonly squares: readonly Square[];
  readonly size: number;
  readonly part: number;
  readonly complete: boolean;
  /** why there is no map */
  readonly failed?: string;
}

