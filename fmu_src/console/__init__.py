"""The driller's console: the C core as WebAssembly, and the page in the browser that runs it."""
