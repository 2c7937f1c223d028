// Run the programs of standard input on the console's core in node; write their rows, one after another, as bytes.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const folder = process.argv[2];
const { Core, replay } = await import(pathToFileURL(`${folder}/node.mjs`).href);
const core = await Core.load(readFileSync(`${folder}/core.wasm`), JSON.parse(readFileSync(`${folder}/tables.json`, "utf8")));
const programs = JSON.parse(readFileSync(0, "utf8"));
for (const program of Object.values(programs)) {
  process.stdout.write(Buffer.from(replay(core, program).buffer));
}
