"""Build FMUs from an installed package, as `cosim build` does."""

from .command import main

main()
