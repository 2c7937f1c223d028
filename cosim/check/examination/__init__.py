"""An FMU put to the test: its library is called, in a process of its own, as importers call it."""
