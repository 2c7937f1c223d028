// Write how runs from steady rotation end at some speeds, of the string alone: as it is, and with gains of a drive that
// is not there.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, ...speeds] = process.argv.slice(2);
const { changed, Core, defaults, severity } = await import(pathToFileURL(`${folder}/node.mjs`).href);
const tables = JSON.parse(readFileSync(`${folder}/tables.json`, "utf8"));
const core = await Core.load(readFileSync(`${folder}/core.wasm`), tables);
const noise = { "TopDrive.speed_noise": 0.05, "TopDrive.torque_noise": 150 };
const found = (changes) => speeds.map((omega) =>
  severity(core, changed(defaults(tables), { ...changes, omega: Number(omega) }), "steady"));
console.log(JSON.stringify({ plain: found({}), noisy: found({ gains: noise }) }));
