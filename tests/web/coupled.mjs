// Run systems of the console in node: those of presets that are scenarios, and one for each law, drive and feed.
// Writes what each consists of, and its outputs after each step as bytes in base64.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, presetSeconds, systemSeconds] = process.argv.slice(2);
const { changed, Core, defaults, DRIVES, FEEDS, LAWS, models, PRESETS, Rig } = await import(pathToFileURL(`${folder}/node.mjs`).href);
const tables = JSON.parse(readFileSync(`${folder}/tables.json`, "utf8"));
const core = await Core.load(readFileSync(`${folder}/core.wasm`), tables);
const outputs = JSON.parse(readFileSync(0, "utf8")); // by model

function run(changes, seconds, switchedAt) {
  const rig = new Rig(core, changed(defaults(tables), changes));
  const seats = rig.system.parts.flatMap(({ name, model }) => outputs[model].map((output) => [name, output]));
  const ports = seats.map((seat) => seat.join("."));
  const columns = seats.map(([name, output]) => [rig.part(name), rig.part(name).reference(output)]);
  const signals = Object.fromEntries(Object.keys(rig.system.signals).map((port) => [port, rig.get(port)]));
  const rows = [];
  const steps = Math.round(seconds / rig.step);
  for (let step = 0; step <= steps; ++step) {
    rows.push(...columns.map(([model, reference]) => model.values[reference]));
    if (step === Math.round(switchedAt / rig.step)) {
      rig.tune({ ...rig.settings, enabled: true });
    }
    rig.advance();
  }
  rig.release();
  return { ...rig.system, signals, ports, steps, rows: Buffer.from(Float64Array.from(rows).buffer).toString("base64") };
}

const presets = {};
for (const preset of Object.values(PRESETS).flat().filter(({ scenario }) => scenario)) {
  presets[preset.scenario] = run(preset.changes, Number(presetSeconds), 60);
}
const systems = {};
for (const law of Object.keys(LAWS)) {
  for (const drive of Object.keys(DRIVES)) {
    for (const feed of Object.keys(FEEDS)) {
      const changes = { law, drive, feed, omega: 9, weight: 80000 };
      const all = `${law}: ${models(changed(defaults(tables), changes)).join(", ")}`;
      systems[all] ??= run(changes, Number(systemSeconds), NaN);
    }
  }
}
console.log(JSON.stringify({ presets, systems }));
