/** Parameters of the law, the drive and the driller: a number or a choice each, as their interface tables have them. */

import type { Tables } from "./core";
import { DRILLER, DRIVE, LAWS, TITLES, type Gain } from "./laws";
import { gainWithin, unit, type Settings } from "./settings";
import { counts, gains, gainValue, hasDrive, hasDriller, models, offered, standard } from "./system";

interface Line {
  readonly gain: Gain;
  readonly box: HTMLElement;
  readonly input: HTMLInputElement | HTMLSelectElement;
  readonly unit: string;
  readonly symbol: HTMLElement;
}

export class Gains {
  #lines: readonly Line[] = [];
  #built = "";

  constructor(
    readonly tables: Tables,
    readonly read: () => Settings,
    readonly change: (settings: Settings) => void,
  ) {}

  show(settings: Settings): void {
    const built = JSON.stringify([settings.law, models(settings)]);
    if (built !== this.#built) {
      this.#built = built;
      this.#build(settings);
    }
    for (const { gain, box, input, unit: name, symbol } of this.#lines) {
      box.hidden = !counts(settings, this.tables, gain);
      const { symbol: text, factor } = unit(settings.units, name);
      symbol.textContent = text;
      const value = gainValue(settings, this.tables, gain);
      input.title = input instanceof HTMLInputElement ? this.#range(gain, text, factor) : "";
      if (document.activeElement !== input || input instanceof HTMLSelectElement) {
        input.value = String(Number((value * factor).toPrecision(6)));
      }
    }
  }

  #build(settings: Settings): void {
    const places: readonly (readonly [string, readonly string[]])[] = [
      ["law-gains", [...new Set(Object.values(LAWS[settings.law].parts))]],
      ["drive-gains", hasDrive(settings) ? [DRIVE] : []],
      ["driller-gains", hasDriller(settings) ? [DRILLER] : []],
    ];
    const lines: Line[] = [];
    for (const [id, inside] of places) {
      const groups = inside.map((model) => {
        const group = document.createElement("div");
        group.setAttribute("role", "group");
        group.setAttribute("aria-label", TITLES[model] ?? model);
        const title = document.createElement("p");
        title.className = "title";
        title.textContent = TITLES[model] ?? model;
        const own = gains(settings, this.tables, model).map((name) => this.#line(settings, model, name));
        lines.push(...own);
        group.append(...(inside.length > 1 ? [title] : []), ...own.map(({ box }) => box));
        return group;
      });
      document.getElementById(id)?.replaceChildren(...groups);
    }
    this.#lines = lines;
  }

  #line(settings: Settings, model: string, name: string): Line {
    const gain: Gain = `${model}.${name}`;
    const row = this.tables[model]?.[name];
    const box = document.createElement("div");
    box.className = "gain";
    box.innerHTML = `<label><span></span> <i></i></label><span class="unit"></span>`;
    const [label, text, id, symbol] = ["label", "span", "i", ".unit"].map((each) => box.querySelector(each)) as [
      HTMLLabelElement, HTMLElement, HTMLElement, HTMLElement];
    text.textContent = row?.text ?? name;
    id.textContent = name;
    const input = document.createElement(row?.items ? "select" : "input");
    label.htmlFor = input.id = `gain-${model}-${name}`;
    symbol.before(input);
    if (input instanceof HTMLSelectElement) {
      box.classList.add("choice");
      offered(settings, this.tables, gain).forEach((value) => {
        input.add(new Option((row?.items?.[value - 1] ?? "").replaceAll("_", " "), String(value)));
      });
    } else {
      [input.type, input.step] = ["number", "any"];
    }
    input.addEventListener("change", () => this.#set(gain, input, row?.unit ?? ""));
    return { gain, box, input, unit: row?.unit ?? "", symbol };
  }

  #set(gain: Gain, input: HTMLInputElement | HTMLSelectElement, name: string): void {
    const settings = this.read();
    const typed = input.value.trim() === "" ? NaN : Number(input.value) / unit(settings.units, name).factor;
    const kept = gainWithin(settings, this.tables, gain, typed);
    if (input instanceof HTMLInputElement) {
      input.blur(); // so that what is kept is shown
    }
    if (kept === null) {
      this.show(settings);
      return;
    }
    const { [gain]: _, ...others } = settings.gains;
    const isStandard = kept === standard(settings, this.tables, gain);
    this.change({ ...settings, gains: isStandard ? others : { ...others, [gain]: kept } });
  }

  #range(gain: Gain, symbol: string, factor: number): string {
    const [model = "", name = ""] = gain.split(".");
    const { low, high } = this.tables[model]?.[name] ?? {};
    const shown = (value: number): string => String(Number((value * factor).toPrecision(4)));
    return low === undefined || high === undefined ? "" : `${shown(low)} to ${shown(high)} ${symbol}`.trim();
  }
}
