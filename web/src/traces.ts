/** The traces: speeds, torques and energy over the last seconds. */

import uPlot from "uplot";
import type { History } from "./history";
import { unit, type Settings } from "./settings";
import { shown } from "./shown";

interface Line {
  readonly name: string;
  readonly label: string;
  readonly colour: string;
  readonly dash?: number[];
}

interface Trace {
  readonly id: string;
  readonly unit: string;
  readonly title: string;
  readonly lines: readonly Line[];
}

const TRACES: readonly Trace[] = [
  {
    id: "trace-speed", unit: "rad/s", title: "Speed",
    lines: [
      { name: "bit_speed", label: "bit", colour: "--bad" },
      { name: "top_speed", label: "top", colour: "--accent" },
      { name: "Omega", label: "drive", colour: "--soft", dash: [4, 4] },
    ],
  },
  {
    id: "trace-torque", unit: "N.m", title: "Torque",
    lines: [
      { name: "bit_torque", label: "on bit", colour: "--bad" },
      { name: "top_torque", label: "at the top", colour: "--accent" },
    ],
  },
  { id: "trace-energy", unit: "J", title: "Energy", lines: [{ name: "energy", label: "in string and bit", colour: "--good" }] },
];
const MOST_POINTS = 1500;

export class Traces {
  #plots: uPlot[] = [];
  #traces: readonly Trace[] = TRACES;

  /** Draw them anew, for other lines, units or colours. */
  build(settings: Settings): void {
    this.#plots.forEach((plot) => plot.destroy());
    const style = getComputedStyle(document.documentElement);
    const more = shown(settings);
    this.#traces = TRACES.map((trace) => {
      const own = more.filter((each) => `trace-${each.trace}` === trace.id);
      const lines = own.map(({ port, line = port }): Line => ({ name: port, label: line, colour: "--good", dash: [2, 3] }));
      return { ...trace, lines: [...trace.lines, ...lines] };
    });
    this.#plots = this.#traces.map((trace) => {
      const place = document.getElementById(trace.id) as HTMLElement;
      const { symbol, factor } = unit(settings.units, trace.unit);
      const probe = (name: string): string => colour(style, name);
      const axis = { stroke: probe("--ink"), grid: { stroke: probe("--edge"), width: 0.5 }, ticks: { stroke: probe("--edge") } };
      place.setAttribute("role", "img");
      place.setAttribute("aria-label", `${trace.title} in ${symbol} over time in s`);
      return new uPlot(
        {
          width: Math.max(place.clientWidth, 120), height: height(place), pxAlign: 0,
          title: "", cursor: { show: false }, legend: { live: false, isolate: false },
          scales: { x: { time: false }, y: { range: (_plot, low, high) => [Math.min(0, 1.05 * low), Math.max(1, 1.05 * high)] } },
          axes: [{ ...axis, size: 32, ...(height(place) < 150 ? {} : { label: "time [s]", labelSize: 18 }) }, { ...axis, label: height(place) < 150 ? symbol : `${trace.title} [${symbol}]`, labelSize: 18, size: 48, space: 26 }],
          series: [
            { label: "time" },
            ...trace.lines.map((line) => ({
              label: line.label, stroke: probe(line.colour), width: 1.5, points: { show: false },
              ...(line.dash ? { dash: line.dash } : {}),
              value: (_: uPlot, value: number | null): string => (value === null ? "" : (value * factor).toPrecision(4)),
            })),
          ],
        },
        [[], ...trace.lines.map(() => [])],
        place,
      );
    });
  }

  resize(): void {
    this.#plots.forEach((plot, index) => {
      const place = document.getElementById(TRACES[index]?.id ?? "");
      if (place && (Math.abs(place.clientWidth - plot.width) > 1 || height(place) !== plot.height)) {
        plot.setSize({ width: Math.max(place.clientWidth, 120), height: height(place) });
      }
    });
  }

  show(history: History, span: number, { units }: Settings): void {
    const first = history.since(span);
    const every = Math.max(1, Math.ceil((history.length - first) / MOST_POINTS));
    const begin = first + ((every - (first % every)) % every); // always the same rows, or the lines would flicker
    const picked = (values: readonly number[], factor: number): number[] => {
      const out: number[] = [];
      for (let row = begin; row < values.length; row += every) {
        out.push((values[row] as number) * factor);
      }
      return out;
    };
    const time = picked(history.column("time"), 1);
    const end = history.last("time");
    this.#plots.forEach((plot, index) => {
      const trace = this.#traces[index] as Trace;
      const { factor } = unit(units, trace.unit);
      plot.batch(() => {
        plot.setData([time, ...trace.lines.map((line) => picked(history.column(line.name), factor))], true);
        plot.setScale("x", { min: Math.max(0, end - span), max: Math.max(span, end) });
      });
    });
  }
}

/** px, of a trace, as the style sheet has it */
function height(place: HTMLElement): number {
  return Number.parseInt(getComputedStyle(place).getPropertyValue("--height"), 10) || 190;
}

/** A colour of the style sheet as it is in light or dark. */
export function colour(style: CSSStyleDeclaration, name: string): string {
  const value = style.getPropertyValue(name).trim();
  const parts = /^light-dark\((#\w+),\s*(#\w+)\)$/.exec(value);
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  return parts ? ((dark ? parts[2] : parts[1]) as string) : value;
}
