"""Write the reference experiments of every model to fmu_src/reference, the answers computed anew."""

from __future__ import annotations

import shutil

from tests.reference.catalogue import FOLDER, MODELS
from tests.reference.files import reference_files

if __name__ == "__main__":
    for model, experiments in MODELS.items():
        folder = FOLDER / model
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for name, content in reference_files(model, experiments).items():
            (folder / name).write_bytes(content)
