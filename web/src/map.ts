/** The severity map: squares as the worker finds them, the linear threshold, and the present point. */

import { AXES, kind, KINDS, type Kind, type Square } from "./orders";
import { unit, type Settings } from "./settings";
import { criticalSlope, threshold } from "./theory";
import { colour } from "./traces";

const [LEFT, RIGHT, TOP, BOTTOM] = [52, 8, 8, 38];

export class SeverityMap {
  readonly #canvas: HTMLCanvasElement;
  #squares: Square[] = [];
  #line: [number, number][] = [];
  #slope = 0;

  constructor(canvas: HTMLCanvasElement) {
    this.#canvas = canvas;
  }

  /** Begin a new map; its line is there at once. */
  begin(settings: Settings): void {
    const slope = criticalSlope(settings.string);
    this.#slope = slope;
    this.#squares = [];
    this.#line = [];
    for (let part = 0; part <= 200; ++part) {
      const weight = AXES.weight[0] + (part / 200) * (AXES.weight[1] - AXES.weight[0]);
      const omega = threshold(settings.string, weight, slope);
      if (omega !== null) {
        this.#line.push([omega, weight]);
      }
    }
  }

  /** The linear threshold at the settings' weight [rad/s]; null if there is none. */
  threshold(settings: Settings): number | null {
    return threshold(settings.string, settings.weight, this.#slope);
  }

  take(squares: readonly Square[]): void {
    this.#squares.push(...squares);
  }

  get squares(): readonly Square[] {
    return this.#squares;
  }

  /** What lies at a place of the canvas: drive speed and weight, null outside the axes. */
  at(x: number, y: number): { readonly omega: number; readonly weight: number } | null {
    const [width, height] = this.#inner();
    const [across, up] = [(x - LEFT) / width, 1 - (y - TOP) / height];
    if (across < 0 || across > 1 || up < 0 || up > 1) {
      return null;
    }
    const value = ([low, high]: readonly [number, number], part: number): number => low + part * (high - low);
    return { omega: value(AXES.omega, across), weight: value(AXES.weight, up) };
  }

  draw(settings: Settings, omega: number, weight: number): void {
    const canvas = this.#canvas;
    const context = canvas.getContext("2d");
    const ratio = window.devicePixelRatio || 1;
    if (!context || canvas.clientWidth === 0) {
      return;
    }
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const [width, height] = this.#inner();
    this.#fill(context, width, height);
    this.#axes(context, width, height, settings);
    context.save();
    context.beginPath();
    context.rect(LEFT, TOP, width, height);
    context.clip();
    const style = getComputedStyle(document.documentElement);
    context.strokeStyle = colour(style, "--ink");
    context.lineWidth = 2.5;
    context.beginPath();
    this.#line.forEach(([one, two]) => context.lineTo(...this.#place(one, two)));
    context.stroke();
    const [x, y] = this.#place(omega, weight);
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.fillStyle = colour(style, "--accent");
    context.fill();
    context.strokeStyle = colour(style, "--ground");
    context.stroke();
    context.restore();
  }

  #inner(): readonly [number, number] {
    return [this.#canvas.clientWidth - LEFT - RIGHT, this.#canvas.clientHeight - TOP - BOTTOM];
  }

  #place(omega: number, weight: number): [number, number] {
    const [width, height] = this.#inner();
    const part = ([low, high]: readonly [number, number], value: number): number => (value - low) / (high - low);
    return [LEFT + width * part(AXES.omega, omega), TOP + height * (1 - part(AXES.weight, weight))];
  }

  #fill(context: CanvasRenderingContext2D, width: number, height: number): void {
    const style = getComputedStyle(document.documentElement);
    const colours = Object.fromEntries(KINDS.map((name) => [name, colour(style, `--map-${name}`)])) as Record<Kind, string>;
    const panel = colour(style, "--panel");
    const [column, row] = [width / AXES.cells, height / AXES.cells];
    for (const square of this.#squares) {
      const what = kind(square);
      const severity = Math.min(1, 0.45 + 0.22 * square.rest);
      // edges on whole pixels: else the squares show seams
      const [x, right] = [square.column, square.column + square.size].map((at) => Math.round(LEFT + at * column)) as [number, number];
      const [bottom, y] = [square.row, square.row + square.size].map((at) => Math.round(TOP + height - at * row)) as [number, number];
      const [w, h] = [right - x, bottom - y];
      context.fillStyle = panel;
      context.fillRect(x, y, w, h);
      context.globalAlpha = what === "sticks" ? severity : 1;
      context.fillStyle = colours[what];
      context.fillRect(x, y, w, h);
      context.globalAlpha = 1;
    }
  }

  #axes(context: CanvasRenderingContext2D, width: number, height: number, settings: Settings): void {
    const style = getComputedStyle(document.documentElement);
    const [speed, load] = [unit(settings.units, "rad/s"), unit(settings.units, "N")];
    context.strokeStyle = colour(style, "--soft");
    context.lineWidth = 1;
    context.strokeRect(LEFT, TOP, width, height);
    context.fillStyle = colour(style, "--ink");
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "center";
    for (const value of ticks(AXES.omega, speed.factor)) {
      context.fillText(String(value), this.#place(value / speed.factor, AXES.weight[0])[0], TOP + height + 15);
    }
    context.fillText(`drive speed [${speed.symbol}]`, LEFT + width / 2, TOP + height + 32);
    context.textAlign = "right";
    for (const value of ticks(AXES.weight, load.factor)) {
      context.fillText(String(value), LEFT - 5, this.#place(AXES.omega[0], value / load.factor)[1] + 4);
    }
    context.save();
    context.translate(12, TOP + height / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText(`weight on bit [${load.symbol}]`, 0, 0);
    context.restore();
  }
}

/** Round numbers along an axis, as they are shown. */
function ticks([low, high]: readonly [number, number], factor: number): number[] {
  const rough = ((high - low) * factor) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const pace = ([1, 2, 5, 10].find((each) => each * power >= rough) ?? 10) * power;
  const out: number[] = [];
  for (let value = Math.ceil((low * factor) / pace) * pace; value <= high * factor; value += pace) {
    out.push(Number(value.toPrecision(6)));
  }
  return out;
}
