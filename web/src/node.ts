/** What of the console runs without a browser: for the tests. */

export { Core } from "./core";
export { replay } from "./replay";
export { changed, defaults, fromAddress, toAddress } from "./settings";
export { Rig } from "./rig";
export { severity } from "./severity";
export { criticalSlope, threshold } from "./theory";
export { Waves } from "./waves";
