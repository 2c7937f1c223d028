/** The knobs: a slider and a number each, in the units that are chosen. */

import { unit, type Limits, type Settings } from "./settings";
import type { DrillString } from "./theory";

type Place = "omega" | "weight" | "omegaRamp" | "weightRamp" | "speed" | keyof DrillString;

interface Knob {
  readonly name: Place;
  readonly label: string;
  readonly unit: string;
  readonly low: number;
  readonly high: number;
  readonly step: number;
  readonly scale?: "logarithmic";
}

const DRIVE: readonly Knob[] = [
  { name: "omega", label: "Rotary speed", unit: "rad/s", low: 0, high: 25, step: 0.1 },
  { name: "weight", label: "Weight on bit", unit: "N", low: 0, high: 200000, step: 500 },
  { name: "speed", label: "Pace", unit: "x", low: 0.1, high: 100, step: 0.1, scale: "logarithmic" },
];
const STRING: readonly Knob[] = [
  { name: "omegaRamp", label: "Speed ramp (0: at once)", unit: "rad/s2", low: 0, high: 20, step: 0.1 },
  { name: "weightRamp", label: "Weight ramp (0: at once)", unit: "N/s", low: 0, high: 100000, step: 1000 },
  { name: "L", label: "Length L", unit: "m", low: 200, high: 6000, step: 10 },
  { name: "I_B", label: "Inertia at the bit I_B", unit: "kg.m2", low: 5, high: 500, step: 1 },
  { name: "c_a", label: "Top damping c_a", unit: "N.m.s/rad", low: 100, high: 6000, step: 10 },
  { name: "c_b", label: "Bit damping c_b", unit: "N.m.s/rad", low: 0, high: 300, step: 0.01 },
  { name: "mu_cb", label: "Coulomb friction μ_cb", unit: "1", low: 0, high: 1, step: 0.01 },
  { name: "mu_sb", label: "Static friction μ_sb", unit: "1", low: 0, high: 1, step: 0.01 },
];

function value(settings: Settings, name: Place): number {
  return name in settings.string ? settings.string[name as keyof DrillString] : (settings[name as "omega"]);
}

function withValue(settings: Settings, name: Place, next: number): Settings {
  return name in settings.string
    ? { ...settings, string: { ...settings.string, [name]: next } }
    : { ...settings, [name]: next };
}

interface Built {
  readonly knob: Knob;
  readonly slider: HTMLInputElement;
  readonly number: HTMLInputElement;
  readonly symbol: HTMLElement;
}

export class Controls {
  readonly #built: Built[] = [];

  constructor(
    readonly bounds: Limits,
    readonly read: () => Settings,
    readonly change: (settings: Settings) => void,
  ) {
    DRIVE.forEach((knob) => this.#add(knob, "drive"));
    STRING.forEach((knob) => this.#add(knob, "string"));
  }

  /** Show settings that have been changed elsewhere. */
  show(settings: Settings): void {
    for (const { knob, slider, number, symbol } of this.#built) {
      const { symbol: text, factor } = unit(settings.units, knob.unit);
      const now = value(settings, knob.name);
      const shown = Number((now * factor).toPrecision(6));
      symbol.textContent = text;
      slider.value = String(knob.scale === "logarithmic" ? Math.log10(now) : now);
      slider.setAttribute("aria-valuetext", `${shown} ${text}`);
      if (document.activeElement !== number) {
        number.value = String(shown);
      }
    }
  }

  #add(knob: Knob, place: string): void {
    const box = document.createElement("div");
    box.className = "knob";
    box.innerHTML = `<div class="top"><label></label><input type="number" step="any"><span class="unit"></span></div><input type="range">`;
    const [label, number, symbol, slider] = [
      box.querySelector("label"), box.querySelector("[type=number]"), box.querySelector(".unit"), box.querySelector("[type=range]"),
    ] as [HTMLLabelElement, HTMLInputElement, HTMLElement, HTMLInputElement];
    label.textContent = knob.label;
    label.htmlFor = number.id = `number-${knob.name}`;
    slider.id = `slider-${knob.name}`;
    slider.setAttribute("aria-label", knob.label);
    const logarithmic = knob.scale === "logarithmic";
    slider.min = String(logarithmic ? Math.log10(knob.low) : knob.low);
    slider.max = String(logarithmic ? Math.log10(knob.high) : knob.high);
    slider.step = String(logarithmic ? 0.05 : knob.step);
    slider.addEventListener("input", () => {
      const moved = logarithmic ? 10 ** Number(slider.value) : Number(slider.value);
      this.change(withValue(this.read(), knob.name, Number(moved.toPrecision(12))));
    });
    number.addEventListener("change", () => {
      const { factor } = unit(this.read().units, knob.unit);
      const typed = number.value.trim() === "" ? NaN : Number(number.value) / factor;
      const [least, most] = this.bounds[knob.name];
      const kept = Math.min(most, Math.max(least, typed));
      number.blur();
      this.change(Number.isFinite(typed) ? withValue(this.read(), knob.name, kept) : this.read());
    });
    document.getElementById(place)?.append(box);
    this.#built.push({ knob, slider, number, symbol });
  }
}
