"""Options that many commands share, declared in one place."""

from __future__ import annotations

import argparse

from synth.commands.arguments import one_of

WITH_JSON = (
    "fit",
    "leg",
    "gap",
    "hopper",
    "compare",
    "check",
)  # that end with a table; `synth spring` has --json of its own
WITH_UNITS = ("fit", "leg", "spring")  # whose tables hold lengths, rates and the like
READING_LEGS = ("fit", "leg", "gap", "import", "hopper")  # whose projects name files


def add_common(parser: argparse.ArgumentParser, command: str) -> None:
    """Declare what every command has, and what a command of this name shares with others."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing but the result's table and mistakes")
    parser.add_argument("--log", metavar="FILE", help="append what is done, and when, to this file")
    if command in WITH_JSON:
        parser.add_argument("--json", action="store_true", help="print the result's JSON, and nothing else, on stdout")
    if command in WITH_UNITS:
        words = "units of tables and sheets (default: those of the input); result files keep theirs"
        parser.add_argument("--units", type=one_of(["inch", "metric"]), metavar="inch|metric", help=words)
    if command in READING_LEGS:
        words = "a project may name a leg file that lies outside its folder and its repository"
        parser.add_argument("--allow-outside", action="store_true", help=words)
