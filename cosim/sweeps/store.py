"""Keep the results of a sweep: a Zarr store, written in regions, and beside what is not in a region yet, a journal.

A region is some rows of the store, whole chunks of it. Points come in any order and are few at a time, so each batch
is appended to the journal, a line with a checksum, and a region is written when all its points are there. A program
that is killed loses what was under way. What has gone on from the journal and the store ends with the same bytes.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import zlib
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.errors import OutputError, require_installed
from cosim.files import draft_of, locked, open_file, why, write_all
from cosim.sweeps import series
from cosim.sweeps.arrays import Array, begin_group, consolidate, coordinate, described, stored_name
from cosim.sweeps.design import SAMPLES, Design
from cosim.sweeps.plan import Sweep
from cosim.sweeps.reading import RECORD, SERIES, place_of, quiet, reader
from cosim.sweeps.workers.work import Done, Stretch

JOURNAL = ".journal"
FAILED, MESSAGE = "failed", "message"
_NOT_YET = -1
_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL
_FEWEST_ROWS, _MOST_ROWS, _USUAL_POINTS = 10, 50, 1000
_LONGEST_MESSAGE = 300
_FOREIGN = "{} is there already and is no store of a sweep; expected a new name"


def region_rows(design: Design) -> int:
    """Return how many rows a region has: 10 to 50, about 1000 points; of samples, which are a point each, 1000."""
    size = design.shape[design.across[0]] if design.across else 1
    first = design.axes[design.across[0]].name if design.across else ""
    if first == SAMPLES and len(design.across) == 1:
        return min(size, _USUAL_POINTS)
    points = max(1, design.points // max(1, size))
    return min(size, max(_FEWEST_ROWS, min(_MOST_ROWS, -(-_USUAL_POINTS // points))))


class SweepStore:
    """An open store; made by `opened_store`."""

    def __init__(self, path: Path, sweep: Sweep) -> None:
        self._path, self._sweep = path, sweep
        self._design = sweep.design
        self._names = [each.name for each in sweep.quantities]
        self._rows = region_rows(self._design)
        self._reached = np.zeros(self._design.lines, dtype=np.int32)
        self._buffers: dict[int, dict[str, NDArray[Any]]] = {}
        kept = sweep.kept
        self._series = None if kept is None else series.SeriesStore(path, kept, self._design, self._rows)
        self._states: dict[int, bytes] = {}
        self._journal: int | None = None
        self.failed = 0

    @property
    def done(self) -> int:
        """Return how many points are done."""
        return int(self._reached.sum())

    def left(self) -> Iterator[Stretch]:
        """Go through what is not done: where to begin on each line."""
        for line in range(self._design.lines):
            first = int(self._reached[line])
            if first < self._design.length:
                yield Stretch(line, first, (), state=self._states.get(line))

    def begin(self) -> None:
        """Find what is done, by the journal, or by the store itself where that is gone; then go on with the journal."""
        path = self._path / JOURNAL
        with _writing(self._path):
            if path.exists():
                end = self._replayed(path)
            else:
                end = 0
                self._look()
            if self.done == self._design.points and not self._buffers:
                return
            self._journal = open_file(path, os.O_RDWR) if path.exists() else os.open(path, _NEW, 0o666)
            os.ftruncate(self._journal, end)
            os.lseek(self._journal, end, os.SEEK_SET)
            for region in sorted(self._buffers):
                self._write_complete(region)

    def _replayed(self, path: Path) -> int:
        """Do again what the journal tells; return where it ends, or where the line begins that was being written."""
        end = 0
        with open(path, "rb") as file:
            for line in file:
                entry = _entry(line)
                if entry is None:
                    break
                end += len(line)
                try:
                    self._replay(entry)
                except (ValueError, TypeError, KeyError, IndexError) as error:
                    raise OutputError(
                        f"{self._path}: its journal is not of this sweep; without {path.name} what the store itself "
                        "holds is gone on with"
                    ) from error
        for line in np.flatnonzero((self._reached > 0) & (self._reached < self._design.length)).tolist():
            if line not in self._states:  # a run that cannot go on from here begins anew
                self._reached[line] = 0
        return end

    def _look(self) -> None:
        """Find in the store which regions are done."""
        place = place_of(self._path)
        try:
            with quiet():
                failed = reader().open_zarr(place, chunks=None, consolidated=True, mask_and_scale=False)[FAILED].values
        except (ValueError, KeyError, RuntimeError) as error:
            raise OutputError(f"{self._path} is damaged: {why(error)}; expected a new name") from error
        first = self._design.across[0] if self._design.across else 0
        per_region = self._design.lines_per_row * self._rows
        whole = np.moveaxis(failed, first, 0) != _NOT_YET
        rows = self._rows if self._design.across else whole.shape[0]
        for region in range(-(-whole.shape[0] // rows)):
            if whole[region * rows : (region + 1) * rows].all():
                self._reached[region * per_region : (region + 1) * per_region] = self._design.length
        self.failed = int((failed == 1).sum())

    def take(self, done: Iterable[Done]) -> None:
        """Keep what is done; regions that are complete are written."""
        found = list(done)
        entry = [_plain(each) for each in found]
        with _writing(self._path):
            self._append({"done": entry})
            touched = {region for each in found for region in self._put(each)}
            for region in sorted(touched):
                self._write_complete(region)

    def flush(self) -> None:
        """Write regions that are not complete as well, for whoever reads the store meanwhile."""
        with _writing(self._path):
            for region in sorted(self._buffers):
                self._write(region)

    def close(self) -> None:
        """Close the journal, and remove it if all is done."""
        if self._journal is None:
            return
        os.close(self._journal)
        self._journal = None
        if self.done == self._design.points and not self._buffers:
            with _writing(self._path):
                (self._path / JOURNAL).unlink()

    def _append(self, entry: Mapping[str, Any]) -> None:
        """Append a line to the journal, or nothing."""
        assert self._journal is not None
        end = os.lseek(self._journal, 0, os.SEEK_CUR)
        text = json.dumps(entry, separators=(",", ":")).encode()
        try:
            write_all(self._journal, b"%08x %s\n" % (zlib.crc32(text), text))
        except OSError:
            os.ftruncate(self._journal, end)
            os.lseek(self._journal, end, os.SEEK_SET)
            raise

    def _write_complete(self, region: int) -> None:
        """Write a region if all its points are done, and note that it is written."""
        if self._is_complete(region):
            self._write(region)
            self._append({"region": region})
            self._drop(region)

    def _drop(self, region: int) -> None:
        """Forget a region that is written."""
        self._buffers.pop(region, None)
        if self._series is not None:
            self._series.drop(region)

    def _replay(self, entry: Mapping[str, Any]) -> None:
        """Do again what a line of the journal tells."""
        if "region" in entry:
            self._drop(int(entry["region"]))
        for each in entry.get("done", ()):
            self._put(_read(each))

    def _put(self, done: Done) -> set[int]:
        """Put numbers into the buffers; return the regions that they are in."""
        region = done.line // self._design.lines_per_row // self._rows
        buffer = self._buffers.setdefault(region, {}) or self._buffer(region)
        for place, numbers in enumerate(done.numbers):
            index = list(self._design.place(done.line, done.first + place))
            if self._design.across:
                index[self._design.across[0]] -= region * self._rows
            for name, number in zip(self._names, numbers, strict=True):
                buffer[name][tuple(index)] = number
            message = done.messages.get(place, "")
            buffer[MESSAGE][tuple(index)] = message[:_LONGEST_MESSAGE]
            self.failed += bool(message) and buffer[FAILED][tuple(index)] != 1
            buffer[FAILED][tuple(index)] = bool(message)
        if self._series is not None:
            for place, (content, message) in done.series.items():
                indices = self._design.place(done.line, done.first + place)
                self._series.put(region, indices, content, message[:_LONGEST_MESSAGE])
        self._reached[done.line] = done.first + len(done.numbers)
        self._states.pop(done.line, None)
        if done.state is not None:
            self._states[done.line] = done.state
        return {region}

    def _buffer(self, region: int) -> dict[str, NDArray[Any]]:
        """Make the memory of a region."""
        shape = list(self._design.shape)
        if self._design.across:
            first = self._design.across[0]
            shape[first] = min(self._rows, shape[first] - region * self._rows)
        buffer = self._buffers[region]
        buffer.update({name: np.full(shape, np.nan) for name in self._names})
        buffer[FAILED] = np.full(shape, _NOT_YET, dtype=np.int8)
        buffer[MESSAGE] = np.full(shape, "", dtype=object)
        return buffer

    def _is_complete(self, region: int) -> bool:
        """Tell whether all points of a region are done."""
        per_region = self._design.lines_per_row * self._rows
        lines = self._reached[region * per_region : (region + 1) * per_region]
        return bool((lines == self._design.length).all())

    def _write(self, region: int) -> None:
        """Write a region as far as it is done; last what tells that it is."""
        if self._series is not None:
            self._series.write(region)
        xarray = reader()
        buffer = self._buffers[region]
        names = [stored_name(axis.name) for axis in self._design.axes]
        where = {name: slice(None) for name in names}
        if self._design.across:
            first = self._design.across[0]
            begin = region * self._rows
            where[names[first]] = slice(begin, begin + buffer[FAILED].shape[first])
        whole = xarray.Dataset({stored_name(name): (names, values) for name, values in buffer.items()})
        with quiet():
            whole.to_zarr(place_of(self._path), region=where, mode="r+", consolidated=True)


def _plain(done: Done) -> list[Any]:
    """Return what is done as JSON can hold it."""
    state = None if done.state is None else base64.b64encode(done.state).decode()
    messages = {str(place): message for place, message in done.messages.items()}
    numbers = [[float(number) for number in each] for each in done.numbers]
    kept = {str(place): [base64.b64encode(rows).decode(), reason] for place, (rows, reason) in done.series.items()}
    return [done.line, done.first, numbers, messages, state, *([kept] if kept else [])]


def _read(entry: Sequence[Any]) -> Done:
    """Read back what `_plain` returned."""
    line, first, numbers, messages, state = entry[:5]
    content = None if state is None else base64.b64decode(state)
    kept: Mapping[str, tuple[str, str]] = entry[5] if len(entry) > 5 else {}
    found = {int(place): (base64.b64decode(rows), reason) for place, (rows, reason) in kept.items()}
    return Done(line, first, numbers, {int(place): message for place, message in messages.items()}, content, found)


def _entry(line: bytes) -> dict[str, Any] | None:
    """Read a line of the journal; None if it is not whole."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
        return None
    return cast(dict[str, Any], json.loads(text))


@contextmanager
def opened_store(path: Path, sweep: Sweep) -> Generator[SweepStore]:
    """Open a store, or begin one; it is held for this program alone meanwhile.

    Raises
    ------
    OutputError
        If it is there and is of another sweep or version, is no store, or cannot be written.
    """
    require_installed("xarray", "zarr", extra="stream", purpose="storing a sweep")
    if not path.exists():
        _create(path, sweep)
    elif not path.is_dir():
        raise OutputError(_FOREIGN.format(path))
    with locked(path) as free:
        if not free:
            raise OutputError(f"{path}: another program is at this sweep")
        _refuse_other(path, sweep)
        store = SweepStore(path, sweep)
        try:
            store.begin()
            yield store
        finally:
            store.close()


def _refuse_other(path: Path, sweep: Sweep) -> None:
    """Refuse what is not a store of this sweep."""
    try:
        attributes = json.loads((path / ".zattrs").read_text(encoding="utf-8"))
        stored = json.loads(attributes[RECORD])
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(_FOREIGN.format(path)) from None
    found = differing(sweep.record, stored)
    if found is not None:
        raise OutputError(f"{path} {found}; expected the same sweep to go on with, or a new name")


def _create(path: Path, sweep: Sweep) -> None:
    """Begin a store in which no point is done, whole or not at all."""
    draft = draft_of(path)
    try:
        if draft.exists():
            shutil.rmtree(draft)
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            begin_group(draft, "", _arrays(sweep), _attributes(sweep))
            if sweep.kept is not None:
                found = series.arrays(sweep.kept, sweep.design, region_rows(sweep.design))
                begin_group(draft, SERIES, found | _coordinates(sweep, sweep.kept.indices))
            consolidate(draft)
            (draft / JOURNAL).touch()
            os.rename(draft, path)
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            raise
    except OSError as error:
        if path.is_dir():  # another program was sooner, and is at this sweep or has done it
            return
        raise OutputError(f"{path} cannot be written: {why(error)}") from error


def _arrays(sweep: Sweep) -> dict[str, Array]:
    """Return what the store holds at first: what varies, and of each point that it is not done."""
    names = [axis.name for axis in sweep.design.axes]
    shape = sweep.design.shape
    chunks = list(shape)
    if sweep.design.across:
        chunks[sweep.design.across[0]] = region_rows(sweep.design)

    def array(dtype: type, fill: float | None, unit: str, text: str) -> Array:
        return Array(names, shape, dtype, tuple(chunks), fill, None, described(unit, text))

    return {
        **{each.name: array(np.float64, np.nan, each.unit, each.text) for each in sweep.quantities},
        FAILED: array(np.int8, _NOT_YET, "", "1 where there is a message instead of numbers"),
        MESSAGE: array(str, None, "", "why a point failed"),
        **_coordinates(sweep, [range(size) for size in shape]),
    }


def _coordinates(sweep: Sweep, indices: Sequence[Sequence[int]]) -> dict[str, Array]:
    """Return what varies, at some values of each axis."""
    return {
        name: coordinate(
            axis.name, [values[index] for index in kept], sweep.units.get(name, ""), sweep.texts.get(name, "")
        )
        for axis, kept in zip(sweep.design.axes, indices, strict=True)
        for name, values in axis.values.items()
    }


def _attributes(sweep: Sweep) -> dict[str, Any]:
    """Return what the store tells of the sweep: text, and JSON where that is not enough."""
    told = {**sweep.told, RECORD: sweep.record, "sha256": sweep.digest}
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in told.items()}


_SENTENCES = {
    "format": "is of another format",
    "product": "was begun by another version",
    "axes": "is over other values",
    "components": "is of other FMUs or parameters",
    "fmus": "is of other FMUs",
    "branch": "is of another branch",
    SERIES: "keeps other series",
}


def differing(record: Mapping[str, Any], stored: Mapping[str, Any]) -> str | None:
    """Say in what a stored record differs from that of a sweep; None if they are the same."""
    for name, wanted in record.items():
        if stored.get(name) == wanted:
            continue
        if name == "axes" and set(stored.get(name) or ()) == set(wanted):
            bad = [axis for axis in wanted if wanted[axis] != stored[name][axis]]
            return f"has other values of {', '.join('the samples' if each == SAMPLES else each for each in bad)}"
        if name in ("format", "product", "branch"):
            return f"{_SENTENCES[name]} ({stored.get(name)}, not {wanted})"
        return _SENTENCES.get(name, f"has {'other' if name[-1] == 's' else 'another'} {name.replace('_', ' ')}")
    return _SENTENCES[SERIES] if SERIES in stored and SERIES not in record else None


@contextmanager
def _writing(path: Path) -> Generator[None]:
    """Say what could not be written; what was before is there, and the sweep can be gone on with."""
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written: {why(error)}; what is done is in it, go on with the same command"
        ) from error
