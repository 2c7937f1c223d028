"""Hold commands to what there is: subcommands and options of `cosim`, targets of make, modules, files of the checkout.

It looks at what is run and what is not, at commands within prose, and at synopses such as `cosim check FILE.fmu
[--junit FILE]`.
"""

from __future__ import annotations

import importlib.util
import pkgutil
import re
import shlex
import shutil
import sys
import tomllib
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path, PureWindowsPath
from typing import Any

import typer
import yaml
from typer.core import TyperGroup

from cosim.cli.app import app
from fmu_src.build.command import app as build_app
from tests.docs.pages import ROOT, Block, Page, PageError

OTHERS = {"OMSimulatorPython3", "apt-get", "basedpyright", "dask", "driver", "fmpy", "fmutool", "pre-commit", "ruff"}
"""Programs that are not ours."""

SHELL = {"cat", "cd", "cp", "diff", "echo", "git", "head", "ls", "mkdir", "mv", "patch", "rm", "sed", "tail", "true"}
OF_PIP = {"--require-hashes", "--no-deps", "--no-build-isolation"}
CHECKOUT = ("dist/", "requirements/", "docs/", "tests/", ".venv/bin/", "fmu_src/", "models/", "cosim/")
"""What begins so is a file of a checkout in which the FMUs have been built."""


@cache
def command_tree() -> dict[str, Any]:
    """Return the commands of `cosim` by name, and itself by none; `build` has the options of `build_fmu.py`."""
    group = typer.main.get_command(app)
    assert isinstance(group, TyperGroup)
    return {"": group, **group.commands, "build": typer.main.get_command(build_app)}


@cache
def targets() -> frozenset[str]:
    """Return the targets of the Makefile."""
    return frozenset(re.findall(r"(?m)^([a-z][a-z-]*):", (ROOT / "Makefile").read_text(encoding="utf-8")))


def options_of(command: Any) -> set[str]:
    """Return the options of a command of typer, with their dashes."""
    names = {name for each in command.params for name in (*each.opts, *each.secondary_opts)}
    return {name for name in names if name.startswith("-")}


def wrong_on(page: Page) -> list[str]:
    """Return what a page names that does not exist, each with its line."""
    found: list[str] = []
    for block in page.blocks:
        found += [str(block.error(wrong)) for line in commands_of(block) for wrong in wrong_in(line)]
    for line, code in page.inline:
        found += [str(PageError(page.path, line, wrong)) for wrong in wrong_inline(code)]
    return found


def commands_of(block: Block) -> Iterator[str]:
    """Yield the commands of a block, those of the steps of a workflow among them."""
    if block.language in {"sh", "bat"}:
        yield from re.sub(r"\\\n", " ", block.content).splitlines()
    elif block.language == "text":
        yield from re.findall(r"(?m)^\$ (.*)$", block.content)
    elif block.language == "yaml":
        yield from _steps(yaml.safe_load(block.content))


def _steps(node: object) -> Iterator[str]:
    if isinstance(node, dict):
        for key, value in node.items():
            yield from value.splitlines() if key == "run" and isinstance(value, str) else _steps(value)
    elif isinstance(node, list):
        for each in node:
            yield from _steps(each)


def wrong_inline(code: str) -> list[str]:
    """Examine code within prose: a command, options by themselves, a module or a name in it, a file."""
    if re.match(r"(cosim|make|python|pip) ", code):
        return wrong_in(code)
    if code.startswith("--"):
        known = (OF_PIP | {"--help"}).union(*(options_of(command) for command in command_tree().values()))
        names = [word.partition("=")[0] for word in code.split() if word.startswith("--")]
        return [f"no command has the option {name}" for name in names if name not in known]
    if re.fullmatch(r"(?:cosim|models|fmu_src|tests)(?:\.[a-z]\w*)+(?:\(\))?", code):
        return [] if _can_be_imported(code.removesuffix("()")) else [f"no {code} in the product"]
    is_file = re.fullmatch(r"[\w./-]+\.(?:py|md|toml|txt|yml|c|h|js)", code)
    return [f"no {code} in the checkout"] if is_file and not _is_there(code) else []


def _can_be_imported(name: str) -> bool:
    """Return whether a dotted name is a module, or what is found in one."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def wrong_in(line: str) -> list[str]:
    """Examine a line of shell; return what in it does not exist."""
    # brackets are of synopses, `cosim[report]` is no bracket of them
    line = re.sub(r"(?<= )\[|\](?= |$)", "", line)
    lexer = shlex.shlex(line, posix="\\Scripts\\" not in line, punctuation_chars="&|;")
    lexer.whitespace_split = True
    found: list[str] = []
    command: list[str] = []
    for token in [*lexer, ";"]:
        if set(token) <= set("&|;"):
            found += _wrong_in_command(command)
            command = []
        elif command or not re.match(r"\w+=", token):
            command.append(token)
    return found


def _wrong_in_command(tokens: Sequence[str]) -> list[str]:
    if not tokens:
        return []
    program = PureWindowsPath(tokens[0]).name
    rest = [token for token in tokens[1:] if token != "..."]
    missing = [f"no {token} in the checkout" for token in tokens if not _is_there(token)]
    match program:
        case "cosim":
            return missing + _wrong_cosim(rest)
        case "make":
            return missing + _wrong_make(rest)
        case "python" | "python3" | "py":
            return missing + _wrong_python(rest)
        case "pip":
            return missing + _wrong_extras(rest)
        case _:
            known = program in OTHERS | SHELL
            return missing + ([] if known else [f"a program {program!r}, of which tests/docs knows nothing"])


def _wrong_cosim(tokens: Sequence[str]) -> list[str]:
    name = tokens[0] if tokens and not tokens[0].startswith("-") else ""
    command = command_tree().get(name)
    if command is None:
        return [f"no command `cosim {name}`"]
    return _wrong_options(f"cosim {name}".strip(), command, tokens)


def _wrong_options(name: str, command: Any, tokens: Sequence[str]) -> list[str]:
    known = {"--help", *options_of(command)}
    asked = [token.partition("=")[0] for token in tokens if token.startswith("--")]
    return [f"`{name}` has no option {option}" for option in asked if option not in known]


def _wrong_make(tokens: Sequence[str]) -> list[str]:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    found = [f"no target {token!r} in the Makefile" for token in tokens if "=" not in token and token not in targets()]
    variables = [token.partition("=")[0] for token in tokens if "=" in token]
    return found + [f"the Makefile asks no variable {name}" for name in variables if f"$({name})" not in makefile]


def _wrong_python(tokens: Sequence[str]) -> list[str]:
    match tokens:
        case ["-m", "pip", *rest]:
            return _wrong_extras(rest)
        case ["-m", module, *_]:
            return [] if _has(module) else [f"no module {module}"]
        case ["build_fmu.py", *rest]:
            return _wrong_options("build_fmu.py", command_tree()["build"], rest)
        case _:
            return []


def _has(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def _wrong_extras(tokens: Sequence[str]) -> list[str]:
    """Examine what pip is asked for: extras of this project."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = [name for token in tokens for name in re.findall(r"(?:drillstring-cosim|\.)\[(.+)\]", token)]
    extras = [extra.strip() for names in asked for extra in names.split(",")]
    return [f"no extra {extra!r}" for extra in extras if extra not in project["optional-dependencies"]]


def _is_there(token: str) -> bool:
    """Return whether a file is there, if it is one of the checkout's."""
    if not token.startswith(CHECKOUT) or re.search(r"[*<>{$]", token):
        return True
    if token.startswith(".venv/bin/"):
        return shutil.which(Path(token).name, path=Path(sys.executable).parent) is not None
    if token.startswith("dist/"):
        return not token.endswith(".fmu") or (ROOT / "fmu_src" / "fmus" / Path(token).stem).is_dir()
    return (ROOT / token).exists()
