/** The worker of the severity map: all places of a grid over drive speed and weight, coarse to fine. */

import { Core } from "./core";
import { AXES, type MapAnswer, type MapOrder, type Square } from "./orders";
import type { Settings } from "./settings";
import { severity } from "./severity";

const COARSEST = 8; // cells of the finest grid along a square of the coarsest

let core: Promise<Core> | null = null;
let wanted = 0;

function between([low, high]: readonly [number, number], part: number): number {
  return low + part * (high - low);
}

function judge(loaded: Core, settings: Settings, column: number, row: number, size: number): Square {
  const omega = between(AXES.omega, (column + 0.5 * size) / AXES.cells);
  const weight = between(AXES.weight, (row + 0.5 * size) / AXES.cells);
  const here = { ...settings, omega, weight };
  const rest = severity(loaded, here, "rest");
  const steady = severity(loaded, here, "steady");
  return {
    column, row, size, rest: rest.ssi, steady: steady.ssi, restSticks: rest.sticks, steadySticks: steady.sticks,
  };
}

/** Let messages come in: a new map puts an end to the one under way. */
function breathe(): Promise<void> {
  return new Promise((resolve) => {
    setTimeout(resolve, 0);
  });
}

async function map(loaded: Core, settings: Settings, run: number): Promise<void> {
  const finest = settings.law === "none" ? 1 : 2; // a law takes ten times as long
  let total = 0;
  for (let size = COARSEST; size >= finest; size /= 2) {
    total += (AXES.cells / size) ** 2;
  }
  let done = 0;
  for (let size = COARSEST; size >= finest; size /= 2) {
    let squares: Square[] = [];
    let last = performance.now();
    for (let row = 0; row < AXES.cells; row += size) {
      for (let column = 0; column < AXES.cells; column += size) {
        squares.push(judge(loaded, settings, column, row, size));
        done += 1;
        if (performance.now() - last > 100) {
          postMessage({ run, squares, part: done / total } satisfies MapAnswer);
          [squares, last] = [[], performance.now()];
          await breathe();
          if (run !== wanted) {
            return;
          }
        }
      }
    }
    postMessage({ run, squares, part: done / total } satisfies MapAnswer);
  }
}

onmessage = async (event: MessageEvent<MapOrder>): Promise<void> => {
  const order = event.data;
  if (order.kind === "load") {
    core = Core.load(order.bytes, order.tables);
  } else if (core) {
    wanted = order.run;
    try {
      await map(await core, order.settings, order.run);
    } catch (error) {
      const failed = error instanceof Error ? error.message : String(error);
      postMessage({ run: order.run, squares: [], part: 0, failed } satisfies MapAnswer);
    }
  }
};
