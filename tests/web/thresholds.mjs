// Write the linear threshold that the console finds for each string and weight of standard input; null for none.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const { criticalSlope, threshold } = await import(pathToFileURL(`${process.argv[2]}/node.mjs`).href);
const cases = JSON.parse(readFileSync(0, "utf8"));
console.log(JSON.stringify(cases.map(([string, weight]) => threshold(string, weight, criticalSlope(string)))));
