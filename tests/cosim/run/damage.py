"""Damage to result folders, drawn at random: bits, cuts, files that are missing, swapped, of others, or links.

`python -m tests.cosim.run.damage COUNT [SEED]` does so many to a finished and to an interrupted folder of each format.
"""

from __future__ import annotations

import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from cosim.errors import CosimError, RunInterruptedError
from cosim.run.job import resume_job, run_job
from cosim.run.report import read_content
from tests.cosim.run.jobs import Outcome, manifest_of, nothing, outcome, rows_of, sketch, small

KINDS = ("finished zarr", "interrupted zarr", "interrupted csv")


@dataclass(frozen=True)
class Folder:
    """A folder as it was left, and what must come of it."""

    kind: str
    path: Path
    truth: Outcome


def flipped(content: bytes, rng: random.Random) -> bytes:
    """Turn some bits over, neighbours or not."""
    found = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 8))):
        found[rng.randrange(len(found))] ^= 1 << rng.randrange(8)
    return bytes(found)


def overwritten(content: bytes, rng: random.Random) -> bytes:
    """Write zeros, or what is by chance, over a part."""
    begin = rng.randrange(len(content))
    length = min(len(content) - begin, rng.choice((1, 16, 512, 4096)))
    return (
        content[:begin] + (bytes(length) if rng.random() < 0.5 else rng.randbytes(length)) + content[begin + length :]
    )


def repeated_digit(content: bytes, rng: random.Random) -> bytes:
    """Change a digit, as an editor would."""
    places = [place for place, byte in enumerate(content) if 48 <= byte <= 57]
    if not places:
        return flipped(content, rng)
    place = rng.choice(places)
    return content[:place] + b"%d" % rng.randrange(10) + content[place + 1 :]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    flipped,
    flipped,
    overwritten,
    repeated_digit,
    lambda content, rng: content[: rng.randrange(len(content))],
    lambda content, rng: content + rng.randbytes(rng.choice((1, 100))),
    lambda content, rng: b"",
)


def damage(folder: Path, rng: random.Random) -> str:
    """Damage one file of a folder, or two, and say how."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    # half of the damage is done where rows are not: there are more files with them than without
    apart = [path for path in files if path.parent == folder or path.name.startswith(".")]
    path = rng.choice(apart if rng.random() < 0.5 else files)
    name = path.relative_to(folder)
    way = rng.choice(("change", "change", "change", "missing", "swapped", "link", "folder", "copied"))
    if way == "change" and path.stat().st_size:
        change = rng.choice(CHANGES)
        path.write_bytes(change(path.read_bytes(), rng))
        return f"{name}: {change.__name__}"
    if way in ("swapped", "copied"):
        other = rng.choice(files)
        content = path.read_bytes()
        path.write_bytes(other.read_bytes())
        if way == "swapped":
            other.write_bytes(content)
        return f"{name}: {way} {other.relative_to(folder)}"
    if way == "link" and rng.random() < 0.5 and path.parent != folder:
        moved = path.parent.rename(folder.with_name("elsewhere"))
        path.parent.symlink_to(moved, target_is_directory=True)
        return f"{path.parent.relative_to(folder)}: link"
    content = path.read_bytes()
    path.unlink()
    if way == "link":
        target = folder.with_name("precious")
        target.write_bytes(content)
        path.symlink_to(target)
    elif way == "folder":
        path.mkdir()
    return f"{name}: {way}"


def precious(folder: Path) -> dict[str, bytes]:
    """What lies outside of a folder, where nothing may be written."""
    found = [folder.with_name("precious"), *folder.with_name("elsewhere").glob("*")]
    return {str(path): path.read_bytes() for path in found if path.is_file()}


def examine(folder: Folder, place: Path) -> str:
    """Use a damaged folder the way its owner would; return what came of it, "named" or "harmless".

    Raises
    ------
    AssertionError
        If anything wrong came of it.
    """
    outside, before = precious(place), {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    named = False
    try:
        if not folder.kind.startswith("finished"):
            resume_job(place, lambda job: None, nothing)
    except CosimError as error:
        check_sentence(error)
        after = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
        if after != before:
            raise AssertionError("what is refused was not left alone") from error
        named = True
    if not (named and folder.kind.endswith("csv")):  # the owner of a table has been told, and nothing else reads it
        named = read(folder, place, complete=not named or folder.kind.startswith("finished")) or named
    assert precious(place) == outside, "what lies elsewhere was written to"
    return "named" if named else "harmless"


def check_sentence(error: CosimError) -> None:
    """Assert that an error is one line of text."""
    text = str(error)
    assert text
    assert "\n" not in text


def read(folder: Folder, place: Path, *, complete: bool) -> bool:
    """Read manifest and rows, which must be right; return whether they were refused."""
    try:
        content = read_content(place)
        rows = rows_of(place)
    except CosimError as error:
        check_sentence(error)
        return True
    folder.truth.assert_begins_with(Outcome(rows, {}))
    if complete and content is not None:
        Outcome(rows, manifest_of(place)).assert_same(folder.truth)
    return content is None


def made_folders(place: Path) -> list[Folder]:
    """Make the folders that are to be damaged."""
    folders: list[Folder] = []
    for kind in KINDS:
        job = small(place, "light", csv=kind.endswith("csv"))
        whole = place / f"{kind} whole"
        run_job(job, whole, nothing)
        truth = outcome(whole)
        if kind.startswith("finished"):
            folders.append(Folder(kind, whole, truth))
            continue
        path = place / kind
        with pytest.raises(RunInterruptedError):
            run_job(job, path, interrupt)
        folders.append(Folder(kind, path, truth))
    return folders


def interrupt(label: str, part: float) -> None:
    """Interrupt a run in its middle."""
    if part > 0.5:
        raise KeyboardInterrupt


def attack(folders: list[Folder], place: Path, rng: random.Random, counts: Counter[str]) -> None:
    """Damage a copy of one of the folders and examine it; what is wrong says how it came about."""
    folder = rng.choice(folders)
    copy = place / "copy"
    shutil.copytree(folder.path, copy)
    how = damage(copy, rng)
    try:
        counts[f"{folder.kind}: {examine(folder, copy)}"] += 1
    except BaseException as error:
        error.add_note(f"{folder.kind}: {how}")
        raise
    finally:
        shutil.rmtree(copy)
        shutil.rmtree(place / "elsewhere", ignore_errors=True)
        (place / "precious").unlink(missing_ok=True)


def attacked(count: int, seed: int, place: Path) -> tuple[Counter[str], list[str]]:
    """Damage folders so many times; return how often what came of it, and what was wrong."""
    rng = random.Random(seed)
    counts: Counter[str] = Counter()
    wrong: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cosim.drilling.reporting.draw", sketch)
        patch.setattr(tempfile, "tempdir", str(place))
        folders = made_folders(place)
        for _ in range(count):
            try:
                attack(folders, place, rng, counts)
            except Exception as error:
                wrong.append("".join(traceback.format_exception(error)))
    return counts, wrong


def main() -> None:
    """Damage folders as often as asked for, and write what came of it."""
    count, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        counts, wrong = attacked(count, seed, Path(folder))
    sys.stdout.write("\n".join([*wrong, *(f"{name}: {number}" for name, number in sorted(counts.items()))]) + "\n")
    sys.stdout.write(f"{len(wrong)} wrong of {count}\n")


if __name__ == "__main__":
    main()
