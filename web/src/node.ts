/** What of the console runs without a browser: for the tests. */

export { Core } from "./core";
export { DRIVES, FEEDS, LAWS } from "./laws";
export { replay } from "./replay";
export { changed, defaults, fromAddress, limits, PRESETS, toAddress } from "./settings";
export { Rig } from "./rig";
export { severity } from "./severity";
export { models } from "./system";
export { criticalSlope, threshold } from "./theory";
export { Waves } from "./waves";
