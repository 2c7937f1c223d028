/** The worker of the severity map: all places of a grid over drive speed and weight, coarse to fine. */

import { Core } from "./core";
import { AXES, kind, type Kind, type MapAnswer, type MapOrder, type Square } from "./orders";
import type { Settings } from "./settings";
import { severity } from "./severity";
import { models } from "./system";

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

/** The kinds of a grid's squares, to tell where the next finer one can show anything new. */
class Grid {
  readonly #kinds = new Map<string, Kind>();

  constructor(readonly size: number) {}

  take(square: Square): void {
    this.#kinds.set(`${square.column} ${square.row}`, kind(square));
  }

  /** Whether the square that holds a place differs in kind from one beside it. */
  isMixed(column: number, row: number): boolean {
    const [left, low] = [column - (column % this.size), row - (row % this.size)];
    const around = [-1, 0, 1].flatMap((x) =>
      [-1, 0, 1].map((y) => this.#kinds.get(`${left + x * this.size} ${low + y * this.size}`)),
    );
    return new Set(around.filter((each) => each !== undefined)).size > 1;
  }
}

/** Places of a grid to be computed: all, or only those where the one before it is mixed. */
function places(size: number, before: Grid | null): [number, number][] {
  const found: [number, number][] = [];
  for (let row = 0; row < AXES.cells; row += size) {
    for (let column = 0; column < AXES.cells; column += size) {
      if (before === null || before.isMixed(column, row)) {
        found.push([column, row]);
      }
    }
  }
  return found;
}

async function map(loaded: Core, settings: Settings, run: number): Promise<void> {
  const finest = models(settings).length === 0 ? 1 : 2; // what acts on the string takes ten times as long
  let before: Grid | null = null;
  for (let size = COARSEST; size >= finest; size /= 2) {
    const grid = new Grid(size);
    const all = places(size, size === finest ? before : null);
    let squares: Square[] = [];
    let last = performance.now();
    for (const [index, [column, row]] of all.entries()) {
      const square = judge(loaded, settings, column, row, size);
      grid.take(square);
      squares.push(square);
      const done = index + 1 === all.length;
      if (done || performance.now() - last > 100) {
        const part = done ? 1 : (index + 1) / all.length;
        postMessage({ run, squares, size, part, complete: done && size === finest } satisfies MapAnswer);
        [squares, last] = [[], performance.now()];
        await breathe();
        if (run !== wanted) {
          return;
        }
      }
    }
    if (all.length === 0) {
      postMessage({ run, squares, size, part: 1, complete: size === finest } satisfies MapAnswer);
    }
    before = grid;
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
      postMessage({ run: order.run, squares: [], size: 0, part: 0, complete: false, failed } satisfies MapAnswer);
    }
  }
};
