"""What a cell of a tutorial prints arrives whole, whenever it was printed."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import nbclient
import nbformat

from docs.site.kernel import steady_kernel

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

SLOW_WORDS = """
import logging, sys, time
print("half a", end="")
time.sleep(0.6)
print(" line")
logging.getLogger("cosim").warning("a warning")
time.sleep(0.6)
print("another")
"""


def outputs(folder: Path, *cells: str) -> list[list[nbformat.NotebookNode]]:
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    with steady_kernel(folder):
        nbclient.execute(notebook)
    return [cell.outputs for cell in notebook.cells]


def test_what_a_cell_prints_arrives_whole_and_without_warnings(tmp_path: Path) -> None:
    [[whole], [another]] = outputs(tmp_path, SLOW_WORDS, "print(1)")
    assert (whole.output_type, whole.name, whole.text) == ("stream", "stdout", "half a line\nanother\n")
    assert another.text == "1\n"


def test_cells_find_nothing_that_they_have_not_imported(tmp_path: Path) -> None:
    [[names]] = outputs(tmp_path, "print(sorted({'cosim', 'logging', 'sys', 'Any'} & set(globals())))")
    assert names.text == "[]\n"


def test_variable_of_the_user_is_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPYTHONDIR", "mine")
    with steady_kernel(tmp_path):
        assert os.environ["IPYTHONDIR"] == str(tmp_path)
    assert os.environ["IPYTHONDIR"] == "mine"
