/** The C core as WebAssembly: instances of its models, whose values are read and written where they lie. */

/** What the page knows of a variable: from its interface table, by fmu_src/console/core.py. */
export interface Row {
  readonly reference: number;
  readonly start: number;
  readonly low?: number;
  readonly high?: number;
  /** of parameters: what it is, and its unit */
  readonly text?: string;
  readonly unit?: string;
  /** of a choice: what its values 1, 2, ... stand for */
  readonly items?: readonly string[];
  readonly whole?: boolean;
  /** whether it can be set during a run */
  readonly tunable?: boolean;
  /** the choice by which it counts, and the items with which it does */
  readonly by?: string;
  readonly with?: readonly string[];
}
/** By the names of a model's variables. */
export type Table = Readonly<Record<string, Row>>;
export type Tables = Record<string, Table>;

type Exported = (...values: number[]) => number;

const MOST_REASON = 512; // bytes, DS_MESSAGE_SIZE

export class Core {
  readonly #exports: WebAssembly.Exports;

  private constructor(
    instance: WebAssembly.Instance,
    readonly tables: Tables,
  ) {
    this.#exports = instance.exports;
    this.call("_initialize");
  }

  static async load(bytes: BufferSource, tables: Tables): Promise<Core> {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Core(instance, tables);
  }

  get memory(): ArrayBuffer {
    return (this.#exports["memory"] as WebAssembly.Memory).buffer;
  }

  call(name: string, ...values: number[]): number {
    return this.exported(name)(...values);
  }

  exported(name: string): Exported {
    return this.#exports[name] as Exported;
  }

  model(name: string): Model {
    return new Model(this, name);
  }
}

/** An instance of a model. What its core refuses is thrown with the core's reason. */
export class Model {
  readonly #address: number;
  readonly #table: Table;
  readonly #count: number;
  readonly #step: Exported;
  #values: Float64Array;

  constructor(
    readonly core: Core,
    readonly name: string,
  ) {
    const table = core.tables[name];
    if (!table) {
      throw new Error(`the core has no model ${name}`);
    }
    this.#table = table;
    this.#count = Object.keys(table).length;
    this.#address = core.call(`${name}_allocate`);
    this.#step = core.exported(`${name}_step`);
    this.#values = this.#view();
  }

  row(variable: string): Row {
    const row = this.#table[variable];
    if (!row) {
      throw new Error(`${this.name} has no variable ${variable}`);
    }
    return row;
  }

  reference(variable: string): number {
    return this.row(variable).reference;
  }

  isParameter(variable: string): boolean {
    return this.row(variable).text !== undefined;
  }

  /** Values by value reference, and behind them the derivatives of the inputs: true until the memory grows. */
  get values(): Float64Array {
    if (this.#values.buffer !== this.core.memory) {
      this.#values = this.#view();
    }
    return this.#values;
  }

  get count(): number {
    return this.#count;
  }

  get(variable: string): number {
    return this.values[this.reference(variable)] as number;
  }

  set(variable: string, value: number): void {
    this.values[this.reference(variable)] = value;
  }

  setSlope(variable: string, slope: number): void {
    this.values[this.#count + this.reference(variable)] = slope;
  }

  start(time: number): void {
    this.#require(this.core.call(`${this.name}_start`, this.#address, time));
  }

  step(time: number, end: number): void {
    this.#require(this.#step(this.#address, time, end));
  }

  release(): void {
    this.core.call(`${this.name}_release`, this.#address);
  }

  #view(): Float64Array {
    return new Float64Array(this.core.memory, this.#address, 2 * this.#count);
  }

  #require(result: number): void {
    if (result !== 0) {
      const bytes = new Uint8Array(this.core.memory, this.core.call(`${this.name}_reason`, this.#address), MOST_REASON);
      throw new Error(new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0))) || `${this.name} failed`);
    }
  }
}
