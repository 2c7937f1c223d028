"""A run as a user asks for it: options, assembly, simulation, and what is written to its folder."""
