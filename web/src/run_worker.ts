/** The worker of the run: goes on when asked to, and hands back rows of outputs and the torque along the string. */

import { Core } from "./core";
import { COLUMNS, type Answer, type Order } from "./orders";
import { replay } from "./replay";
import { Rig } from "./rig";
import type { Settings } from "./settings";
import { shown } from "./shown";
import type { Model } from "./core";
import { Waves } from "./waves";

let core: Core | null = null;
let rig: Rig | null = null;
let waves: Waves | null = null;
let run = 0;
let columns: (readonly [Model, number])[] = [];

/** Where the numbers of a row lie, but for the time. */
function places(now: Rig): (readonly [Model, number])[] {
  const ports = [...COLUMNS.filter((name) => name !== "time").map((name) => `plant.${name}`), ...shown(now.settings).map(({ port }) => port)];
  return ports.map((port) => {
    const [name = "", variable = ""] = port.split(".");
    const model = now.part(name);
    return [model, model.reference(variable)];
  });
}

function row(now: Rig): number[] {
  return [now.time, ...columns.map(([model, reference]) => model.values[reference] as number)];
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
    columns = places(rig);
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
      rig?.tune(order.settings);
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
