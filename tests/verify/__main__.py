"""Judge all laws and claims, print the report, and say by the exit code whether all laws hold."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

import tests.verify.claims
import tests.verify.laws  # noqa: F401
from tests.verify.claim import CLAIMS
from tests.verify.examination import examine, try_claims
from tests.verify.finding import LAWS
from tests.verify.report import claims_page, show_claims, show_laws

PAGE = Path(__file__).parents[2] / "docs" / "claims.md"
WIDTH = 160
"""Of the report where it does not go to a terminal."""


def main(
    html: Annotated[Path | None, typer.Option(help="Also write the report as a page.")] = None,
    write_claims: Annotated[bool, typer.Option(help="Write docs/claims.md anew instead of comparing it.")] = False,
) -> None:
    """Hold the product against laws, and the paper's claims against the product."""
    console = Console(record=html is not None, width=None if Console().is_terminal else WIDTH)
    begun = time.perf_counter()
    logging.disable(logging.WARNING)  # of runs that are meant to go wrong
    with console.status("") as status:
        examined = examine(LAWS, status.update)
        tried = try_claims(CLAIMS, status.update)
    show_laws(console, examined)
    show_claims(console, tried)
    page = claims_page(tried)
    if write_claims:
        PAGE.write_text(page, encoding="utf-8", newline="\n")
    current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == page
    broken = [one for one in examined if not one.finding.holds]
    took = time.perf_counter() - begun
    console.print(f"{len(examined) - len(broken)} of {len(examined)} laws hold; {len(tried)} claims; {took:.0f} s")
    if not current:
        console.print(
            f"{PAGE.relative_to(PAGE.parents[1])} is not what came out; write it by --write-claims", style="red"
        )
    if html is not None:
        console.save_html(str(html))
    raise typer.Exit(1 if broken or not current else 0)


if __name__ == "__main__":
    typer.run(main)
