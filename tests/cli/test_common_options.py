"""What the commands share: --log, --units, --allow-outside, completion, and the exit statuses."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from synth.cli import COMMANDS, main, parser_of
from synth.commands import log_file, warmup
from synth.commands.completion import SHELLS, options_of
from synth.errors import CannotBeHad, UserError
from synth.files.output import output_folder
from synth.files.paths import allowing_outside, name_from, repository_root, shared
from synth.files.shown_units import ShownUnits, shown_for, written_system

FIT = Path(__file__).parents[2] / "synth" / "examples" / "fit"
SPRING = ["spring", "-q", "--rate", "1 N*m/rad", "--travel", "20 deg"]


def test_a_log_contains_command_result_and_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "run.log"
    assert main([*SPRING, "--log", str(log)]) == 0
    shown = capsys.readouterr().out.splitlines()
    text = log.read_text(encoding="utf-8")
    assert "synth spring -q --rate '1 N*m/rad'" in text
    assert all(line in text for line in shown)
    assert text.rstrip().endswith("ended with status 0")
    assert main(["spring", "--rate", "1 N", "--travel", "20 deg", "--log", str(log)]) == 2
    again = log.read_text(encoding="utf-8")
    assert again.startswith(text)
    assert "mistake: --rate:" in again


def test_a_log_replaces_no_other_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "trial.csv"
    other.write_text("time [s],hip [deg]\n")
    assert main([*SPRING, "--log", str(other)]) == 2
    assert "is not a log of synth" in capsys.readouterr().err
    assert other.read_text() == "time [s],hip [deg]\n"


def test_a_log_is_a_regular_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A pipe would wait for its reader for ever."""
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
        assert main([*SPRING, "--log", str(tmp_path / "pipe")]) == 2
        assert "pipe: is not a regular file; name another with --log" in capsys.readouterr().err
    assert main([*SPRING, "--log", str(tmp_path)]) == 2
    assert "is a folder; name the file in it" in capsys.readouterr().err


@pytest.fixture
def full_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A log on a disk that is full from its first line on."""
    if not Path("/dev/full").exists():
        pytest.skip("this system has no full disk to try")
    monkeypatch.setattr(log_file, "_open_log", lambda path: open("/dev/full", "a"))  # noqa: SIM115, PTH123
    return str(tmp_path / "run.log")


def written_beside(log: log_file.LogFile, out: Path) -> None:
    """A result whose writing is logged."""
    with log, output_folder(out) as folder:
        (folder / "a.txt").write_text("whole")
        log.line("written")


def test_a_log_on_a_full_disk_is_told_and_costs_no_result(
    full_log: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*SPRING, "--log", full_log]) == 2
    shown = capsys.readouterr()
    assert shown.out
    assert (
        shown.err == f"synth: {full_log}: cannot be written: No space left on device; the command itself is complete\n"
    )
    assert main(["spring", "--rate", "1 N", "--travel", "20 deg", "--log", full_log]) == 2
    said = capsys.readouterr().err.splitlines()
    assert said[0] == f"synth: {full_log}: cannot be written: No space left on device"
    assert said[1].startswith("synth: --rate:")
    with pytest.raises(UserError, match=r"run\.log: cannot be written"):
        written_beside(log_file.LogFile(Path(full_log), []), tmp_path / "out")
    assert (tmp_path / "out" / "a.txt").read_text() == "whole"


def test_a_log_contains_the_traceback_of_an_internal_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(*_: object) -> int:
        raise ZeroDivisionError("ours")

    monkeypatch.setattr(warmup, "run", run)
    with pytest.raises(ZeroDivisionError):
        main(["warmup", "--log", str(tmp_path / "l")])
    assert "ZeroDivisionError: ours" in (tmp_path / "l").read_text()


@pytest.mark.parametrize(
    ("raised", "status"), [("CannotBeHad('none fits')", 1), ("UserError('is wrong')", 2), ("ValueError('ours')", 70)]
)
def test_exit_status_of_each_error(raised: str, status: int) -> None:
    code = f"""
import sys
from synth.errors import *
from synth.commands import warmup
from synth.cli import main
def run(*_): raise {raised}
warmup.run = run
sys.argv = ["synth", "warmup"]
sys.exit(main())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == status
    assert ("Traceback" in done.stderr) == (status == 70)


def test_no_part_in_the_catalogue_is_an_answer_not_a_mistake() -> None:
    assert issubclass(CannotBeHad, UserError)
    from synth.files.project_options import DamperChoice, PartsOptions
    from synth.parts.catalogs import Catalogue
    from synth.parts.part_candidates import damper_candidates

    catalogue = Catalogue.load()
    sold_out = PartsOptions(without=tuple(row.part for row in catalogue.dampers))
    with pytest.raises(CannotBeHad, match="no damper in the catalogue"):
        damper_candidates(catalogue, DamperChoice(), 1.0, "knee", sold_out)


def shared_project(tmp_path: Path) -> Path:
    """A project in REPO/a whose leg lies in REPO/shared."""
    project = tmp_path / "repo" / "a"
    shutil.copytree(FIT, project)
    (tmp_path / "repo" / "shared").mkdir()
    (project / "robot.leg.yaml").rename(tmp_path / "repo" / "shared" / "robot.leg.yaml")
    text = (project / "fit.yaml").read_text().replace("leg: robot.leg.yaml", "leg: ../shared/robot.leg.yaml")
    (project / "fit.yaml").write_text(text)
    return project


def test_a_leg_elsewhere_in_the_repository_is_allowed_with_an_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    project = shared_project(tmp_path)
    words = ["fit", str(project / "fit.yaml"), "--out", str(tmp_path / "out"), "--dry-run"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "leads out of" in said
    assert "--allow-outside" in said
    assert main([*words, "--allow-outside"]) == 0
    (tmp_path / "repo" / ".git").mkdir()
    assert main(words) == 0
    assert repository_root(project) == (tmp_path / "repo").resolve()
    assert name_from(project, project / "../shared/robot.leg.yaml") == "../shared/robot.leg.yaml"


def test_files_outside_the_repository_are_refused(tmp_path: Path) -> None:
    project = shared_project(tmp_path)
    (tmp_path / "repo" / ".git").mkdir()
    (tmp_path / "other.leg.yaml").write_text("kind: leg\n")
    (project / "link.leg.yaml").symlink_to(tmp_path / "other.leg.yaml")
    for name in ("../../other.leg.yaml", "link.leg.yaml"):
        with pytest.raises(UserError, match="leads out of"):
            shared(project, name)
        with allowing_outside():
            assert shared(project, name).exists()
    with pytest.raises(UserError, match="absolute"), allowing_outside():
        shared(project, str(tmp_path / "other.leg.yaml"))


def test_trials_stay_in_the_project_s_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Results are named after them: one outside would write outside."""
    project = shared_project(tmp_path)
    (project / "trials").rename(tmp_path / "repo" / "trials")
    text = (project / "fit.yaml").read_text().replace("trials/", "../trials/")
    (project / "fit.yaml").write_text(text)
    assert main(["fit", str(project / "fit.yaml"), "--out", str(tmp_path / "o"), "--allow-outside", "--dry-run"]) == 2
    assert '".."' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("texts", "system"),
    [
        (["rate: 15 in-lb/rad", "length: 1/2 in"], "inch"),
        (["arbor: 12 mm", "length: 1.25 in # 1 in, 2 in, 3 in", "mass: 3 kg"], "metric"),
        (["name: 3 in a row"], "inch"),
        (["rate: 1.7 Nm/rad"], "metric"),
        ([], "metric"),
    ],
)
def test_units_of_the_input_are_detected(texts: list[str], system: str) -> None:
    assert written_system(texts) == system


def test_a_result_s_quantity_keeps_its_meaning_in_other_units(tmp_path: Path) -> None:
    """1 N m/rad is 8.850 746 in lbf/rad (SP 811)."""
    shown = ShownUnits("inch").of({"value": 1.0, "unit": "N*m/rad", "interval90": [0.5, None]}, "N*m/rad")
    assert shown["value"] == pytest.approx(8.850746, rel=1e-6)
    assert shown["interval90"] == [pytest.approx(4.425373, rel=1e-6), None]
    (tmp_path / "a.yaml").write_text("length: 3 in\n")
    assert shown_for(None, [tmp_path / "a.yaml", tmp_path / "gone.yaml"]).system == "inch"
    assert shown_for("metric", [tmp_path / "a.yaml"]).system == "metric"


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_has_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for name in COMMANDS:
        assert name in script
        for option in options_of(parser_of(name)):
            assert all((each[2:] if shell == "fish" else each) in script for each in option.names if "--" in each)


def test_bash_completion_works(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["completion", "bash"]) == 0
    (tmp_path / "c").write_text(capsys.readouterr().out)

    def completed(*words: str) -> list[str]:
        given = " ".join(json.dumps(word) for word in words)
        code = (
            f'source c; COMP_WORDS=({given}); COMP_CWORD={len(words) - 1}; _synth; printf "%s\\n" "${{COMPREPLY[@]}}"'
        )
        done = subprocess.run(
            ["bash", "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path, timeout=30
        )
        return done.stdout.split()

    assert completed("synth", "spr") == ["spring"]
    assert completed("synth", "spring", "--uni") == ["--units"]
    assert completed("synth", "spring", "--units", "") == ["inch", "metric"]
    assert "gap" in completed("synth", "init", "g")
    assert completed("synth", "catalog", "sh") == ["show"]


@pytest.mark.parametrize("words", [["gap", "gap.yaml", "--effect", "loop.py"], ["gap", "loop.yaml"], ["fit", "loop"]])
def test_a_link_that_leads_to_itself_is_a_mistake(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(FIT.parent / "gap", tmp_path / "gap")
    monkeypatch.chdir(tmp_path / "gap")
    for name in ("loop", "loop.py", "loop.yaml"):
        Path(name).symlink_to(name)
    assert main([*words, "--out", "out"]) == 2
    assert "symbolic links" in capsys.readouterr().err
    assert not Path("out").exists()


@pytest.mark.parametrize("words", [["catalog", "list", "torsion_springs", "--catalog"], ["catalog", "check"]])
def test_a_name_that_is_too_long_is_not_echoed_whole(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "x" * 5000]) == 2
    said = capsys.readouterr().err
    assert len(said) < 1000
    assert "too long" in said


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize("name", ["a.csv", "a.mcap", "a.h5"])
def test_a_pipe_to_import_is_refused_at_once(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo(name)
    shutil.copy(FIT / "robot.leg.yaml", "robot.leg.yaml")
    assert main(["import", name, "--leg", "robot.leg.yaml", "--out", "out"]) == 2
    assert "is not a regular file" in capsys.readouterr().err
    assert not Path("out").exists()


@pytest.mark.parametrize("command", ["fit", "gap", "leg"])
def test_a_project_s_name_that_is_too_long_is_a_mistake(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "x" * 5000, "--out", "out"]) == 2
    assert "too long" in capsys.readouterr().err


def test_a_help_describes_only_words_that_its_option_takes() -> None:
    """`--release cut|free|keep` was described as `release (default): ...`."""
    described = 0
    for command in COMMANDS:
        for action in parser_of(command)._actions:
            words = getattr(action.type, "words", ())
            named = re.findall(r"(?:^|[;:] )([\w.]+)(?: \(default\))?: ", action.help or "") if words else []
            assert set(named) <= set(words), (command, action.option_strings, named)
            described += bool(named)
    assert described >= 3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["fit", str(FIT / "fit.yaml"), "--out", ""], ["--out: is empty; name a folder to make"]),
        (
            ["fit", "", "--out", "", "--log", " "],
            ["FILE: is empty; name one", "--out: is", "--log: is empty; write --log"],
        ),
        ([*SPRING, "--out", ""], ["--out: is empty; name a folder to make"]),
        ([*SPRING, "--json", ""], ["--json: is empty; write --json FILE"]),
        ([*SPRING, "--catalog", ""], ["--catalog: is empty; write --catalog FILE"]),
        (["check", ""], ["FILE: is empty; name one"]),
        (
            ["init", "gap", "", "--from", "", "--chain", ""],
            ["DIR: is empty; name a", "--from: is empty", "--chain: is"],
        ),
        (["compare", "", "--out", "x"], ["SOURCE: is empty; name one"]),
        (["catalog", "check", ""], ["NAME: is empty; name one"]),
        (["import", "", "--out", "x", "--leg", ""], ["FILE: is empty; name one", "--leg: is empty; write --leg LEG"]),
    ],
)
def test_an_empty_argument_is_named(
    words: list[str],
    said: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """As of a shell's variable that is not set.

    It stood for the current folder, without its option's name, or was passed over: a spring's files were not written.
    """
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.startswith(f"synth: {text}") for line, text in zip(lines, said, strict=True)] == [True] * len(said)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["", " "])
def test_a_folder_without_a_name_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    said = "the name of the folder to write is empty; name a folder to make"
    with pytest.raises(UserError, match=said), output_folder(name):
        pass
