"""The command line as a whole: quick help, exit statuses, messages, progress."""

from __future__ import annotations

import argparse
import io
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

import synth
from compiled_code import with_code
from synth.cli import COMMANDS, main
from synth.commands import warmup
from synth.commands.arguments import Quantities, one_of
from synth.commands.progress import Progress, printable
from synth.errors import Problem, UserError

HEAVY = [
    "numpy",
    "scipy",
    "pandas",
    "numba",
    "cadquery",
    "matplotlib",
    "pint",
    "pydantic",
    "trimesh",
    "yaml",
    "jinja2",
    "manifold3d",
    "OCP",
]
SYNTH = [sys.executable, "-m", "synth"]


def synth_run(*words: str, **options: object) -> subprocess.CompletedProcess[str]:
    """A real run of the program."""
    return subprocess.run([*SYNTH, *words], capture_output=True, text=True, timeout=120, check=False, **options)  # type: ignore[call-overload, no-any-return]


@pytest.mark.parametrize("words", [["--help"], *([name, "--help"] for name in COMMANDS)], ids=" ".join)
def test_help_imports_nothing_heavy(words: list[str]) -> None:
    code = f"import sys; from synth.cli import main\nassert main({words!r}) == 0\n"
    code += f"print('heavy:', sorted(set({HEAVY!r}) & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "heavy: []"
    expected = [f"usage: synth {words[0]}"] if len(words) == 2 else [f"  {name} " for name in COMMANDS]
    assert all(text in done.stdout for text in expected)


def test_version_and_entry_point() -> None:
    assert synth_run("--version").stdout == f"synth {synth.__version__}\n"


def test_no_command_shows_the_help_and_is_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "commands:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["catalogue", "list"], r'synth: unknown command "catalogue"; did you mean catalog\?; the commands are init, '),
        (["--versoin"], r'synth: unknown option "--versoin"; did you mean --version\?'),
        (["fit", "a.yaml", "--oot", "x"], r'synth: unknown option "--oot"; did you mean --out\? \(see synth fit --he'),
        (["leg", "a.yaml", "--out", "x", "--nocad"], r'synth: unknown option "--nocad"; did you mean --no-cad\?'),
        (["fit", "a.yaml"], r"synth: the following arguments are required: --out"),
        (["leg"], r"synth: the following arguments are required: file, --out"),
        (["warmup", "3"], r'synth: "3" is an unexpected argument'),
        (["warmup", "--links", "7"], r'synth: --links: "7" is not a whole number from 1 to 6'),
        (["warmup", "--links", "٣"], r"synth: --links: .* is not a whole number"),
        (["init", "lag", "x"], r'synth: .*"lag" is not one of leg, fit, .*; did you mean leg\?'),
        (["fit", "none.yaml", "--out", "x"], r"synth: none.yaml: does not exist"),
    ],
)
def test_a_mistake_is_one_line_and_status_2(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*words, "-q"] if words[0] in COMMANDS else words) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert len(shown.err.splitlines()) == 1
    assert re.match(message, shown.err)
    assert list(tmp_path.iterdir()) == []


def raising(error: BaseException) -> object:
    """A command's ``run`` that ends like this."""

    def run(arguments: argparse.Namespace, progress: Progress) -> int:
        raise error

    return run


def test_each_problem_is_on_its_own_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    problems = [Problem("is bad", "a\nb.csv", 3, "hip"), Problem("\x1b[31mred")]
    monkeypatch.setattr(warmup, "run", raising(UserError(problems)))
    assert main(["warmup"]) == 2
    assert capsys.readouterr().err == "synth: a\\nb.csv:3: hip: is bad\nsynth: \\x1b[31mred\n"


def test_interrupt_is_one_line_and_status_130(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warmup, "run", raising(KeyboardInterrupt()))
    assert main(["warmup"]) == 130
    assert capsys.readouterr().err.count("\n") == 1


def test_an_internal_error_gives_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warmup, "run", raising(ZeroDivisionError("ours")))
    with pytest.raises(ZeroDivisionError):
        main(["warmup"])


def test_a_closed_output_pipe_is_no_error() -> None:
    process = subprocess.Popen(
        [*SYNTH, "catalog", "list", "wire_diameters"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=60) == 141
    assert said == ""


@pytest.mark.parametrize("words", [("fit", "missing.yaml"), ("no-such-command",)])
def test_messages_that_nobody_reads_are_no_error_of_ours(words: tuple[str, ...], tmp_path: Path) -> None:
    process = subprocess.Popen([*SYNTH, *words], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, cwd=tmp_path)
    assert process.stderr is not None
    process.stderr.close()
    assert process.wait(timeout=60) == 141


def test_output_that_the_terminal_cannot_show_is_escaped() -> None:
    done = synth_run("catalog", "show", "μ", env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 2
    assert '"\\u03bc"' in done.stderr


def test_warmup_compiles_once(tmp_path: Path) -> None:
    cache = with_code(tmp_path / "cache", 1, but="chain")  # the integrator alone takes as long as ten such modules
    environment = {**os.environ, "SYNTH_CACHE": str(cache)}
    first, second = (synth_run("warmup", "--links", "1", env=environment) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0)
    said = "compiling the equations of motion for 1 link (with effects, once on this machine, 8 to 20 s; "
    assert f"{said}stored in {cache}" in first.stderr
    assert first.stdout.startswith("1 of 1 compiled")
    assert second.stderr.startswith("loading the equations of motion for 1 link ...")
    assert second.stdout.startswith("0 of 1 compiled")
    assert "MB" in synth_run("warmup", "--links", "1", env=environment).stdout
    assert synth_run("warmup", "--links", "1", "--quiet", env=environment).stderr == ""


def test_stages_can_be_nested() -> None:
    messages, results = io.StringIO(), io.StringIO()
    progress = Progress(messages=messages, results=results)
    with progress.stage("outer"):
        with progress.stage("in\nner"):
            pass
        progress.say("found it")
    with progress.stage("last"):
        pass
    shown = re.sub(r"\d+\.\d s", "T", messages.getvalue())
    assert shown == "outer ...\n  in\\nner ... T\nouter ... T\nlast ... T\n"
    assert results.getvalue() == "found it\n"


def test_a_failing_stage_is_reported_and_the_error_raised() -> None:
    messages = io.StringIO()
    progress = Progress(messages=messages, results=io.StringIO())
    with pytest.raises(UserError), progress.stage("work"):
        raise UserError("no")
    assert re.fullmatch(r"work \.\.\. stopped after \d+\.\d s\n", messages.getvalue())


def test_quiet_leaves_results_only() -> None:
    messages, results = io.StringIO(), io.StringIO()
    progress = Progress(quiet=True, messages=messages, results=results)
    with progress.stage("work"):
        progress.say("hello")
    progress.result("one\ntwo\x1b")
    assert messages.getvalue() == ""
    assert results.getvalue() == "one\ntwo\\x1b\n"


def test_a_terminal_line_counts_the_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr("synth.commands.progress.TICK", 0.02)
    terminal = Terminal()
    with Progress(messages=terminal, results=io.StringIO()).stage("work"):
        deadline = time.monotonic() + 10.0
        while terminal.getvalue().count("\r") < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
    shown = terminal.getvalue()
    assert shown.count("\r") >= 3
    assert shown.count("\n") == 1
    assert re.fullmatch(r"work \.\.\. \d+\.\d s\n", shown.split("\r")[-1])


def test_printable_keeps_unicode_text() -> None:
    assert printable("50 µm at 20 °C, <b>Kniegelenk</b> 膝") == "50 µm at 20 °C, <b>Kniegelenk</b> 膝"
    assert printable("a\u202eb\r") == "a\\u202eb\\r"


def test_quantities_collect_every_mistake() -> None:
    read = Quantities(argparse.Namespace(arbor="12", leg_length="-1 mm", travel="45 deg", rate=None))
    values = [read.read("--arbor", "m"), read.read("--leg-length", "m"), read.read("--rate", "N*m/rad")]
    assert values == [None, None, None]
    assert read.read("--travel", "rad") == pytest.approx(0.7853981633974483)
    with pytest.raises(UserError) as caught:
        read.require()
    assert [problem.key for problem in caught.value.problems] == ["--arbor", "--leg-length"]


def test_one_of_suggests() -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="did you mean tangent"):
        one_of(["tangent", "radial"])("tangnet")
