"""State what is coupled with what, as pure data: components, connections, signals, units, dependencies, method."""
