"""Open .fmu and .ssp files, here alone: nothing in them is trusted, and nothing leaves the given folder.

Everything that can be known from the directory of the archive is checked when it is opened; contents are checked as
they are read, and a member's name is one that may become a file on any system. What is refused, and why, is in
docs/untrusted.md.

Archives to give away are written here as well: they depend on nothing but names and contents, and are in place once
they are complete.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import stat
import struct
import sys
import unicodedata
import zipfile
import zlib
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from cosim.errors import FmuFileError, InputError, OutputError
from cosim.files import open_file, replace_file, why

MOST_MEMBERS = 20_000
MOST_BYTES = 4 * 2**30
"""All members together, unpacked."""

MOST_RATIO = 200
FREE_RATIO_BYTES = 16 * 2**20
"""An archive that stays below this size may be compressed to any degree."""

MOST_IN_MEMORY = 128 * 2**20
"""A member that is read rather than unpacked, such as a description."""

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 0x1
_KINDS = {
    stat.S_IFLNK: "a symbolic link",
    stat.S_IFCHR: "a character device",
    stat.S_IFBLK: "a block device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}
_LOCAL_HEADER = struct.Struct("<4s22xHH")
_LOCAL_SIGNATURE = b"PK\x03\x04"
_CHUNK = 2**20

# What the zip reader of the standard library raises on damaged files, beside what it means to raise.
_DAMAGE = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, struct.error, OSError, EOFError, ValueError, OverflowError,
    NotImplementedError, RuntimeError, IndexError,
)  # fmt: skip


class Archive:
    """An archive whose directory has been checked; made by `open_archive`.

    Parameters
    ----------
    path : Path
        The file, for messages.
    file : zipfile.ZipFile
        Open for reading.
    refusal : type of InputError
        What to raise.
    """

    def __init__(self, path: Path, file: zipfile.ZipFile, refusal: type[InputError]) -> None:
        self.path = path
        self._file = file
        self._refusal = refusal
        self._members = {name: entry for entry in file.infolist() if (name := _place(entry.filename))}

    @property
    def flaws(self) -> tuple[str, ...]:
        """Say which names of members are not plain, or fine on this system and cannot be files on another."""
        dotted = [entry.filename for entry in self._file.infolist() if "." in entry.filename.split("/")]
        names = [f"the name of the member {name!r} {_ENDS_BADLY}" for name in self._members if _ends_badly(name)]
        more = f", and those of {len(dotted) - 1} more," if len(dotted) > 1 else ""
        return (*names, *(f"the name of the member {name!r}{more} {_DOTTED}" for name in dotted[:1]))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the members, in their order; those of folders end in a slash."""
        return tuple(self._members)

    def read(self, name: str) -> bytes:
        """Return the content of a member.

        Raises
        ------
        InputError
            Of the type the archive was opened with, if there is no such member, it is damaged, or it is larger than
            `MOST_IN_MEMORY`.
        """
        entry = self._member(name)
        if entry.file_size > MOST_IN_MEMORY:
            sizes = f"{_megabytes(entry.file_size)} unpacked; expected at most {_megabytes(MOST_IN_MEMORY)}"
            raise self._refusal(f"{self.path}: {name} has {sizes}")
        return b"".join(self._chunks(entry))

    def copy(self, name: str, target: Path) -> None:
        """Write one member to a file of another name, of any size.

        Raises
        ------
        InputError
            As by `unpack`, and if there is no such member.
        """
        entry = self._member(name)
        self._refuse_lack_of_space(entry.file_size, target.parent)
        self._write(entry, target)

    def unpack(self, folder: Path) -> None:
        """Write all members below an existing, empty folder.

        Raises
        ------
        InputError
            Of the type the archive was opened with, if a member is damaged or the folder cannot be written to.
        """
        self._refuse_lack_of_space(sum(entry.file_size for entry in self._members.values()), folder)
        for name, entry in self._members.items():
            self._write(entry, folder.joinpath(*name.split("/")))

    def _member(self, name: str) -> zipfile.ZipInfo:
        if name not in self._members:
            raise self._refusal(f"{self.path}: there is no {name} in it")
        return self._members[name]

    def _refuse_lack_of_space(self, needed: int, folder: Path) -> None:
        free = shutil.disk_usage(folder).free
        if needed > free:
            raise self._refusal(f"{self.path}: needs {_megabytes(needed)} in {folder}; {_megabytes(free)} are free")

    def _write(self, entry: zipfile.ZipInfo, target: Path) -> None:
        try:
            if entry.is_dir():
                target.mkdir(parents=True, exist_ok=True)
                return
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("xb") as out:
                for chunk in self._chunks(entry):
                    out.write(chunk)
        except OSError as error:
            raise self._refusal(f"{self.path}: cannot be unpacked to {target}: {error.strerror or error}") from error

    def _chunks(self, entry: zipfile.ZipInfo) -> Generator[bytes]:
        """Read a member piece by piece, never more than its declared size, and check its CRC at the end."""
        read = 0
        try:
            with self._file.open(entry) as content:
                while chunk := content.read(_CHUNK):
                    read += len(chunk)
                    yield chunk
        except _DAMAGE as error:
            raise self._refusal(f"{self.path}: {entry.filename} is damaged: {error}") from error
        if read != entry.file_size:
            sizes = f"it has {read} bytes; declared are {entry.file_size}"
            raise self._refusal(f"{self.path}: {entry.filename} is damaged: {sizes}")


@contextmanager
def open_archive(path: Path, kind: str = "an FMU", refusal: type[InputError] = FmuFileError) -> Generator[Archive]:
    """Open an .fmu or .ssp file and check its directory.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it is meant to be, for messages.
    refusal : type of InputError
        What to raise, here and by what is yielded.

    Yields
    ------
    Archive
        To read and unpack.

    Raises
    ------
    InputError
        Of that type, if the file is missing, is not a zip archive, or holds what must not be unpacked.
    """
    with ExitStack() as stack:
        try:
            handle = stack.enter_context(os.fdopen(open_file(path, os.O_RDONLY, follow=True), "rb"))
            _refuse_long_directory(path, handle, refusal)
            file = zipfile.ZipFile(handle)
        except FileNotFoundError:
            raise refusal(f"{path}: there is no such file") from None
        except OSError as error:
            raise refusal(f"{path}: cannot be read: {why(error)}") from error
        except zipfile.BadZipFile:
            raise refusal(f"{path} is not {kind}: it is not a zip archive") from None
        except _DAMAGE as error:
            raise refusal(f"{path} is not {kind}: the directory of the archive is damaged: {error}") from error
        stack.enter_context(file)
        fault = _fault(file)
        if fault is not None:
            raise refusal(f"{path}: {fault}")
        yield Archive(path, file, refusal)


_END, _END64, _LOCATOR64 = (struct.Struct(form) for form in ("<4s4H2LH", "<4sQ2H2L4Q", "<4sLQL"))
_ENTRY = struct.Struct("<4s24x3H12x")
_MOST_DIRECTORY = 2**25
"""Bytes in the directory of an archive; one of as many members as there may be has a tenth of that."""


def _refuse_long_directory(path: Path, file: BinaryIO, refusal: type[InputError]) -> None:
    """Refuse an archive of too many members before the reader makes an object of each.

    The directory is looked for where the reader of the standard library looks for it, and walked through in its bytes.
    """
    begin, size = _directory(file)
    if size > _MOST_DIRECTORY:
        raise refusal(f"{path}: its directory has {_megabytes(size)}; expected at most {_megabytes(_MOST_DIRECTORY)}")
    if size <= MOST_MEMBERS * _ENTRY.size:
        return
    file.seek(begin)
    content, place, members = file.read(size), 0, 0
    while place + _ENTRY.size <= len(content):
        _, name, extra, comment = _ENTRY.unpack_from(content, place)
        place += _ENTRY.size + name + extra + comment
        members += 1
    if members > MOST_MEMBERS:
        raise refusal(f"{path}: {_too_many(members)}")


def _directory(file: BinaryIO) -> tuple[int, int]:
    """Return where the directory of an archive begins, and its size; (0, 0) where there is none to be found."""
    whole = file.seek(0, os.SEEK_END)
    tail_begin = max(0, whole - 2**16 - _END.size)
    file.seek(tail_begin)
    tail = file.read()
    place = len(tail) - _END.size
    if place < 0 or tail[place : place + 4] != b"PK\5\6" or tail[-2:] != b"\0\0":
        place = tail.rfind(b"PK\5\6")
    if place < 0 or place + _END.size > len(tail):
        return 0, 0
    size, end = int(_END.unpack_from(tail, place)[5]), tail_begin + place
    if place >= _LOCATOR64.size + _END64.size:
        at = place - _LOCATOR64.size
        if tail[at : at + 4] == b"PK\6\7" and tail[at - _END64.size : at - _END64.size + 4] == b"PK\6\6":
            size, end = int(_END64.unpack_from(tail, at - _END64.size)[8]), end - _LOCATOR64.size - _END64.size
    return max(0, end - size), size


def _fault(file: zipfile.ZipFile) -> str | None:
    """Say what is wrong with an archive as a whole."""
    entries = file.infolist()
    if len(entries) > MOST_MEMBERS:
        return _too_many(len(entries))
    faults = (_fault_of_member(entry) for entry in entries)
    collision = colliding_names([_place(entry.filename) for entry in entries])
    return (
        next((fault for fault in faults if fault is not None), None)
        or (f"the members {collision[0]!r} and {collision[1]!r} claim the same place" if collision else None)
        or _fault_of_sizes(entries)
        or _overlap(file, entries)
    )


def _too_many(members: int) -> str:
    """Say that there are too many members."""
    return f"it has {members} members; expected at most {MOST_MEMBERS}"


def _fault_of_member(entry: zipfile.ZipInfo) -> str | None:
    """Say what is wrong with one entry of the directory.

    Its name is looked at as it is in the file, before the reader cuts it at a NUL or takes another from an extra field,
    and after.
    """
    kind = stat.S_IFMT(entry.external_attr >> 16)
    for name in (entry.orig_filename, entry.filename):
        fault = fault_of_name(name)
        if fault is not None:
            return f"the name of the member {name[:100]!r} {fault}"
    name = entry.filename
    if kind in _KINDS:
        return f"the member {name} is {_KINDS[kind]}; expected files and folders only"
    if entry.flag_bits & _ENCRYPTED:
        return f"the member {name} is encrypted"
    if entry.compress_type not in _METHODS:
        return f"the member {name} is compressed by method {entry.compress_type}; expected {_METHODS[1]}, deflate"
    return None


def _fault_of_sizes(entries: list[zipfile.ZipInfo]) -> str | None:
    """Say whether the archive would become too large, or larger than honest contents do."""
    unpacked, packed = sum(entry.file_size for entry in entries), sum(entry.compress_size for entry in entries)
    if unpacked > MOST_BYTES:
        return f"it has {_megabytes(unpacked)} unpacked; expected at most {_megabytes(MOST_BYTES)}"
    if unpacked > FREE_RATIO_BYTES and unpacked > MOST_RATIO * packed:
        ratio = f"{unpacked / max(packed, 1):.0f} times its size"
        return f"it unpacks to {_megabytes(unpacked)}, {ratio}; expected at most {MOST_RATIO} times"
    return None


def _overlap(file: zipfile.ZipFile, entries: list[zipfile.ZipInfo]) -> str | None:
    """Say which members share bytes, as in a bomb that reuses one piece of compressed data for all of them.

    See D. Fifield, "A better zip bomb", WOOT 2019.
    """
    begins = sorted((entry.header_offset, entry.orig_filename, entry.compress_size) for entry in entries)
    if begins and begins[0][0] < 0:
        return "it is damaged: its beginning is missing"
    limit, owner = 0, ""
    try:
        for begin, name, size in begins:
            if begin < limit:
                return f"the members {owner} and {name} overlap"
            limit, owner = _end_of_member(file, begin) + size, name
    except _DAMAGE as error:
        return f"it is damaged: {error}"
    return f"the member {owner} overlaps the directory of the archive" if limit > file.start_dir else None


def _end_of_member(file: zipfile.ZipFile, begin: int) -> int:
    """Return where the header at the beginning of a member ends and its data begin."""
    if file.fp is None:
        raise zipfile.BadZipFile("it has been closed")
    file.fp.seek(begin)
    signature, name, extra = _LOCAL_HEADER.unpack(file.fp.read(_LOCAL_HEADER.size))
    if signature != _LOCAL_SIGNATURE:
        raise zipfile.BadZipFile(f"there is no member at byte {begin}")
    return begin + _LOCAL_HEADER.size + name + extra


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


LONGEST_NAME = 1000
"""Characters in the whole path of a member."""

# What Windows takes for a device in whatever folder and with whatever extension
# (https://learn.microsoft.com/windows/win32/fileio/naming-a-file).
_ENDS_BADLY = "has a part that ends in a dot or a space"
_DOTTED = "has a part that is a dot"
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE)


def fault_of_name(name: str) -> str | None:
    """Say what is wrong with the name of a member, or return None if it may be unpacked under it.

    The same names are refused on every system, but for the dots and spaces at their ends that Windows would drop: there
    are exporters that write such names, and elsewhere they are as good as any. Parts are separated by forward slashes
    (APPNOTE.TXT of the zip format, section 4.4.17); one at the end makes it a folder.
    """
    parts = name.removesuffix("/").split("/")
    faults = {
        "is empty": not name,
        f"has {len(name)} characters; expected at most {LONGEST_NAME}": len(name) > LONGEST_NAME,
        "has a control character in it": any(unicodedata.category(character) == "Cc" for character in name),
        "has a backslash in it": "\\" in name,
        "is an absolute path": name.startswith("/"),
        "has a colon in it, as a drive has": ":" in name,
        "leads out of the archive": ".." in parts,
        "has an empty part": "" in parts,
        _ENDS_BADLY: sys.platform == "win32" and _ends_badly(name),
        "is a device on Windows": any(_DEVICE.fullmatch(part) for part in parts),
    }
    return next((fault for fault, found in faults.items() if found), None)


def _ends_badly(name: str) -> bool:
    """Tell whether Windows would make a file of another name; a part that is one dot is the folder itself."""
    parts = name.removesuffix("/").split("/")
    return any(part.endswith((".", " ")) for part in parts if part != ".")


def _place(name: str) -> str:
    """Return where a member is unpacked: its name without parts that are one dot, which lead nowhere."""
    return "/".join(part for part in name.split("/") if part != ".")


def colliding_names(names: Sequence[str]) -> tuple[str, str] | None:
    """Return two members that claim one place: equal names, or a file where another member needs a folder.

    Names that differ only in case, or in how accents are put together, are equal on the usual file systems of Windows
    and macOS.
    """
    seen: dict[str, str] = {}
    for name in names:
        folded = _folded(name)
        if folded in seen:
            return seen[folded], name
        seen[folded] = name
    for name in names:
        parts = _folded(name).split("/")
        for length in range(1, len(parts)):
            above = seen.get("/".join(parts[:length]))
            if above is not None and not above.endswith("/"):
                return above, name
    return None


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name.removesuffix("/")).casefold()


_EPOCH = (1980, 1, 1, 0, 0, 0)


def pack(files: Mapping[str, bytes], first: str) -> bytes:
    """Return a zip archive; stored, since compressors differ in the bytes they make.

    Parameters
    ----------
    files : mapping of str to bytes
        Contents by name.
    first : str
        The one to begin with, the description.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as out:
        for name in sorted(files, key=lambda name: (name != first, name)):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 3  # Unix, on every host, so that the permissions below count
            entry.external_attr = 0o100644 << 16
            out.writestr(entry, files[name])
    return buffer.getvalue()


def put_in_place(path: Path, content: bytes) -> None:
    """Write a file, which appears when it is complete; folders above it are made.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, content)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error
