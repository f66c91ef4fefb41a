"""``synth warmup``: compile the equations of motion of swinging and jumping legs and store them on disk."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from synth.errors import Problem, UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress

MOST_LINKS = 6  # the most links that a leg file may have


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "--links",
        metavar="N",
        help=f"compile for a leg of N links, 1 to {MOST_LINKS} (default: all, jumping legs included)",
    )


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Compile and report the time."""
    import time

    wanted = _links(arguments.links)
    from synth.cache import cache_folder
    from synth.commands.answers import tell_document
    from synth.swing.chain import is_compiled
    from synth.units import quantity

    start = time.perf_counter()
    compiled = [n_link for n_link in wanted if not is_compiled(n_link)]
    for n_link in wanted:
        progress.compiling(n_link)
    if arguments.links is None:
        compile_jumps(progress)
    spent = time.perf_counter() - start
    folder = cache_folder()
    files = [path for path in (folder / "code").glob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files) / 1e6
    content = {
        "format": "synth/warmup/1",
        "links": wanted,
        "compiled_now": compiled,
        "jumping_legs": arguments.links is None,
        "time": quantity(spent, "s"),
        "folder": str(folder),
        "size": {"value": size, "unit": "MB"},
    }
    tell_document(progress, content, "")
    progress.say(f"{len(compiled)} of {len(wanted)} compiled, the others were stored already: {spent:.1f} s")
    progress.say(f"stored in {folder}: {size:.1f} MB")
    return 0


def compile_jumps(progress: Progress) -> None:
    """Compile every bending model, the recorder, the planar form and the pull-up."""
    import numpy as np

    from synth.hopper.fold import fold, parameters_of
    from synth.hopper.motors import motor_of
    from synth.jump import recorder  # noqa: F401  compiled when imported
    from synth.jump.hopper_leg import Contact, HopperLeg
    from synth.jump.jump_layout import LAYOUTS
    from synth.jump.jump_models import MODELS, columns
    from synth.jump.jump_runs import compiled_jump
    from synth.jump.planar_jump import planar_record
    from synth.parts.catalogs import Catalogue

    with progress.stage("compiling jumping legs"):
        for bending in LAYOUTS:
            compiled_jump(bending)
        motor = motor_of(next(row for row in Catalogue.load().motors if row.complete))
        leg = HopperLeg()
        made = columns(leg, motor, Contact(), MODELS["full"], np.array([leg.length]))
        times = np.array([0.0, 1e-3])
        planar_record(made, leg.body_inertia, Contact().slip_speed, 0.0, times, 1e-3)
        fold(parameters_of(made), times, np.zeros(2), made.start, np.zeros(1))


def _links(text: str | None) -> list[int]:
    if text is None:
        return list(range(1, MOST_LINKS + 1))
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:3]) <= MOST_LINKS):
        raise UserError(Problem(f'"{text}" is not a whole number from 1 to {MOST_LINKS}', key="--links"))
    return [int(text)]
