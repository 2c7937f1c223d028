"""Archives that nobody makes by accident, written byte by byte where a zip writer would refuse."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable, Mapping

Entry = tuple[str | zipfile.ZipInfo, bytes]
Spoil = Callable[[zipfile.ZipInfo], None]

LOCAL, CENTRAL, END = b"PK\x03\x04", b"PK\x01\x02", b"PK\x05\x06"


def pack(members: Mapping[str, bytes], *more: Entry, compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return an archive of honest members and others after them."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, content in (*members.items(), *more):
            archive.writestr(name, content)
    return buffer.getvalue()


def named(name: str) -> zipfile.ZipInfo:
    """Return an entry whose name is written as it is; the constructor of ZipInfo would cut it at a NUL."""
    entry = zipfile.ZipInfo("x")
    entry.filename = name
    return entry


def of_kind(name: str, mode: int) -> zipfile.ZipInfo:
    """Return an entry of a Unix file type, such as stat.S_IFLNK."""
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, (mode | 0o777) << 16
    return entry


def in_directory(archive: bytes, name: str, offset: int, layout: str, value: int) -> bytes:
    """Return an archive with a number changed in one entry of its directory (APPNOTE.TXT, section 4.3.12)."""
    at = -1
    while (at := archive.index(CENTRAL, at + 1)) >= 0:
        length = struct.unpack_from("<H", archive, at + 28)[0]
        if archive[at + 46 : at + 46 + length] == name.encode():
            break
    changed = bytearray(archive)
    struct.pack_into(layout, changed, at + offset, value)
    return bytes(changed)


def encrypted(archive: bytes, name: str) -> bytes:
    return in_directory(archive, name, 8, "<H", 1)


def with_crc(archive: bytes, name: str, crc: int) -> bytes:
    return in_directory(archive, name, 16, "<I", crc)


def with_size(archive: bytes, name: str, size: int) -> bytes:
    """Lie about the unpacked size."""
    return in_directory(archive, name, 24, "<I", size)


def with_offset(archive: bytes, name: str, offset: int) -> bytes:
    """Lie about where a member begins."""
    return in_directory(archive, name, 42, "<I", offset)


def overlapping(members: Mapping[str, bytes], kernel: bytes, count: int) -> bytes:
    """Let many entries of the directory share one piece of compressed data, as a better zip bomb does."""
    names = {f"resources/{index:05}": b"" for index in range(count)}
    archive = pack(members, ("resources/kernel", kernel), *names.items())
    at = archive.index(b"resources/kernel") - 30
    crc, packed, size = struct.unpack_from("<III", archive, at + 14)
    for name in names:
        for offset, value in ((16, crc), (20, packed), (24, size), (42, at)):
            archive = in_directory(archive, name, offset, "<I", value)
        archive = in_directory(archive, name, 10, "<H", zipfile.ZIP_DEFLATED)
    return archive


def with_unicode_name(name: str, other: str) -> zipfile.ZipInfo:
    """Return an entry with another name in the extra field 0x7075, which newer readers take instead (section 4.6.9)."""
    content = struct.pack("<BI", 1, zipfile.crc32(name.encode())) + other.encode()
    entry = zipfile.ZipInfo(name)
    entry.extra = struct.pack("<HH", 0x7075, len(content)) + content
    return entry


def with_zip64_size(name: str, size: int) -> Callable[[bytes], bytes]:
    """Return what puts a size of 64 bits into an archive that has been packed with `zip64_entry` (section 4.5.3)."""

    def change(archive: bytes) -> bytes:
        field = struct.pack("<HH", 0x6464, 16) + b"\0" * 16
        at = archive.rindex(field)
        extra = struct.pack("<HHQQ", 0x0001, 16, size, size)
        changed = archive[:at] + extra + archive[at + len(extra) :]
        changed = in_directory(changed, name, 20, "<I", 0xFFFFFFFF)
        return in_directory(changed, name, 24, "<I", 0xFFFFFFFF)

    return change


def zip64_entry(name: str) -> zipfile.ZipInfo:
    """Return an entry with room for sizes of 64 bits."""
    entry = zipfile.ZipInfo(name)
    entry.extra = struct.pack("<HH", 0x6464, 16) + b"\0" * 16
    return entry
