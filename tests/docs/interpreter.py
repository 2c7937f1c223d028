"""Run blocks of Python, one after the other in one session, as a page's reader would who types them in.

A line on standard input is a block, as JSON; the answer is a line of JSON on what standard output was at the start.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import traceback


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what C code or other processes write is no answer
    sys.path[0] = ""  # the page's folder, as for one who types
    session: dict[str, object] = {"__name__": "__main__"}
    for request in sys.stdin:
        block = json.loads(request)
        written = io.StringIO()
        failed = False
        with contextlib.redirect_stdout(written), contextlib.redirect_stderr(written):
            try:
                # as many lines before it as the page has: a traceback then shows the page's own
                exec(compile("\n" * block["line"] + block["source"], block["path"], "exec"), session)
            except Exception:
                failed = True
                traceback.print_exc()
        answers.write(json.dumps({"printed": written.getvalue(), "failed": failed}) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
