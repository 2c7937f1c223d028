// Build the console into one file: node build.mjs FOLDER, which holds core.wasm and tables.json and gets console.html.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = process.argv[2];
const madeFrom = process.argv[3] ?? "";
const options = { bundle: true, minify: true, target: "es2022", write: false, legalComments: "none", logLevel: "warning" };

async function bundled(entry, more = {}) {
  const result = await build({ ...options, entryPoints: [join(here, "src", entry)], ...more });
  return result.outputFiles[0].text;
}

// The page holds the text of its workers, and the core in base64.
const core = readFileSync(join(folder, "core.wasm")).toString("base64");
const tables = readFileSync(join(folder, "tables.json"), "utf8");
const define = {
  CORE_BASE64: JSON.stringify(core),
  TABLES: tables,
  RUN_WORKER: JSON.stringify(await bundled("run_worker.ts", { format: "iife" })),
  MAP_WORKER: JSON.stringify(await bundled("map_worker.ts", { format: "iife" })),
};
const script = (await bundled("main.ts", { format: "iife", define })).replaceAll("</script", "<\\/script");
const style = await bundled("style.css", { loader: { ".css": "css" } });
const digest = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
// Nothing is fetched: the browser is told so.
const policy = [
  "default-src 'none'",
  `script-src ${digest(script)} 'wasm-unsafe-eval' blob:`,
  "worker-src blob:",
  "style-src 'unsafe-inline'",
  "img-src data: blob:",
].join("; ");
const notices = [readFileSync(join(folder, "licenses.txt"), "utf8"),
  `uPlot\n\n${readFileSync(join(here, "node_modules/uplot/LICENSE"), "utf8")}`].join("\n\n");
const page = readFileSync(join(here, "index.html"), "utf8")
  .replace("<!-- policy -->", () => `<meta http-equiv="Content-Security-Policy" content="${policy}">`)
  .replace("<!-- made from -->", () => `<meta name="made-from" content="${madeFrom}">`)
  .replace("<!-- licenses -->", () => `<!--\n${notices.replaceAll("--", "- -")}\n-->`)
  .replace("<!-- style -->", () => `<style>${style}</style>`)
  .replace("<!-- script -->", () => `<script>${script}</script>`);
writeFileSync(join(folder, "console.html"), page);
writeFileSync(join(folder, "node.mjs"), await bundled("node.ts", { format: "esm", platform: "node" }));
