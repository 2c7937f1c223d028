"""Bundles of modules for python FMUs."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmu_src import project
from fmu_src.build.python_packaging import bundle
from fmu_src.errors import BuildError


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(project, "ROOT", tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "base.py").write_text('TEXT = "from models"\n')
    return tmp_path


def main(tree: Path, source: str) -> None:
    (tree / "models" / "main.py").write_text(source, encoding="utf-8")


def test_only_what_is_imported_is_bundled_and_all_imports_point_inside(tree: Path) -> None:
    (tree / "models" / "unused.py").write_text("")
    main(tree, "import math\nfrom models import base\nfrom models.base import TEXT\nimport models.base as other\n")
    package, files = bundle("models.main")
    assert sorted(files) == [
        f"{package}/__init__.py", f"{package}/models/__init__.py", f"{package}/models/base.py",
        f"{package}/models/main.py",
    ]  # fmt: skip
    assert files[f"{package}/models/main.py"].decode() == (
        f"import math\nfrom {package}.models import base\nfrom {package}.models.base import TEXT\n"
        f"import {package}.models.base as other\n"
    )
    assert files[f"{package}/models/base.py"] == b'TEXT = "from models"\n'


def test_an_import_inside_a_function_points_inside(tree: Path) -> None:
    main(tree, "def ü():\n    'ü'; from models.base import TEXT; return TEXT\n")
    package, files = bundle("models.main")
    assert f"from {package}.models.base import TEXT; return" in files[f"{package}/models/main.py"].decode()


def test_the_name_follows_the_content(tree: Path) -> None:
    main(tree, "from models.base import TEXT\n")
    first, _ = bundle("models.main")
    assert bundle("models.main")[0] == first
    (tree / "models" / "base.py").write_text('TEXT = "other"\n')
    assert bundle("models.main")[0] != first


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("import models.base\n", "cannot bundle 'import models.base'"),
        ("from models.missing import x\n", "the module models.missing.x is missing"),
        ("from\tmodels.base import TEXT\n", "write one space after 'from'"),
    ],
)
def test_what_cannot_be_bundled_is_refused(tree: Path, source: str, message: str) -> None:
    main(tree, source)
    with pytest.raises(BuildError, match=message):
        bundle("models.main")
