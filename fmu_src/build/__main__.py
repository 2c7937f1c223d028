"""Build FMUs from an installed package, as `cosim build` does."""

from .build.command import main

main()
