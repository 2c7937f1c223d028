// Write what the console draws along the string at some times of a run from rest, and the torques at its ends.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, ...times] = process.argv.slice(2);
const { Core, defaults, Rig, Waves } = await import(pathToFileURL(`${folder}/node.mjs`).href);
const tables = JSON.parse(readFileSync(`${folder}/tables.json`, "utf8"));
const core = await Core.load(readFileSync(`${folder}/core.wasm`), tables);
const rig = new Rig(core, defaults(tables));
const waves = new Waves(rig);
const found = [];
for (const time of times.map(Number)) {
  while (rig.time < time - 1e-9) {
    rig.advance();
    waves.record(rig);
  }
  const [top, bit] = [rig.plant.get("top_torque"), rig.plant.get("bit_torque")];
  found.push({ torque: [...waves.torque()], top, bit, stuck: rig.plant.get("bit_stuck") });
}
console.log(JSON.stringify(found));
