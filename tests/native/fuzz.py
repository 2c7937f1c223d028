"""Fuzzes a model's FMU for as long as it is told: python -m tests.native.fuzz MODEL SECONDS."""

from __future__ import annotations

import subprocess
import sys

from tests.native.programs import BUILD, FUZZ, MissingToolError, compile_linked


def main(model: str, seconds: str) -> int:
    """Run libFuzzer; what it has learned, and what it has found, stays below build/."""
    program = compile_linked(model, FUZZ)
    corpus = BUILD / "corpus" / model
    corpus.mkdir(parents=True, exist_ok=True)
    options = [f"-max_total_time={seconds}", "-max_len=2048", "-len_control=0", "-timeout=60", "-print_final_stats=1"]
    return subprocess.run([str(program), *options, str(corpus)], cwd=program.parent, check=False).returncode


if __name__ == "__main__":
    try:
        sys.exit(main(*sys.argv[1:]))
    except MissingToolError as error:
        sys.exit(str(error))
