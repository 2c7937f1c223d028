"""What goes into the FMUs, and what builds them from it."""
