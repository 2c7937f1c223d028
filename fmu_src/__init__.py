"""Hold what goes into the FMUs, and build them from it."""
