"""``synth warmup``: compile the equations of motion and keep them on disk."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from synth.errors import Problem, UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress

MOST_LINKS = 6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "--links", metavar="N", help=f"compile for a leg of N links, 1 to {MOST_LINKS} (default: for each of these)"
    )


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Compile, and say what it took."""
    import time

    wanted = _links(arguments.links)
    from synth.model.chain import is_compiled
    from synth.model.generate import cache_folder

    start = time.perf_counter()
    n_compiled = 0
    for n_link in wanted:
        n_compiled += not is_compiled(n_link)
        progress.compiling(n_link)
    spent = time.perf_counter() - start
    folder = cache_folder()
    files = [path for path in folder.rglob("synth_*") if path.is_file()]
    size = sum(path.stat().st_size for path in files) / 1e6
    progress.say(f"{n_compiled} of {len(wanted)} compiled now, the others were on disk: {spent:.1f} s")
    progress.say(f"kept in {folder}: {size:.1f} MB")
    return 0


def _links(text: str | None) -> list[int]:
    if text is None:
        return list(range(1, MOST_LINKS + 1))
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:3]) <= MOST_LINKS):
        raise UserError(Problem(f'"{text}" is no whole number from 1 to {MOST_LINKS}', key="--links"))
    return [int(text)]
