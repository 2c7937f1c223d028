/** The state of the run in words and numbers. */

import type { History, Motion } from "./history";
import { LAWS } from "./laws";
import { unit, type Settings } from "./settings";
import { shown } from "./shown";
import { hasDriller } from "./system";

export const VERDICTS: Record<Motion["state"], string> = {
  starting: "Starting",
  steady: "Steady rotation",
  vibrating: "Swinging, not sticking",
  sticking: "Sticking and slipping",
  stuck: "Stuck",
};

export function severityWord(ssi: number): string {
  return Number.isFinite(ssi) ? ssi.toFixed(2) : "–";
}

/** The numbers with their names, for the law, the drive and the driller that there are. */
function all(history: History, { ssi }: Motion, settings: Settings): [string, string][] {
  const value = (name: string, of: string): string => {
    const { symbol, factor } = unit(settings.units, of);
    return `${(history.last(name) * factor).toFixed(2)} ${symbol}`;
  };
  const { gives } = LAWS[settings.law];
  const moved = gives !== undefined && !gives.endsWith(".WOB");
  const weighed = gives?.endsWith(".WOB") === true || hasDriller(settings);
  const more = shown(settings);
  const limits = more.filter(({ flag, port }) => flag !== undefined && history.last(port) > 0).map(({ flag }) => flag);
  return [
    ["Time", `${history.last("time").toFixed(1)} s`], ["SSI", severityWord(ssi)],
    ["Bit speed", value("bit_speed", "rad/s")], ["Top speed", value("top_speed", "rad/s")],
    ...(moved ? [["Drive speed", value("Omega", "rad/s")] as [string, string]] : []),
    ...(weighed ? [["Weight on bit", value("WOB", "N")] as [string, string]] : []),
    ["Torque on bit", value("bit_torque", "N.m")], ["Torque at the top", value("top_torque", "N.m")],
    ["Energy", value("energy", "J")],
    ...more.filter(({ label }) => label).map(({ port, label = "", unit: of = "1" }): [string, string] => [label, value(port, of)]),
    ...(more.some(({ flag }) => flag) ? [["At a limit", [...new Set(limits)].join(", ") || "none"] as [string, string]] : []),
  ];
}

export function showNumbers(list: HTMLElement, history: History, motion: Motion, settings: Settings): void {
  const numbers = all(history, motion, settings);
  if (list.children.length !== numbers.length) {
    list.innerHTML = numbers.map(() => "<div><dt></dt><dd></dd></div>").join("");
  }
  numbers.forEach(([name, value], index) => {
    const [term, text] = list.children[index]?.children ?? [];
    (term as HTMLElement).textContent = name;
    (text as HTMLElement).textContent = value;
  });
}
