"""``synth reproduce``: the thesis' tables from the laboratory's recordings, published beside ours.

FOLDER holds rat/, dog/ and published.json. The page shows Tables 1, 2, 3, 4, 6, 8 and A-1 with every difference
explained from computed figures: the thesis' own methods and costs, its mistakes made again where they matter, and least
squares with intervals.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.commands.progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("folder", metavar="FOLDER", help="the laboratory's data: rat/, dog/, published.json")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--seed", type=_seed, default=0, metavar="N", help="of the swarms (0)")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read, go through the tables, write ``reproduction.json`` and the page."""
    from synth.files.output import output_folder, write_json
    from synth.validation.thesis_data import JOINTS, read_lab_data
    from synth.validation.thesis_reproduction import reproduce, reproduction_json

    with progress.stage("reading the folder"):
        data = read_lab_data(arguments.folder)
    with output_folder(arguments.out) as folder:
        progress.compiling(len(JOINTS))
        tables = reproduce(data, seed=arguments.seed, stage=progress.stage)
        with progress.stage("writing"):
            from reports.reproduction import write_reproduction_report

            write_json(folder / "reproduction.json", reproduction_json(data, tables, arguments.seed))
            write_reproduction_report(folder)
    for table in tables:
        progress.say(f"{table.name}: {len(table.rows)} rows, {len(table.differences)} differences explained")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def _seed(text: str) -> int:
    if not text.isdigit() or int(text) > 2**32 - 1:
        raise argparse.ArgumentTypeError(f'"{text}" is not allowed: a whole number from 0 to {2**32 - 1}')
    return int(text)
