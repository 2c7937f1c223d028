"""Run a page: one session in a folder of its own, as its reader would have it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from tests.docs import formats
from tests.docs.expected import differences
from tests.docs.pages import ROOT, Block, Page

SOURCES = {"build_fmu.py": "build_fmu.py", "models": "from models"}
"""What a page's reader takes from the checkout, and how one sees it."""

ENVIRONMENT = Path(sys.executable).parent
LONGEST = 300.0
"""Seconds until what hangs is ended; the longest page takes a tenth of it."""


@dataclass
class Printed:
    """What the block before has printed, or why it was not run; a text that shows it claims it."""

    block: Block
    text: str
    not_run: bool = False
    claimed: bool = False


class Session:
    """What runs the blocks of one page in a folder; to be closed."""

    def __init__(self, page: Page, folder: Path) -> None:
        self.page = page
        self.folder = folder
        self.last: Printed | None = None
        self._python: subprocess.Popen[str] | None = None
        # as in a pipe: no colours, and tables as wide as they are; and compiled modules are kept, as make has it
        own = {"NO_COLOR": "1", "MPLBACKEND": "Agg", "PYTHONUNBUFFERED": "1", "OPENBLAS_NUM_THREADS": "1"}
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "COV_", "FORCE"))}
        self.environment = kept | own | {"PATH": f"{ENVIRONMENT}{os.pathsep}{os.environ['PATH']}"}
        for name in ("COLUMNS", "PYTHONDONTWRITEBYTECODE"):
            self.environment.pop(name, None)
        lay_out(page, folder)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._python is not None:
            assert self._python.stdin is not None
            assert self._python.stdout is not None
            self._python.stdin.close()
            self._python.wait(LONGEST)
            self._python.stdout.close()

    def run(self) -> None:
        """Run or examine every block, in order.

        Raises
        ------
        PageError
            At the first block that fails, or prints something else than the page shows.
        """
        for block in self.page.blocks:
            if block.told.not_run is not None:
                self._leave(block)
            elif block.language == "sh":
                self._keep(block, self._bash(block, block.content))
            elif block.language == "python" and block.file is None:
                self._keep(block, self._exec(block))
            elif block.language == "text":
                self._compare(block)
            elif block.language == "diff":
                formats.apply_diff(block, self.folder)
            else:
                self._write(block)
        self._close_last()

    def _keep(self, block: Block, printed: str) -> None:
        self._close_last()
        self.last = Printed(block, printed)

    def _leave(self, block: Block) -> None:
        if block.language == "text":
            if self.last:
                self.last.claimed = True
            return
        self._close_last()
        formats.examine(block)
        self.last = Printed(block, "", not_run=True)

    def _close_last(self) -> None:
        """Hold a block of Python to it that what it prints is shown; of commands what is shown is what matters."""
        last, self.last = self.last, None
        if last and not last.claimed and last.block.language == "python" and last.text.strip():
            raise last.block.error(f"no text below shows what it prints:\n{last.text}")

    def _compare(self, block: Block) -> None:
        transcript = re.split(r"(?m)^\$ (.*\n)", block.content)
        if transcript[0].strip():
            assert self.last is not None  # accounted for by formats.unaccounted
            self.last.claimed = True
            if not self.last.not_run:
                self._hold(block, block.content, self.last.text)
            return
        for command, shown in zip(transcript[1::2], transcript[2::2], strict=True):
            fails = any(line.startswith("error: ") for line in shown.splitlines())
            self._hold(block, shown, self._bash(block, command, fails=fails))

    def _hold(self, block: Block, shown: str, printed: str) -> None:
        if difference := differences(_replaced(block, shown), printed, figures=block.told.figures_differ is None):
            raise block.error(f"what is printed is not what is shown:\n{difference}")

    def _bash(self, block: Block, script: str, fails: bool = False) -> str:
        """Run lines by bash until one fails; return what was printed, to both outputs."""
        lines = [line for line in script.splitlines() if not line.startswith(block.told.left_out or ("\0",))]
        script = _replaced(block, "\n".join(lines))
        trap = (
            "" if fails or block.told.interrupted_once else "trap 'echo \"bash: line $LINENO ended with $?\" >&2' ERR\n"
        )
        command = ["bash", "-e", "-u", "-o", "pipefail", "-c", trap + script]
        options = {"cwd": self.folder, "env": self.environment, "text": True, "start_new_session": True}
        options |= {"preexec_fn": _heed_interrupts} if block.told.interrupted_once else {}
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options) as process:
            awaited = block.told.interrupted_once
            if awaited is not None:
                self._interrupt(block, process, self.folder / awaited)
            try:
                printed, _ = process.communicate(timeout=LONGEST)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                raise block.error(f"not done after {LONGEST} s") from None
        if awaited is None and (process.returncode != 0) is not fails:
            raise block.error(f"exit code {process.returncode}:\n{script}\n{printed}")
        return printed

    @staticmethod
    def _interrupt(block: Block, process: subprocess.Popen[str], awaited: Path) -> None:
        """Press Ctrl-C once a file is there."""
        end = time.monotonic() + LONGEST
        while not awaited.exists():
            if process.poll() is not None or time.monotonic() > end:
                raise block.error(f"ended, or took {LONGEST} s, before there was {awaited.name}")
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)

    def _exec(self, block: Block) -> str:
        """Run a block in the page's session of Python; return what was printed."""
        if self._python is None:
            command = [sys.executable, str(Path(__file__).with_name("interpreter.py"))]
            options = {"cwd": self.folder, "env": self.environment, "encoding": "utf-8"}
            self._python = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **options)
        assert self._python.stdin is not None
        assert self._python.stdout is not None
        request = {"source": _replaced(block, block.content), "path": str(block.path), "line": block.line}
        self._python.stdin.write(json.dumps(request) + "\n")
        self._python.stdin.flush()
        answer = json.loads(self._python.stdout.readline() or '{"printed": "the interpreter ended", "failed": true}')
        if answer["failed"]:
            raise block.error(answer["printed"])
        return answer["printed"]

    def _write(self, block: Block) -> None:
        """Write a block as the file that the page says it is; one that a command has written must be as shown."""
        content = _replaced(block, block.content)
        formats.examine(block)
        if block.file is None:
            return
        path = self.folder / block.file
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise block.error(f"{block.file} lies outside the page's folder")
        if path.exists():
            if difference := differences(content, path.read_text(encoding="utf-8")):
                raise block.error(f"{block.file} is there and differs:\n{difference}")
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        formats.examine_file(block, path)


def lay_out(page: Page, folder: Path) -> None:
    """Give a folder what the blocks of a page find in a checkout: the environment, the FMUs, the scripts."""
    code = "\n".join(block.content for block in page.blocks)
    if ".venv/" in code:
        (folder / ".venv").symlink_to(sys.prefix)
    if "dist/" in code:
        for packaging in ("native", "python"):
            # each file a link of its own: what is built by a page replaces the link and not the file
            (folder / "dist" / packaging).mkdir(parents=True)
            for fmu in (ROOT / "dist" / packaging).glob("*.fmu"):
                (folder / "dist" / packaging / fmu.name).symlink_to(fmu)
    for name, sign in SOURCES.items():
        if sign in code:
            (folder / name).symlink_to(ROOT / name)


def _heed_interrupts() -> None:
    """Let Ctrl-C end what comes, though the tests may have been started in the background, where it is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _replaced(block: Block, text: str) -> str:
    for shown, run in block.told.replaced:
        text, count = re.subn(rf"(?<![\w.]){re.escape(shown)}(?![\w.])", lambda _, run=run: run, text)
        if not count:
            raise block.error(f"says that it is run with {shown!r} as something else, which is not in it")
    return text
