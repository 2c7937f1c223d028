"""What IPython runs before the cells of a tutorial: nothing in the results is to depend on when it came."""


def _be_steady() -> None:
    import logging
    import sys
    from typing import Any, cast

    import cosim.progress

    for stream in (sys.stdout, sys.stderr):
        cast("Any", stream).flush_interval = 3600.0  # [s]: a cell's text arrives whole, and not cut where time was up
    logging.disable(logging.WARNING)  # a warning arrives among the results, now here, now there
    cosim.progress.PATIENCE = float("inf")  # a bar would be shown by slow machines only


_be_steady()
