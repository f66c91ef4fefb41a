"""``synth reproduce``: compare published tables and claims with results of this program.

FOLDER holds rat/, dog/ and published.json. The page shows Tables 1, 2, 3, 4, 6, 8 and A-1 and explains each difference
by computed figures: the thesis' own methods and costs, its mistakes repeated where they matter, and least
squares with intervals. The word jump in place of FOLDER reproduces the jumping leg's study, which needs no
recordings: each claim, and the crouch, supply and damping that give its published heights.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from synth.commands.progress import Progress
    from synth.validation.comparison_table import ComparisonTable

    Gone = tuple[str, Mapping[str, str], tuple[ComparisonTable, ...]]

JUMP = "jump"  # in place of a folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("folder", metavar="FOLDER", help="the laboratory's data: rat/, dog/, published.json; or jump")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--seed", type=_seed, default=0, metavar="N", help="of the swarms (0)")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the folder and compute the tables; write ``reproduction.json`` and the page."""
    from synth.commands.answers import tell
    from synth.files.output import output_folder, write_json
    from synth.reports.reproduction import write_reproduction_report
    from synth.validation.thesis_reproduction import reproduction_json

    with output_folder(arguments.out) as folder:
        name, inputs, tables = _jump(progress) if arguments.folder == JUMP else _thesis(arguments, progress)
        with progress.stage("writing"):
            write_json(folder / "reproduction.json", reproduction_json(name, inputs, tables, arguments.seed))
            write_reproduction_report(folder)
    tell(progress, Path(arguments.out) / "reproduction.json", reproduced_text, notes=())
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def reproduced_text(content: Mapping[str, Any]) -> str:
    """One row per table: its number of rows, of claims that hold, and of the sentences that explain differences."""
    from synth.commands.table_text import table_text

    rows = [["table", "rows", "claims that hold", "sentences on differences"]]
    for table in content["tables"]:
        judged = [row["holds"] for row in table["rows"] if "holds" in row]
        held = f"{sum(judged)} of {len(judged)}" if judged else "-"
        rows.append([table["name"], str(len(table["rows"])), held, str(len(table["differences"]))])
    return table_text(rows)


def _thesis(arguments: argparse.Namespace, progress: Progress) -> Gone:
    from synth.validation.thesis_data import JOINTS, read_lab_data
    from synth.validation.thesis_reproduction import reproduce

    with progress.stage("reading the folder"):
        data = read_lab_data(arguments.folder)
    progress.compiling(len(JOINTS))
    tables = reproduce(data, seed=arguments.seed, stage=progress.stage)
    return "E. Krnacik's thesis, reproduced", data.inputs, tables


def _jump(progress: Progress) -> Gone:
    from synth.validation.jump_tables import jump_tables

    with progress.stage("the jumping leg: which configuration gives the published heights"):
        tables = jump_tables()
    return "C. Knaup and D. Aukes' jumping leg, reproduced", {}, tables


def _seed(text: str) -> int:
    if not (text.isascii() and text.isdigit() and float(text) < 2**32):  # numpy's seeds have 32 bits
        raise argparse.ArgumentTypeError(f'"{text}" is not allowed: a whole number from 0 to {2**32 - 1}')
    return int(text)
