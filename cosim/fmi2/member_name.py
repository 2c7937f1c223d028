"""Names of members of an archive: which may become files, whatever system the archive is unpacked on."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

LONGEST_NAME = 1000
"""Characters in the whole path of a member."""

# What Windows takes for a device in whatever folder and with whatever extension
# (https://learn.microsoft.com/windows/win32/fileio/naming-a-file).
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE)


def fault_of_name(name: str) -> str | None:
    """Say what is wrong with the name of a member, or return None if it may be unpacked under it.

    The same names are refused on every system, so that an archive that opens on one opens on all of them. Parts are
    separated by forward slashes (APPNOTE.TXT of the zip format, section 4.4.17); one at the end makes it a folder.
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
        "has a part that ends in a dot or a space": any(part.endswith((".", " ")) for part in parts),
        "is a device on Windows": any(_DEVICE.fullmatch(part) for part in parts),
    }
    return next((fault for fault, found in faults.items() if found), None)


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
