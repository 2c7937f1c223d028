"""What runs the pages finds what is wrong on them, and says on which page and line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.docs.commands import wrong_on
from tests.docs.expected import differences
from tests.docs.formats import unaccounted
from tests.docs.pages import Page, PageError, all_pages, read_page
from tests.docs.session import Session

on_unix = pytest.mark.skipif(sys.platform == "win32", reason="pages speak to the shell of Unix")


def page(folder: Path, text: str) -> Page:
    """Write a page; tildes stand for the backticks that begin and end its blocks."""
    path = folder / "page.md"
    path.write_text(text.replace("~~~", "```"), encoding="utf-8")
    return read_page(path)


def run(folder: Path, text: str) -> None:
    made = page(folder, text)
    (folder / "session").mkdir(exist_ok=True)
    assert unaccounted(made) == []
    with Session(made, folder / "session") as session:
        session.run()


def refused(folder: Path, text: str) -> str:
    with pytest.raises(PageError) as caught:
        run(folder, text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("block", "reason"),
    [
        ("~~~\n1 2\n~~~", "a block without a language"),
        ("    1 2\n", "a block without a language"),
        ("~~~fortran\nend\n~~~", "a block in fortran"),
        ("~~~bat\ndir\n~~~", "a block in bat"),
        ("~~~text\n1 2\n~~~", "a text that no block of its section prints"),
        ("~~~sh\necho\n~~~\n\n# Next\n\n~~~text\n1 2\n~~~", "a text that no block of its section prints"),
        ("~~~sh\necho 1\n~~~\n\n~~~text\n1\n~~~\n\n~~~text\n1\n~~~", "a text that no block of its section prints"),
        ("~~~{note}\nSee\n\n~~~~~~".replace("~~~~~~", "~~~"), None),
        ("~~~~{note}\n~~~fortran\nend\n~~~\n~~~~".replace("~~~~", "````"), "a block in fortran"),
    ],
)
def test_a_block_that_nothing_runs_or_examines_is_named(tmp_path: Path, block: str, reason: str | None) -> None:
    found = unaccounted(page(tmp_path, f"# Title\n\n{block}\n"))
    assert bool(found) is (reason is not None)
    if reason is not None:
        assert found[-1].startswith("page.md:")
        assert reason in found[-1]


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("cosim fly", "no command `cosim fly`"),
        ("cosim run stick-slip --stop 1", "`cosim run` has no option --stop"),
        ("cosim list | cosim plot x --overlap", "`cosim plot` has no option --overlap"),
        ("cosim build --platforms all", "`cosim build` has no option --platforms"),
        ("python build_fmu.py --packing all", "`build_fmu.py` has no option --packing"),
        ("make rum", "no target 'rum' in the Makefile"),
        ("make fuzz MODELL=X", "the Makefile asks no variable MODELL"),
        ("python -m tests.docs.nothing", "no module tests.docs.nothing"),
        ("pip install -r requirements/none.txt", "no requirements/none.txt in the checkout"),
        ('pip install "drillstring-cosim[nothing]"', "no extra 'nothing'"),
        ("cosim check dist/native/Nothing.fmu", "no dist/native/Nothing.fmu in the checkout"),
        ("nothing-known --help", "a program 'nothing-known'"),
    ],
)
def test_a_command_that_names_what_is_not_there_is_found_wherever_it_stands(
    tmp_path: Path, command: str, reason: str
) -> None:
    for text in (f"<!-- not run: a test -->\n~~~sh\n{command}\n~~~\n", f"~~~yaml\n- run: {command}\n~~~\n"):
        (found,) = wrong_on(page(tmp_path, f"# Title\n\n{text}"))
        assert found.startswith("page.md:")
        assert reason in found
    if command.startswith(("cosim", "make", "python", "pip")):
        assert [reason in found for found in wrong_on(page(tmp_path, f"Try `{command}`."))] == [True]


@pytest.mark.parametrize("code", ["--colour", "models.chart", "cosim.fly_away", "tests/docs/nothing.py"])
def test_options_names_and_files_within_prose_exist(tmp_path: Path, code: str) -> None:
    (found,) = wrong_on(page(tmp_path, f"# Title\n\n| a | b |\n|---|---|\n| 1 | `{code}` |\n"))
    assert code in found
    assert (
        wrong_on(page(tmp_path, "`--help`, `models.theory`, `cosim.simulate`, `tests/docs/__init__.py`, `a.b`")) == []
    )


@on_unix
def test_blocks_share_a_session_and_a_folder(tmp_path: Path) -> None:
    run(
        tmp_path,
        "`a.toml`:\n\n~~~toml\nn = 2\n~~~\n\n~~~sh\ncat a.toml\n~~~\n\n~~~text\nn = 2\n~~~\n\n"
        "~~~python\nfrom pathlib import Path\nn = 3\n~~~\n\n"
        "~~~python\nprint(n, Path('a.toml').read_text())\n~~~\n\nprints\n\n~~~text\n3 n = 2\n~~~\n\n"
        "<!-- file: a.toml -->\n~~~diff\n@@\n-n = 2\n+n = 4\n~~~\n\n"
        "~~~text\n$ cat a.toml\nn = 4\n$ cat b.toml || true\n...\n~~~\n",
    )


@on_unix
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("~~~sh\necho 1\n~~~\n\n~~~text\n2\n~~~\n", "page.md:5: what is printed is not what is shown:"),
        ("~~~text\n$ echo 1\n2\n~~~\n", "page.md:1: what is printed is not what is shown:"),
        ("~~~sh\ntrue\nfalse\necho 1\n~~~\n", "bash: line 3 ended with 1"),
        ("~~~text\n$ true\nerror: no\n~~~\n", "exit code 0"),
        ("~~~python\n\nprint(1)\n~~~\n", "page.md:1: no text below shows what it prints:\n1"),
        ("~~~python\n\nprint(1 / 0)\n~~~\n", 'page.md", line 3'),
        ("~~~python\nimport os\nos._exit(3)\n~~~\n", "the interpreter ended"),
        ("~~~sh\necho 1 > a.csv\n~~~\n\n`a.csv`:\n\n~~~csv\n2\n~~~\n", "a.csv is there and differs"),
        ("~~~csv\n1,2\n3\n~~~\n", "no csv: rows of [1, 2] columns"),
        ("~~~toml\na = \n~~~\n", "no toml"),
        ("~~~xml\n<a>\n~~~\n", "no xml"),
        ("~~~yaml\na: {\n~~~\n", "no yaml"),
        ("~~~html\n<b>1</i>\n~~~\n", "no html"),
        ("~~~math\n\\frac{1}{2\n~~~\n", "no math"),
        ("`a.toml`:\n\n~~~toml\n[components.plant]\nfmu = 'No'\n~~~\n", "page.md:3: "),
        ("~~~sh\necho a > a.py\n~~~\n\n<!-- file: a.py -->\n~~~diff\n-b\n+c\n~~~\n", "stands 0 times in a.py"),
        ("<!-- run with 65 as 9 -->\n~~~sh\necho 64\n~~~\n", "it is run with '65' as something else"),
        ("<!-- not run a test -->\n~~~sh\nfalse\n~~~\n", "page.md:1: the comment 'not run a test' above"),
        ("<!-- interrupted once a is there -->\n~~~sh\ntrue\n~~~\n", "before there was a"),
    ],
)
def test_what_fails_or_prints_something_else_is_named(tmp_path: Path, text: str, reason: str) -> None:
    assert reason in refused(tmp_path, text)


@on_unix
def test_comments_say_what_is_not_run_or_run_otherwise(tmp_path: Path) -> None:
    run(
        tmp_path,
        '<!-- not run "false": a test -->\n<!-- run with 65 as 9; the FILE as a -->\n'
        "~~~sh\nfalse --always\necho 65 165 the FILE > b\ncat b\n~~~\n\n~~~text\n9 165 a\n~~~\n\n"
        "<!-- not run: a test -->\n~~~sh\nfalse\n~~~\n\n~~~text\nsaid\n~~~\n\n"
        "<!-- interrupted once c is there -->\n"
        "~~~sh\npython -c \"open('c', 'w'), __import__('time').sleep(1000)\"\n~~~\n\n"
        "~~~sh\necho 12.5 s\n~~~\n\n<!-- figures differ: a test -->\n~~~text\n7 s\n~~~\n",
    )


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a b\n", "a b  \n\n", True),
        ("a b\n", "a  b\n", False),
        ("a\n", "a\nb\n", False),
        ("a\n...\n", "a\nb\nc\n", True),
        ("...\na\n", "a\n", True),
        ("...\na\n", "ba\n", False),
        ("a ... c\n", "a b c\n", True),
        ("a ... c\n", "a b\nc\n", False),
        ("a in 0.0107 s\n", "a in 2e-05 s\n", True),
        ("a in 0.0107 s\n", "a in 2 rad\n", False),
        ("a at 0.0107 s\n", "a at 0.0108 s\n", False),
        ("a\n    b in 1 s\n", "a b in 2 s\n", True),
        ("a\n    b\n", "a\n    b\n", True),
        ("a\n  b\n", "a b\n", False),
        ("1.5 (a)\n", "2.5 (a)\n", False),
    ],
)
def test_outputs_are_compared_to_the_character_but_for_what_may_vary(shown: str, printed: str, same: bool) -> None:
    assert (differences(shown, printed) == "") is same


def test_figures_may_differ_where_it_is_said_and_words_never() -> None:
    assert differences("a  1.5 s, mu_2\n", "a 1e-05 s, mu_2\n", figures=False) == ""
    assert differences("a 1.5 s, mu_2\n", "a 1.5 s, mu_3\n", figures=False) != ""
    assert differences("a 1.5 s\n", "a nothing s\n", figures=False) != ""


def test_all_pages_are_found() -> None:
    names = {path.name for path in all_pages()}
    assert {"README.md", "CONTRIBUTING.md", "own-law.md", "0013-rooms.md"} <= names
