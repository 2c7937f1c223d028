"""Name what can go wrong while FMUs are built."""


class BuildError(Exception):
    """An FMU could not be built; the message is a sentence that says why and what to do."""
