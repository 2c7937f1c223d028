"""Continues a saved run in a process of its own: reads what to do from a JSON file, prints the outputs as JSON."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tests.plant.drive import Drive
from tests.plant.fmi import must


def main(task_file: str) -> None:
    task = json.loads(Path(task_file).read_text())
    with Drive(task["model"], {}, task["packaging"]) as fmu:
        must(fmu, fmu.restore(bytes.fromhex(task["state"])))
        fmu.time = float.fromhex(task["time"])
        rows = []
        for end in task["ends"]:
            fmu.go(float.fromhex(end))
            rows.append([float(value).hex() for value in fmu.outputs()])
    print(json.dumps(rows))


if __name__ == "__main__":
    main(sys.argv[1])
