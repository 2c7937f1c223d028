/** What the build puts into the page. */

declare const CORE_BASE64: string;
declare const TABLES: import("./core").Tables;
declare const RUN_WORKER: string;
declare const MAP_WORKER: string;
