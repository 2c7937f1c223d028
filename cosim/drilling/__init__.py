"""All that knows of bits and strings: measures, energy, figures, maps."""
