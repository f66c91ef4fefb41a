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
    "import",
    "catalog",
    "reproduce",
    "init",
    "warmup",
)  # all but `completion`, whose result is a script; `synth spring` has its own --json
WITH_UNITS = ("fit", "leg", "spring")  # their tables contain lengths, rates and similar quantities
WITH_EFFECTS = ("fit", "leg", "gap", "compare", "check", "import")  # they read swinging legs
READING_LEGS = ("fit", "leg", "gap", "import", "hopper")  # their projects name files


def add_common(parser: argparse.ArgumentParser, command: str) -> None:
    """Declare the options that every command has, and those that this command shares with others."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print only the result's table and error messages")
    parser.add_argument("--log", metavar="FILE", help="append a log of the run to this file")
    if command in WITH_JSON:
        parser.add_argument("--json", action="store_true", help="print only the result's JSON on stdout")
    if command in WITH_UNITS:
        words = "units of tables and sheets (default: those of the input); result files stay in SI"
        parser.add_argument("--units", type=one_of(["inch", "metric"]), metavar="inch|metric", help=words)
    if command in WITH_EFFECTS:
        words = "your own effect, which a leg file may hold and gap looks for; its file is executed; repeatable"
        parser.add_argument("--effect", action="append", default=[], metavar="FILE.py", help=words)
    if command in READING_LEGS:
        words = "allow a leg file outside the project's folder and repository"
        parser.add_argument("--allow-outside", action="store_true", help=words)
