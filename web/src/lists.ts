/** The lists to choose from: presets, laws, drives, and how the weight comes about. */

import { DRIVES, FEEDS, LAWS, type Drive, type Feed, type Law } from "./laws";
import { changed, PRESETS, type Settings } from "./settings";

interface Offer {
  readonly title: string;
  readonly value: string;
  /** under which heading, if any */
  readonly group: string;
}

function fill(list: HTMLSelectElement, offers: readonly Offer[]): void {
  for (const { title, value, group } of offers) {
    let place: HTMLElement = list;
    if (group !== "") {
      place = [...list.querySelectorAll("optgroup")].find(({ label }) => label === group) ?? document.createElement("optgroup");
      (place as HTMLOptGroupElement).label = group;
      list.append(place);
    }
    place.append(new Option(title, value));
  }
}

function list(id: string): HTMLSelectElement {
  return document.getElementById(id) as HTMLSelectElement;
}

/** Fill the lists, and change settings by them; a preset is taken up as a run of its own. */
export function fillLists(
  standard: Settings, read: () => Settings, change: (settings: Settings) => void, take: (settings: Settings) => void,
): void {
  const law = list("law");
  const groups = Object.entries(LAWS).map(([name, { title, group }]) => ({ title, group, value: name }));
  fill(law, groups);
  law.addEventListener("change", () => change({ ...read(), law: law.value as Law, enabled: true }));
  const drive = list("drive-kind");
  fill(drive, Object.entries(DRIVES).map(([value, title]) => ({ title, value, group: "" })));
  drive.addEventListener("change", () => change({ ...read(), drive: drive.value as Drive }));
  const feed = list("feed");
  fill(feed, Object.entries(FEEDS).map(([value, title]) => ({ title, value, group: "" })));
  feed.addEventListener("change", () => change({ ...read(), feed: feed.value as Feed }));
  const preset = list("preset");
  const presets = Object.entries(PRESETS).flatMap(([group, all]) => all.map((each) => ({ ...each, group })));
  fill(preset, [{ title: "choose one", value: "", group: "" },
    ...presets.map(({ name, group }, index) => ({ title: name, value: String(index), group }))]);
  preset.addEventListener("change", () => {
    const chosen = preset.value === "" ? undefined : presets[Number(preset.value)];
    if (chosen) {
      const { units, speed } = read();
      const { value } = preset;
      take(changed({ ...standard, units, speed }, chosen.changes));
      preset.value = value;
    }
  });
}
