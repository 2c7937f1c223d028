/** The page: settings go to the workers, what they answer is shown. */

import { begun, hasNoMap, mapKey, mapped } from "./begin";
import { Controls } from "./controls";
import { draw } from "./drawing";
import { History, motion, type Motion } from "./history";
import { SeverityMap } from "./map";
import { AXES, type Answer, type MapAnswer, type MapOrder, type Order } from "./orders";
import type { Program } from "./replay";
import { Gains } from "./gains";
import { LAWS } from "./laws";
import { fillLists } from "./lists";
import { severityWord, showNumbers, VERDICTS } from "./numbers";
import { shown } from "./shown";
import { hasDrive, hasDriller, models } from "./system";
import { defaults, fromAddress, limits, toAddress, unit, type From, type Settings } from "./settings";
import { Traces } from "./traces";

const LONGEST_FRAME = 0.1; // s, of a frame that counts: a page in the background does not catch up
const MAP_WAIT = 400; // ms without a change before the map is made anew

/** Inside another page: `console.html?embed`. */
const EMBEDDED = new URLSearchParams(location.search).has("embed");
document.documentElement.classList.toggle("embed", EMBEDDED);

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
  readonly #gains: Gains;
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
    this.#settings = fromAddress(location.hash, this.#standard, this.#limits, TABLES);
    this.#controls = new Controls(this.#limits, () => this.#settings, (settings) => this.change(settings));
    this.#gains = new Gains(TABLES, () => this.#settings, (settings) => this.change(settings));
    this.#runner.onmessage = (event: MessageEvent<Answer>) => this.#take(event.data);
    this.#mapper.onmessage = (event: MessageEvent<MapAnswer>) => this.#takeSquares(event.data);
    const load = { kind: "load", bytes: coreBytes(), tables: TABLES } as const;
    this.#order(load);
    this.#orderMap(load);
    this.#listen();
    this.#traces.build(this.#settings);
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
    this.#history.begin(shown(this.#settings).map(({ port }) => port));
    this.#most = 1;
    this.#state = "";
    element("trouble").hidden = true;
    this.#order({ kind: "start", settings: this.#settings, run: this.#run });
    this.#keepAddress();
  }

  change(settings: Settings): void {
    const old = this.#settings;
    this.#settings = settings;
    const other = begun(old) !== begun(settings);
    element<HTMLSelectElement>("preset").value = "";
    if (other || old.from !== settings.from || !element("trouble").hidden) {
      this.start(settings.from);
    } else {
      this.#order({ kind: "set", settings });
    }
    if (other || old.units !== settings.units) {
      this.#traces.build(settings);
      this.#fresh = true;
    }
    if (mapKey(mapped(old)) !== mapKey(mapped(settings))) {
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
    element("pause").textContent = paused ? "Resume" : "Pause";
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
      element("trouble").textContent = `This cannot be run: ${answer.reason}`;
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
        answer.complete ? `The map is complete${this.#mapNote()}.` :
        `Computing the map, ${AXES.cells / answer.size} × ${AXES.cells / answer.size}: ${Math.round(100 * answer.part)} %`;
    }
  }

  #renewMap(): void {
    this.#mapRun += 1;
    this.#map.begin(this.#settings);
    this.#showThreshold();
    this.#orderMap({ kind: "map", settings: mapped(this.#settings), run: this.#mapRun });
  }

  #mapNote(): string {
    const settings = this.#settings;
    return hasNoMap(settings) ? ", without the law" : LAWS[settings.law].set?.["law.enabled"] ? ", with the law switched on" : "";
  }

  #showThreshold(): void {
    const omega = this.#map.threshold(this.#settings);
    const { symbol, factor } = unit(this.#settings.units, "rad/s");
    const what = models(this.#settings).length === 0 ? "linear threshold" : "linear threshold of the string alone";
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
    this.#traces.show(this.#history, Number(element<HTMLSelectElement>("span").value), this.#settings);
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
    const settings = this.#settings;
    const { gives } = LAWS[settings.law];
    const begun = this.#history.length > 0;
    const turned = begun && (gives === undefined || gives.endsWith(".WOB") || gives.endsWith(".speed_ref"));
    const omega = turned ? this.#history.last("Omega") : settings.omega;
    const weight = begun && gives?.endsWith(".WOB") !== true ? this.#history.last("WOB") : settings.weight;
    this.#map.draw(settings, omega, weight);
  }

  #numbers(now: number): void {
    const moving = this.motion;
    const { ssi, state } = moving;
    const verdict = element("verdict");
    verdict.dataset["state"] = state === "stuck" ? "sticking" : state;
    verdict.textContent = element("trouble").hidden ? `${VERDICTS[state]}${this.#paused ? ", paused" : ""}` : "Not running";
    showNumbers(element("numbers"), this.#history, moving, this.#settings);
    if (state !== this.#state && now >= this.#nextWord && state !== "starting") {
      this.#state = state;
      this.#nextWord = now + 2000; // a reader that is told more hears nothing
      element("live").textContent = `${VERDICTS[state]}, SSI ${severityWord(ssi)}`;
    }
    const [omega, weight] = [this.#history.last("Omega"), this.#history.last("WOB")];
    this.#mapChanged ||= !this.#paused && (omega !== this.#settings.omega || weight !== this.#settings.weight);
  }

  #show(): void {
    const settings = this.#settings;
    this.#controls.show(settings);
    this.#gains.show(settings);
    for (const name of ["law", "units", "drive-kind", "feed"] as const) {
      element<HTMLSelectElement>(name).value = settings[name === "drive-kind" ? "drive" : name];
    }
    const drive = element<HTMLSelectElement>("drive-kind");
    drive.disabled = LAWS[settings.law].needsDrive === true;
    drive.value = hasDrive(settings) ? "top_drive" : "ideal";
    const feed = element<HTMLSelectElement>("feed");
    feed.disabled = LAWS[settings.law].gives === "law.WOB";
    feed.value = hasDriller(settings) ? "autodriller" : "direct";
    element("gains").hidden = settings.law === "none";
    element("switch").hidden = !Object.values(LAWS[settings.law].set ?? {}).includes("enabled");
    element<HTMLInputElement>("enabled").checked = settings.enabled;
    const { symbol, factor } = unit(settings.units, "m");
    element("length").textContent = `${(settings.string.L * factor).toFixed(0)} ${symbol}`;
  }

  #keepAddress(): void {
    clearTimeout(this.#addressTimer);
    this.#addressTimer = setTimeout(() => {
      const address = toAddress(this.#settings, this.#standard, TABLES);
      if (location.hash.replace(/^#/, "") !== address) {
        history.replaceState(null, "", `#${address}`);
      }
    }, 250);
  }

  #listen(): void {
    fillLists(this.#standard, () => this.#settings, (settings) => this.change(settings), (settings) => this.take(settings));
    const enabled = element<HTMLInputElement>("enabled");
    enabled.addEventListener("change", () => this.change({ ...this.#settings, enabled: enabled.checked }));
    const alone = element<HTMLAnchorElement>("alone");
    alone.hidden = !EMBEDDED;
    alone.addEventListener("click", () => (alone.href = this.#link()));
    alone.href = this.#link();
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
    window.addEventListener("hashchange", ({ newURL }) => {
      // not location.hash, into which the address of before may just have been written
      this.take(fromAddress(new URL(newURL).hash, this.#standard, this.#limits, TABLES));
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#traces.build(this.#settings);
      [this.#fresh, this.#mapChanged] = [true, true];
    });
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#listenToMap();
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
    } else if (event.key.toLowerCase() === "l" && !element("switch").hidden) {
      this.change({ ...this.#settings, enabled: !this.#settings.enabled });
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

  /** The page by itself with what is set, whether it is inside another or not. */
  #link(): string {
    return `${location.href.replace(/[?#].*$/s, "")}#${toAddress(this.#settings, this.#standard, TABLES)}`;
  }

  async #share(): Promise<void> {
    const button = element("share");
    try {
      await navigator.clipboard.writeText(this.#link());
      button.textContent = "Copied";
    } catch {
      history.replaceState(null, "", `#${toAddress(this.#settings, this.#standard, TABLES)}`);
      button.textContent = EMBEDDED ? "Open it alone" : "See the address bar";
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
