"""The command line: find the command, parse its arguments, run it, print error messages.

Exit status: 0 success, 1 no part or design meets the request, 2 a mistake in the input, 70 an internal error (with a
traceback), 74 standard output could not be written, 130 interrupted, 141 the reader of the output has gone.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import NoReturn

from synth import __version__
from synth.commands import streams
from synth.commands.arguments import empty_arguments, near_miss
from synth.commands.common_options import WITH_JSON, add_common
from synth.commands.progress import Progress, printable
from synth.compiling.modules import is_loaded
from synth.errors import CannotBeHad, Problem, UserError
from synth.threads import LIBRARIES, thread_count

# One module of synth.commands each, imported when its command runs.
COMMANDS = {
    "init": "write an example project to start from",
    "import": "convert motion recorded by other programs into trials of a leg",
    "fit": "springs, dampers and free angles of a leg from its trials",
    "leg": "design a leg of parts to buy, wind and print from recorded motion",
    "gap": "explain the difference between built and simulated leg: where, which effect, how large",
    "compare": "fits, designs, gaps, legs and recordings compared from the same start",
    "hopper": "gear motor and link length of a jumping leg, from available motors",
    "check": "check a leg's model by closed forms, statics, energy and another engine",
    "spring": "design a torsion spring, or show which limits prevent it",
    "catalog": "list, show and check catalogues of springs, dampers and wire",
    "reproduce": "reproduce the thesis' tables from the laboratory's recordings",
    "warmup": "compile the equations of motion in advance",
    "completion": "write a bash, zsh or fish script that completes commands and options",
}
MODULES = {"import": "motion_import"}  # commands whose name cannot be a module name
TOP_OPTIONS = ("--help", "--version", "--quiet")
CANNOT_BE_HAD, MISTAKE, BUG, OUTPUT_LOST = 1, 2, 70, 74  # exit statuses; EX_SOFTWARE and EX_IOERR of sysexits.h
INTERRUPTED, READER_GONE = 130, 141  # as shells report a process that SIGINT or SIGPIPE ended: 128 and its number


class Parser(argparse.ArgumentParser):
    """An argument parser that raises its messages as UserError."""

    def error(self, message: str) -> NoReturn:
        """Raise UserError."""
        raise UserError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    try:
        return _ended(argv)
    except BrokenPipeError:  # of messages too: standard error may be a pipe
        streams.read_by_nobody()
        return READER_GONE


def _ended(argv: Sequence[str] | None) -> int:
    """The exit status of a command whose errors are told.

    Raises
    ------
    BrokenPipeError : the reader of the output or of the messages has gone.
    """
    streams.prepare()
    _quick_start()
    try:
        status = _dispatch(list(sys.argv[1:] if argv is None else argv))
        lost = streams.lost()
        if lost is not None:
            streams.write_message(
                f"synth: standard output: cannot be written: {lost}; the command itself is complete\n"
            )
            return OUTPUT_LOST
        if argv is None:
            gc.freeze()  # the process ends: skip a last collection, a tenth of a second
        return status
    except UserError as error:
        streams.write_message("".join(f"synth: {printable(str(problem))}\n" for problem in error.problems))
        with suppress(OSError):
            streams.lost()
        return CANNOT_BE_HAD if isinstance(error, CannotBeHad) else MISTAKE
    except KeyboardInterrupt:
        streams.write_message("synth: interrupted; nothing was left half-written\n")
        return INTERRUPTED
    except BrokenPipeError:
        raise
    except Exception:
        if argv is not None:  # called from Python: the caller wants the exception
            raise
        streams.write_message(traceback.format_exc())
        return BUG


def _quick_start() -> None:
    """Settings of the process that save each command a tenth of its time.

    Loading creates half a million permanent objects, which the collector need not scan repeatedly. The
    matrices are so small that the threads of the linear algebra library would only wait for each other.
    """
    gc.set_threshold(50_000, 20, 20)
    if not is_loaded("numpy"):
        for name in LIBRARIES:
            os.environ.setdefault(name, "1")


def _dispatch(argv: list[str]) -> int:
    """Read the options before the command, then run it."""
    quiet = False
    while argv and argv[0].startswith("-"):
        option = argv.pop(0)
        if option in ("-h", "--help"):
            streams.write_result(sys.stdout, _help())
            return 0
        if option in ("-V", "--version"):
            streams.write_result(sys.stdout, f"synth {__version__}\n")
            return 0
        if option not in ("-q", "--quiet"):
            raise UserError(f'unknown option "{option}"{near_miss(option, TOP_OPTIONS)} (see synth --help)')
        quiet = True
    if not argv:
        streams.write_message(_help())
        return MISTAKE
    name, *rest = argv
    if name not in COMMANDS:
        known = ", ".join(COMMANDS)
        raise UserError(f'unknown command "{name}"{near_miss(name, COMMANDS)}; the commands are {known}')
    return _run(name, rest, quiet=quiet)


def _run(name: str, rest: list[str], *, quiet: bool) -> int:
    """Parse a command's arguments and run it."""
    module = importlib.import_module(f"synth.commands.{MODULES.get(name, name)}")
    parser = parser_of(name)
    _refuse_unknown_options(parser, rest)
    try:
        arguments, surplus = parser.parse_known_args(rest)
    except SystemExit as done:  # --help
        return int(done.code or 0)
    if surplus:
        raise UserError([Problem(f'"{word}" is an unexpected argument (see {parser.prog} --help)') for word in surplus])
    if empty := empty_arguments(parser, arguments):
        raise UserError(empty)
    thread_count()  # a wrong number of threads is refused before any work
    as_json = name in WITH_JSON and arguments.json
    with ExitStack() as stack:
        log = None
        if arguments.log is not None:
            from synth.commands.log_file import LogFile

            log = stack.enter_context(LogFile(Path(arguments.log), [name, *rest]))
        if getattr(arguments, "allow_outside", False):
            from synth.files.paths import allowing_outside

            stack.enter_context(allowing_outside())
        if given := getattr(arguments, "effect", []):
            from synth.commands.effect_option import own_effects

            stack.enter_context(own_effects(given, getattr(arguments, "file", None)))
        progress = Progress(quiet=quiet or arguments.quiet, as_json=as_json, log=log)
        status: int = module.run(arguments, progress)
        if log is not None:
            log.line(f"ended with status {status}")
    return status


def parser_of(name: str) -> Parser:
    """The parser of a command with all options."""
    module = importlib.import_module(f"synth.commands.{MODULES.get(name, name)}")
    parser = Parser(
        prog=f"synth {name}",
        description=(module.__doc__ or "").partition("\n\n")[2].strip() or f"{COMMANDS[name].capitalize()}.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    module.add_arguments(parser)
    add_common(parser, name)
    return parser


def _refuse_unknown_options(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Name unknown options first; argparse would only report the required option that was misspelt."""
    known = parser._option_string_actions
    options = words[: words.index("--")] if "--" in words else words
    names = [word.partition("=")[0] for word in options if word.startswith("--") and " " not in word.partition("=")[0]]
    unknown = [name for name in names if name not in known]
    if unknown:
        see = f" (see {parser.prog} --help)"
        raise UserError([Problem(f'unknown option "{name}"{near_miss(name, known)}{see}') for name in unknown])


def _help() -> str:
    width = max(map(len, COMMANDS))
    commands = "".join(f"  {name:<{width}}  {summary}\n" for name, summary in COMMANDS.items())
    return f"""\
usage: synth COMMAND ... [-q]

From recorded limb motion to springs, dampers and joints that can be bought, wound and printed.

commands:
{commands}
options:
  -h, --help     show this help, or that of COMMAND
  -V, --version  show the version
  -q, --quiet    print only results and error messages

Start with `synth init leg DIR`. Every quantity carries its unit: "200 mm", "38 N*m/rad", "45 deg".
"""
