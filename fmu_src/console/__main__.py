"""Build the console, `python -m fmu_src.console`, or put the one that is built into a folder: `... --take FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

from ..errors import BuildError
from .page import build_page, take_page

match sys.argv[1:]:
    case []:
        try:
            page = build_page()
        except BuildError as error:
            sys.exit(f"error: {error}")
        print(f"wrote {page} ({page.stat().st_size / 1000:.0f} kB)")
    case ["--take", folder]:
        if not take_page(Path(folder)):
            print("the wheel goes without the console: build/console holds none of these sources; see make console")
    case _:
        sys.exit("expected no argument, or --take FOLDER")
