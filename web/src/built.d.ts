/** What the build puts into the page. */

declare const CORE_BASE64: string;
declare const TABLES: Record<string, Record<string, readonly number[]>>;
declare const RUN_WORKER: string;
declare const MAP_WORKER: string;
