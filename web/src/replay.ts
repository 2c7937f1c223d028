/** A run of the plant by a program, and all its outputs: what is compared, to the bit, with the native FMU. */

import type { Core } from "./core";

/** From a step on, inputs have values and change by slopes. */
export interface Change {
  readonly step: number;
  readonly values: Readonly<Record<string, number>>;
  readonly slopes: Readonly<Record<string, number>>;
}

export interface Program {
  readonly parameters: Readonly<Record<string, number>>;
  readonly step_size: number;
  readonly steps: number;
  readonly changes: readonly Change[];
  readonly outputs: readonly string[];
}

/** Return the outputs at the start and after every step, row by row. */
export function replay(core: Core, program: Program): Float64Array {
  const plant = core.model("DrillstringNeutral");
  const references = program.outputs.map((name) => plant.reference(name));
  const rows = new Float64Array((program.steps + 1) * references.length);
  let place = 0;
  const record = (): void => {
    for (const reference of references) {
      rows[place++] = plant.values[reference] as number;
    }
  };
  const apply = (step: number): void => {
    for (const change of program.changes.filter((each) => each.step === step)) {
      Object.entries(change.values).forEach(([name, value]) => plant.set(name, value));
      Object.entries(change.slopes).forEach(([name, slope]) => plant.setSlope(name, slope));
    }
  };
  Object.entries(program.parameters).forEach(([name, value]) => plant.set(name, value));
  apply(-1); // what holds at the start
  plant.start(0);
  record();
  for (let step = 0, time = 0; step < program.steps; ++step) {
    const end = step * program.step_size + program.step_size;
    apply(step);
    plant.step(time, end);
    record();
    time = end;
  }
  plant.release();
  return rows;
}
