"""Files mutated from valid ones: every one gives a result or a sentence, none a traceback."""

from __future__ import annotations

import os
import random
import re
import zipfile
from pathlib import Path

import pytest

from cosim import simulate
from cosim.errors import CosimError
from cosim.scenario.file import opened_scenario
from tests.cosim.scenario.test_ssp_file import STRUCTURE, bindings, external, parameter, parameter_set

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_leftovers")]

EACH = int(os.environ.get("MUTATIONS", "200"))
"""How many of each kind; MUTATIONS=2000 tries 10,000 in all."""

TOKEN = re.compile(r'"[^"]*"|[\w.+-]+|\s+|.', re.DOTALL)
STRANGE = (
    "", "-1", "0", "1e400", "-1e308", "nan", "inf", "0x10", "007", ".5", "1_000", "true", "None", "u", "..", "/",
    "\\", "4294967296", "99999999999999999999", "é", "\u202e", "\u0000", "\u001b", " ", "\n", "<", ">", "&", "&lt;",
    "]]>", "{", "[", "=", ",",
)  # fmt: skip

TOML = """title = "mutated"
stop_time = 1.0
step_size = 0.1
algorithm = "gauss-seidel"
connections = [{ from = "one.u_seen", to = "two.u" }]
[components.one]
fmu = "probe.fmu"
parameters = { gain = 2.0, mode = "fast", text = "ü" }
[components.two]
fmu = "probe.fmu"
[inputs]
"one.u" = { kind = "table", file = "table.csv", column = "u" }
"one.v" = { kind = "ramp", initial = 0.0, final = 3.0, start = 0.1, duration = 0.5 }
"one.n" = { kind = "table", points = [[0, 3], [0.5, 4]] }
"one.flag" = { kind = "step", before = false, after = true, at = 0.5 }
[[variants]]
name = "other"
set = { "two.gain" = 4, "one.flag" = { kind = "table", points = [[0, true], [0.6, false]] } }
"""
CSV = "time,u,v\n0,1.0,2\n0.25,1.5,3\n0.5,-2e-1,4\n1.0,0.0,5\n"
SSV = parameter_set(
    parameter("gain", "Real", "2"), parameter("mode", "Enumeration", "fast"), parameter("n", "Integer", "3")
)
SSD = STRUCTURE.replace("<!--bindings-->", bindings(external("resources/set.ssv")))


def mutated(text: str, chance: random.Random) -> str:
    """Return a text with one to three changes to its tokens."""
    tokens = TOKEN.findall(text)
    for _ in range(chance.randint(1, 3)):
        at, to = (chance.randrange(len(tokens)) for _ in range(2))
        match chance.randrange(5):
            case 0:
                quoted = tokens[at].startswith('"')
                new = chance.choice(STRANGE)
                tokens[at] = f'"{new}"' if quoted else new
            case 1:
                del tokens[at : at + chance.randint(1, 8)]
            case 2:
                tokens[at:at] = tokens[to : to + chance.randint(1, 12)]
            case 3:
                tokens[at], tokens[to] = tokens[to], tokens[at]
            case _:
                place = chance.randint(0, len(tokens[at]))
                tokens[at] = tokens[at][:place] + chance.choice(STRANGE) + tokens[at][place:]
        tokens = tokens or [""]
    return "".join(tokens)


def packed(path: Path, *members: tuple[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members:
            archive.writestr(name, content)
    return path


@pytest.mark.parametrize(
    "kind", ["modelDescription.xml", "SystemStructure.ssd", "set.ssv", "table.csv", "scenario.toml"]
)
def test_a_mutated_file_gives_a_result_or_a_sentence(probe: Path, tmp_path: Path, kind: str) -> None:
    outcomes = {True: 0, False: 0}
    for seed in range(EACH):
        outcomes[_outcome(probe, tmp_path / "run", kind, seed)] += 1
    assert all(outcomes.values()), f"nothing is learned from mutations that all end alike: {outcomes}"


def _outcome(probe: Path, folder: Path, kind: str, seed: int) -> bool:
    """Run with one file mutated; return whether that came to a result."""
    with zipfile.ZipFile(probe) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    texts = {"table.csv": CSV, "scenario.toml": TOML, "SystemStructure.ssd": SSD, "set.ssv": SSV}
    texts["modelDescription.xml"] = members["modelDescription.xml"].decode()
    now = texts | {kind: mutated(texts[kind], random.Random(f"{kind} {seed}"))}
    contents = {name: text.encode("utf-8", "surrogatepass") for name, text in now.items()}
    folder.mkdir(exist_ok=True)
    fmu = members | {"modelDescription.xml": contents["modelDescription.xml"]}
    packed(folder / "probe.fmu", *fmu.items())
    (folder / "table.csv").write_bytes(contents["table.csv"])
    (folder / "scenario.toml").write_bytes(contents["scenario.toml"])
    packed(
        folder / "system.ssp", ("SystemStructure.ssd", contents["SystemStructure.ssd"]),
        ("resources/set.ssv", contents["set.ssv"]), ("resources/probe.fmu", (folder / "probe.fmu").read_bytes()),
    )  # fmt: skip
    source = folder / ("system.ssp" if kind in ("SystemStructure.ssd", "set.ssv") else "scenario.toml")
    return _runs(source, f"{kind}, seed {seed}")


@pytest.mark.parametrize(("kind", "seed"), [("SystemStructure.ssd", 307), ("table.csv", 993)])
def test_what_a_long_hunt_has_found_ends_in_a_sentence(probe: Path, tmp_path: Path, kind: str, seed: int) -> None:
    assert not _outcome(probe, tmp_path / "run", kind, seed)


def _runs(source: Path, what: str) -> bool:
    """Run a file; return whether that came to a result, and fail if it ended in anything but a sentence."""
    said = "a result"
    try:
        with opened_scenario(str(source), 1.5, 0.1) as scenario:
            simulate(scenario, stop_time=scenario.start_time + 1.0, step_size=0.1)
    except CosimError as error:
        said = str(error)
    except Exception as error:
        pytest.fail(f"{what}: {type(error).__name__}: {error}")
    assert said.strip(), what
    assert "\n" not in said, f"{what}: {said}"
    return said == "a result"
