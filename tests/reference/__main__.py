"""Write the reference experiments of every model into its folder, the answers computed anew."""

from __future__ import annotations

import shutil

from tests.reference.catalogue import MODELS, folder_of
from tests.reference.files import reference_files

if __name__ == "__main__":
    for model, experiments in MODELS.items():
        folder = folder_of(model)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for name, content in reference_files(model, experiments).items():
            (folder / name).write_bytes(content)
