/** The page: settings go to the workers, what they answer is shown. */

import { Controls } from "./controls";
import { draw } from "./drawing";
import { History, motion, type Motion } from "./history";
import { SeverityMap } from "./map";
import { AXES, type Answer, type MapAnswer, type MapOrder, type Order } from "./orders";
import type { Program } from "./replay";
import { changed, defaults, fromAddress, LAWS, limits, PRESETS, toAddress, unit, type From, type Settings } from "./settings";
import { Traces } from "./traces";

const VERDICTS: Record<Motion["state"], string> = {
  starting: "Starting",
  steady: "Steady rotation",
  vibrating: "Swinging, not sticking",
  sticking: "Sticking and slipping",
  stuck: "Stuck",
};
const LONGEST_FRAME = 0.1; // s, of a frame that counts: a page in the background does not catch up
const MAP_WAIT = 400; // ms without a change before the map is made anew

function element<Type extends HTMLElement>(id: string): Type {
  return document.getElementById(id) as Type;
}

function worker(source: string): Worker {
  return new Worker(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
}

function coreBytes(): ArrayBuffer {
  return Uint8Array.from(atob(CORE_BASE64), (char) => char.charCodeAt(0)).buffer;
}

class Page {
  readonly #standard = defaults(TABLES);
  readonly #limits = limits(TABLES);
  readonly #history = new History();
  readonly #traces = new Traces();
  readonly #map = new SeverityMap(element<HTMLCanvasElement>("map"));
  readonly #runner = worker(RUN_WORKER);
  readonly #mapper = worker(MAP_WORKER);
  readonly #controls: Controls;
  #settings: Settings;
  #run = 0;
  #mapRun = 0;
  #waiting = true;
  #fresh = false;
  /** ms since the page began to load, when its first picture of the run was drawn */
  pictured = Infinity;
  #paused = false;
  #target = 0;
  #torque: Float64Array = new Float64Array(2);
  #most = 1;
  #lastFrame = 0;
  #nextNumbers = 0;
  #mapChanged = true;
  #nextMap = 0;
  #mapTimer = 0;
  #addressTimer = 0;
  #state: Motion["state"] | "" = "";
  #nextWord = 0;
  #replayed: ((rows: Float64Array) => void) | null = null;

  constructor() {
    this.#settings = fromAddress(location.hash, this.#standard, this.#limits);
    this.#controls = new Controls(this.#limits, () => this.#settings, (settings) => this.change(settings));
    this.#runner.onmessage = (event: MessageEvent<Answer>) => this.#take(event.data);
    this.#mapper.onmessage = (event: MessageEvent<MapAnswer>) => this.#takeSquares(event.data);
    const load = { kind: "load", bytes: coreBytes(), tables: TABLES } as const;
    this.#order(load);
    this.#orderMap(load);
    this.#listen();
    this.#traces.build(this.#settings.units);
    this.#show();
    this.start(this.#settings.from);
    this.#renewMap();
    requestAnimationFrame((now) => this.#frame(now));
  }

  get settings(): Settings {
    return this.#settings;
  }

  get time(): number {
    return this.#history.last("time");
  }

  get motion(): Motion {
    return motion(this.#history);
  }

  get map(): SeverityMap {
    return this.#map;
  }

  start(from: From): void {
    this.#settings = { ...this.#settings, from };
    this.#run += 1;
    this.#target = 0;
    this.#waiting = true;
    this.#history.clear();
    this.#most = 1;
    this.#state = "";
    element("trouble").hidden = true;
    this.#order({ kind: "start", settings: this.#settings, run: this.#run });
    this.#keepAddress();
  }

  change(settings: Settings): void {
    const old = this.#settings;
    this.#settings = settings;
    const other = old.law !== settings.law || JSON.stringify(old.string) !== JSON.stringify(settings.string);
    if (other || old.from !== settings.from) {
      this.start(settings.from);
    } else {
      this.#order({ kind: "set", settings });
    }
    if (old.units !== settings.units) {
      this.#traces.build(settings.units);
      this.#fresh = true;
    }
    if (other) {
      clearTimeout(this.#mapTimer);
      this.#mapTimer = setTimeout(() => this.#renewMap(), MAP_WAIT);
    }
    this.#showThreshold();
    this.#show();
    this.#keepAddress();
  }

  /** Take up a preset: a run of its own, from its start. */
  take(settings: Settings): void {
    this.change(settings);
    this.start(settings.from);
  }

  pause(paused: boolean): void {
    this.#paused = paused;
    element("pause").textContent = paused ? "Go on" : "Pause";
  }

  replay(program: Program): Promise<Float64Array> {
    return new Promise((resolve) => {
      this.#replayed = resolve;
      this.#order({ kind: "replay", program });
    });
  }

  #order(order: Order): void {
    this.#runner.postMessage(order);
  }

  #orderMap(order: MapOrder): void {
    this.#mapper.postMessage(order);
  }

  #take(answer: Answer): void {
    if (answer.kind === "failed") {
      element("trouble").hidden = false;
      element("trouble").textContent = `The core refuses: ${answer.reason}`;
    } else if (answer.kind === "replayed") {
      this.#replayed?.(answer.rows);
    } else if (answer.run === this.#run) {
      this.#history.take(answer.rows);
      this.#torque = answer.torque;
      this.#waiting = false;
      this.#fresh = true;
    }
  }

  #takeSquares(answer: MapAnswer): void {
    if (answer.run === this.#mapRun) {
      this.#map.take(answer.squares);
      this.#mapChanged = true;
      element("progress").textContent =
        answer.failed !== undefined ? `There is no map: ${answer.failed}` :
        answer.complete ? "The map is complete." :
        `Computing the map, ${AXES.cells / answer.size} × ${AXES.cells / answer.size}: ${Math.round(100 * answer.part)} %`;
    }
  }

  #renewMap(): void {
    this.#mapRun += 1;
    this.#map.begin(this.#settings);
    this.#showThreshold();
    this.#orderMap({ kind: "map", settings: this.#settings, run: this.#mapRun });
  }

  #showThreshold(): void {
    const omega = this.#map.threshold(this.#settings);
    const { symbol, factor } = unit(this.#settings.units, "rad/s");
    const what = this.#settings.law === "none" ? "linear threshold" : "linear threshold without the law";
    element("threshold").textContent =
      omega === null ? `${what}: none at this weight` : `${what}: ${(omega * factor).toFixed(3)} ${symbol} at this weight`;
    this.#mapChanged = true;
  }

  #frame(now: number): void {
    const elapsed = Math.min((now - this.#lastFrame) / 1000, LONGEST_FRAME);
    this.#lastFrame = now;
    if (this.#fresh) {
      this.#fresh = false;
      this.#picture();
      this.pictured = Math.min(this.pictured, performance.now());
    }
    if (now >= this.#nextNumbers) {
      this.#nextNumbers = now + 100;
      this.#numbers(now);
    }
    if (this.#mapChanged && now >= this.#nextMap) {
      this.#mapChanged = false;
      this.#nextMap = now + 250;
      this.#drawMap();
    }
    if (!this.#waiting && !this.#paused) {
      this.#target = Math.max(this.#target + elapsed * this.#settings.speed, this.time);
      this.#waiting = true;
      this.#order({ kind: "advance", time: this.#target, run: this.#run });
    }
    requestAnimationFrame((next) => this.#frame(next));
  }

  #picture(): void {
    const { units } = this.#settings;
    this.#traces.show(this.#history, Number(element<HTMLSelectElement>("span").value), units);
    for (const value of this.#torque) {
      this.#most = Math.max(this.#most, 1.05 * Math.abs(value));
    }
    draw(element<HTMLCanvasElement>("drawing"), this.#torque, this.#most, {
      top: this.#history.last("top_angle"),
      bit: this.#history.last("bit_angle"),
      stuck: this.#history.last("bit_stuck") > 0,
    });
  }

  #drawMap(): void {
    const free = this.#settings.law === "none" && this.#history.length > 0;
    const omega = free ? this.#history.last("Omega") : this.#settings.omega;
    const weight = free ? this.#history.last("WOB") : this.#settings.weight;
    this.#map.draw(this.#settings, omega, weight);
  }

  #numbers(now: number): void {
    const { ssi, state } = this.motion;
    const { units } = this.#settings;
    const word = Number.isFinite(ssi) ? ssi.toFixed(2) : "–";
    const shown = (name: "bit_speed" | "top_speed" | "bit_torque" | "top_torque" | "energy", of: string): string => {
      const { symbol, factor } = unit(units, of);
      return `${(this.#history.last(name) * factor).toFixed(2)} ${symbol}`;
    };
    const verdict = element("verdict");
    verdict.dataset["state"] = state === "stuck" ? "sticking" : state;
    verdict.textContent = `${VERDICTS[state]}${this.#paused ? ", paused" : ""}`;
    const all: [string, string][] = [
      ["Time", `${this.time.toFixed(1)} s`], ["SSI", word], ["Bit speed", shown("bit_speed", "rad/s")],
      ["Top speed", shown("top_speed", "rad/s")], ["Torque on bit", shown("bit_torque", "N.m")],
      ["Torque at the top", shown("top_torque", "N.m")], ["Energy", shown("energy", "J")],
    ];
    const list = element("numbers");
    if (list.children.length !== all.length) {
      list.innerHTML = all.map(() => "<div><dt></dt><dd></dd></div>").join("");
    }
    all.forEach(([name, value], index) => {
      const [term, text] = list.children[index]?.children ?? [];
      (term as HTMLElement).textContent = name;
      (text as HTMLElement).textContent = value;
    });
    if (state !== this.#state && now >= this.#nextWord && state !== "starting") {
      this.#state = state;
      this.#nextWord = now + 2000; // a reader that is told more hears nothing
      element("live").textContent = `${VERDICTS[state]}, SSI ${word}`;
    }
    if (this.#settings.law === "none" && !this.#paused) {
      const moving = this.#history.length > 1 && this.#history.last("Omega") !== this.#settings.omega;
      this.#mapChanged ||= moving || this.#history.last("WOB") !== this.#settings.weight;
    }
  }

  #show(): void {
    const settings = this.#settings;
    this.#controls.show(settings);
    element<HTMLSelectElement>("law").value = settings.law;
    element<HTMLSelectElement>("units").value = settings.units;
    const { symbol, factor } = unit(settings.units, "m");
    element("length").textContent = `${(settings.string.L * factor).toFixed(0)} ${symbol}`;
  }

  #keepAddress(): void {
    clearTimeout(this.#addressTimer);
    this.#addressTimer = setTimeout(() => {
      const address = toAddress(this.#settings, this.#standard);
      if (location.hash.replace(/^#/, "") !== address) {
        history.replaceState(null, "", `#${address}`);
      }
    }, 250);
  }

  #listen(): void {
    this.#fillLists();
    element("pause").addEventListener("click", () => this.pause(!this.#paused));
    element("from-rest").addEventListener("click", () => this.start("rest"));
    element("from-steady").addEventListener("click", () => this.start("steady"));
    element("defaults").addEventListener("click", () => this.take(this.#standard));
    element("export").addEventListener("click", () => this.#save());
    element("share").addEventListener("click", () => void this.#share());
    element("units").addEventListener("change", () => {
      const units = element<HTMLSelectElement>("units").value as Settings["units"];
      this.change({ ...this.#settings, units });
    });
    element("span").addEventListener("change", () => (this.#fresh = true));
    window.addEventListener("resize", () => {
      this.#traces.resize();
      [this.#fresh, this.#mapChanged] = [true, true];
    });
    window.addEventListener("hashchange", () => this.take(fromAddress(location.hash, this.#standard, this.#limits)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#traces.build(this.#settings.units);
      [this.#fresh, this.#mapChanged] = [true, true];
    });
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#listenToMap();
  }

  #fillLists(): void {
    const law = element<HTMLSelectElement>("law");
    Object.entries(LAWS).forEach(([name, text]) => law.add(new Option(text, name)));
    law.addEventListener("change", () => this.change({ ...this.#settings, law: law.value as Settings["law"] }));
    const preset = element<HTMLSelectElement>("preset");
    preset.add(new Option("choose one", ""));
    PRESETS.forEach(({ name }, index) => preset.add(new Option(name, String(index))));
    preset.addEventListener("change", () => {
      const chosen = preset.value === "" ? undefined : PRESETS[Number(preset.value)];
      if (chosen) {
        const { units, speed } = this.#settings;
        this.take(changed({ ...this.#standard, units, speed }, chosen.changes));
      }
    });
  }

  #listenToMap(): void {
    const canvas = element("map");
    canvas.addEventListener("click", (event) => {
      const found = this.#map.at(event.offsetX, event.offsetY);
      if (found) {
        const round = (value: number, to: number): number => Number((Math.round(value / to) * to).toPrecision(9));
        this.change({ ...this.#settings, omega: round(found.omega, 0.05), weight: round(found.weight, 250) });
      }
    });
    const moves: Record<string, readonly [number, number]> = {
      ArrowLeft: [-0.25, 0], ArrowRight: [0.25, 0], ArrowUp: [0, 2500], ArrowDown: [0, -2500],
    };
    canvas.addEventListener("keydown", (event) => {
      const move = moves[event.key];
      if (move) {
        event.preventDefault();
        const { omega, weight } = this.#settings;
        this.change({ ...this.#settings, omega: Math.max(0, omega + move[0]), weight: Math.max(0, weight + move[1]) });
      }
    });
  }

  #key(event: KeyboardEvent): void {
    const busy = event.target instanceof Element && event.target.closest("button, input, select, summary") !== null;
    if (busy || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    if (event.key === " ") {
      event.preventDefault();
      this.pause(!this.#paused);
    } else if (["r", "s"].includes(event.key.toLowerCase())) {
      this.start(event.key.toLowerCase() === "r" ? "rest" : "steady");
    }
  }

  #save(): void {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([this.#history.csv()], { type: "text/csv" }));
    link.download = "drillstring.csv";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async #share(): Promise<void> {
    history.replaceState(null, "", `#${toAddress(this.#settings, this.#standard)}`);
    const button = element("share");
    try {
      await navigator.clipboard.writeText(location.href);
      button.textContent = "Copied";
    } catch {
      button.textContent = "See the address bar";
    }
    setTimeout(() => (button.textContent = "Copy link"), 2000);
  }
}

declare global {
  interface Window {
    drillstring: Page;
  }
}
window.drillstring = new Page();
