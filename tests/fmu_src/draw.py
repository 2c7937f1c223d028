"""Draws the icons: python -m tests.fmu_src.draw."""

from __future__ import annotations

from pathlib import Path

import resvg_py

from fmu_src import project


def drawings() -> list[Path]:
    return sorted([*project.ICONS.glob("*.svg"), *project.FMUS.glob("*/*.svg")])


def draw(drawing: Path) -> bytes:
    """Return a drawing as a PNG file of its own size."""
    return resvg_py.svg_to_bytes(svg_path=str(drawing), skip_system_fonts=True)


if __name__ == "__main__":
    for drawing in drawings():
        drawing.with_suffix(".png").write_bytes(draw(drawing))
