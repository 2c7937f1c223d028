"""Every model's reference experiments, and where their files are kept.

Those of the model `<SomeName>`, whose folder holds reference/, are `EXPERIMENTS` of the module `some_name` beside this.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from fmu_src import project
from tests.reference.experiment import Experiment


def folder_of(model: str) -> Path:
    """Return where the files of a model's reference experiments are kept."""
    return project.FMUS / model / "reference"


def experiments_of(model: str) -> Sequence[Experiment]:
    """Return the reference experiments of a model."""
    module = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", model).lower()
    return import_module(f"tests.reference.{module}").EXPERIMENTS


MODELS = {path.parent.name: experiments_of(path.parent.name) for path in sorted(project.FMUS.glob("*/reference"))}
