"""Which processor and system a library is for: what its folder promises, and what its first bytes say."""

from __future__ import annotations

import struct

_TUPLES = {
    "linux32": "x86-linux",
    "linux64": "x86_64-linux",
    "win32": "x86-windows",
    "win64": "x86_64-windows",
    "darwin64": "x86_64-darwin",
}
"""FMI 2.0's names; those of FMI 3.0, which tools use for Arm, are what they say."""

_ELF = {0x03: "x86-linux", 0x3E: "x86_64-linux", 0xB7: "aarch64-linux", 0x28: "aarch32-linux", 0xF3: "riscv64-linux"}
_PE = {0x14C: "x86-windows", 0x8664: "x86_64-windows", 0xAA64: "aarch64-windows"}
_MACH = {0x01000007: "x86_64-darwin", 0x0100000C: "aarch64-darwin", 7: "x86-darwin"}


def expected_for(folder: str) -> set[str]:
    """Return the platform that a folder below binaries stands for; empty if the name is unknown."""
    name = _TUPLES.get(folder, folder)
    return {name} if name in {*_ELF.values(), *_PE.values(), *_MACH.values()} else set()


def built_for(library: bytes) -> set[str]:
    """Return the platforms a library can be loaded on, by its header; empty if it is none that is known.

    ELF (e_machine), PE (Machine) and Mach-O (cputype), and universal Mach-O with several of them.
    """
    try:
        if library[:4] == b"\x7fELF":
            return _known(_ELF, struct.unpack_from("<H", library, 18)[0])
        if library[:2] == b"MZ":
            start = struct.unpack_from("<I", library, 60)[0]
            return _known(_PE, struct.unpack_from("<H", library, start + 4)[0])
        if library[:4] == b"\xcf\xfa\xed\xfe":
            return _known(_MACH, struct.unpack_from("<I", library, 4)[0])
        if library[:4] == b"\xca\xfe\xba\xbe":
            count = struct.unpack_from(">I", library, 4)[0]
            parts = (struct.unpack_from(">I", library, 8 + 20 * index)[0] for index in range(count))
            return set[str]().union(*(_known(_MACH, part) for part in parts))
    except struct.error:
        return set()
    return set()


def is_cut_off(library: bytes) -> bool:
    """Whether an ELF file ends before its segments do, which kills a process that loads it (by SIGBUS).

    Other formats are checked by the loaders of their systems. Layout by the System V ABI, chapter "Program Header".
    """
    if library[:4] != b"\x7fELF":
        return False
    header, segment = ("<32xQ14xHH", "<8xQ16xQ") if library[4:5] == b"\x02" else ("<28xI10xHH", "<4xI8xI")
    try:
        table, size, count = struct.unpack_from(header, library)
        segments = [struct.unpack_from(segment, library, table + index * size) for index in range(count)]
    except struct.error:
        return True
    return any(begin + length > len(library) for begin, length in segments)


def _known(machines: dict[int, str], number: int) -> set[str]:
    return {machines[number]} if number in machines else {f"machine 0x{number:x}"}
