"""Put an FMU to the test: call its library, in a process of its own, as importers call it."""
