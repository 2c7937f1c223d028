"""The documentation page of an FMU."""
