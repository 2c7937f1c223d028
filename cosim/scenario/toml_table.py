"""A table of a TOML file that knows where it stands, so that every complaint names the key."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, cast

from cosim.errors import ScenarioError, suggestion


class TomlTable:
    """A table whose keys are taken one by one, each with the type it must have.

    Parameters
    ----------
    content : object
        What the TOML reader returned.
    where : str
        Path of keys that leads to it, empty for the whole file.
    known : collection of str, optional
        The keys it may have; by default any.

    Raises
    ------
    ScenarioError
        If it is no table or has another key.
    """

    def __init__(self, content: object, where: str, known: Collection[str] | None = None) -> None:
        if not isinstance(content, dict):
            raise ScenarioError(f"{where} is {content!r}; expected a table")
        self.where = where
        self._content = cast(dict[str, Any], content)
        for key in self._content:
            if known is not None and key not in known:
                raise ScenarioError(f"unknown key '{self.path(key)}'{suggestion(key, known)}")

    def path(self, key: str) -> str:
        """Return the full path of a key."""
        return f"{self.where}.{key}" if self.where else key

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def items(self) -> Iterator[tuple[str, object]]:
        """Go through keys and values, as they are."""
        yield from self._content.items()

    def text(self, key: str, default: str | None = None) -> str:
        """Take a string."""
        value = self._get(key, default)
        if not isinstance(value, str):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a string")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Take a number."""
        value = self._get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number")
        return float(value)

    def boolean(self, key: str, *, default: bool) -> bool:
        """Take a Boolean."""
        value = self._get(key, default)
        if not isinstance(value, bool):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected true or false")
        return value

    def number_or_boolean(self, key: str) -> float | int | bool:
        """Take a number or a Boolean, as it is."""
        value = self._get(key, None)
        if not isinstance(value, int | float):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected a number, true or false")
        return value

    def array(self, key: str) -> list[object]:
        """Take an array; none is an empty one."""
        value = self._content.get(key, [])
        if not isinstance(value, list):
            raise ScenarioError(f"{self.path(key)} is {value!r}; expected an array")
        return cast(list[object], value)

    def texts(self, key: str) -> tuple[str, ...]:
        """Take an array of strings; none is an empty one."""
        values = self.array(key)
        for value in values:
            if not isinstance(value, str):
                raise ScenarioError(f"{self.path(key)} holds {value!r}; expected strings")
        return tuple(map(str, values))

    def table(self, key: str, known: Collection[str] | None = None) -> TomlTable:
        """Take a table; none is an empty one."""
        return TomlTable(self._content.get(key, {}), self.path(key), known)

    def variables(self, key: str) -> TomlTable:
        """Take a table by ``component.variable``; ``plant.WOB = 1`` means the same as ``"plant.WOB" = 1``."""
        flat: dict[str, Any] = {}
        for name, value in self.table(key).items():
            if "." in name or not isinstance(value, dict):
                flat[name] = value
            else:
                inner = cast(dict[str, object], value)
                flat.update({f"{name}.{variable}": content for variable, content in inner.items()})
        return TomlTable(flat, self.path(key))

    def _get(self, key: str, default: object) -> object:
        """Take a value of any type, which must be there if there is no default."""
        if key not in self._content and default is None:
            raise ScenarioError(f"'{self.path(key)}' is missing")
        return self._content.get(key, default)
