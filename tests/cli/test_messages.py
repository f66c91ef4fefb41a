"""Messages: suggestions, long values, and examples of the right spelling."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import synth
from synth.cli import main
from synth.errors import LONGEST, LONGEST_WORD, Problem, did_you_mean, readable
from synth.files.csv_table import read_table

SPRING = ["spring", "--rate", "38 N*m/rad", "--travel", "60 deg", "--json", "x.json"]


def error_text(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The message of a refused command."""
    assert main(words) == 2
    return capsys.readouterr().err


def test_a_name_is_not_suggested_for_itself() -> None:
    assert did_you_mean("knee", ["knee", "hip"]) == ""
    assert did_you_mean("Knee", ["knee", "hip"]) == "; did you mean knee?"
    assert did_you_mean("kneee", ["knee", "kneel", "hip"], most=2) == "; did you mean knee or kneel?"
    for written in ("kne\u0301e", "knée\u200b"):
        assert "did you mean knée, which looks the same but is written with" in did_you_mean(written, ["knée"])


def test_a_broken_link_is_reported_without_a_suggestion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "fit.yaml").symlink_to("gone.yaml")
    text = error_text(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "out")], capsys)
    assert "fit.yaml: does not exist: it is a link that leads nowhere" in text
    assert "did you mean" not in text


@pytest.mark.parametrize("end", ["\r", "\r\n", "\n"])
def test_all_line_endings_are_read(tmp_path: Path, end: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(end.join(["time [s],hip [deg]", "0,1", "0.5,2", "1,"]).encode())
    table = read_table(path)
    np.testing.assert_array_equal(table.values, [[0.0, 1.0], [0.5, 2.0], [1.0, np.nan]])
    assert table.line(2) == 4


@pytest.mark.parametrize(
    ("option", "example"), [("--coils", "5.25"), ("--cycles", "1e6"), ("--safety", "1.2"), ("--fatigue-safety", "1.2")]
)
def test_a_wrong_plain_number_is_reported_with_an_example(
    option: str, example: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = error_text([*SPRING, option, "many"], capsys)
    assert f'{option}: "many" is not a number above 0; write it like {example}' in text
    assert "%" not in text


@pytest.mark.parametrize(
    "command", [["check"], ["fit", "--out", "o"], ["compare", "--out", "o"], ["gap", "--out", "o"]]
)
def test_a_leg_file_without_its_kind_is_recognised(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("name: shank\njoints: [{name: knee}]\n")
    text = error_text([command[0], str(path), *command[1:]], capsys)
    assert '"kind" is missing' in text
    assert 'write "kind: leg" as the first line' in text


@pytest.mark.parametrize("command", [["check"], ["compare", "--out", "o"]])
@pytest.mark.parametrize(
    ("kind", "said"), [("[leg]", "['leg'] is no kind of file"), ("Leg", "did you mean leg?"), ("import", "import")]
)
def test_a_file_of_another_kind_is_refused_without_naming_another_command(
    command: list[str], kind: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"kind: {kind}\nname: shank\n")
    text = error_text([command[0], str(path), *command[1:]], capsys)
    assert said in text
    assert "synth hopper" not in text
    assert "hopper-design?" not in text


def test_the_kind_of_a_file_is_inferred_from_its_keys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.yaml"
    for text, kind in (
        ("gear_ratio: 20\nruns: [a.csv]\n", "hopper-motor"),
        ("design: hopper.yaml\nbody_mass: 1 kg\ntrials: [a.csv]\n", "hopper-pull-ups"),
        ("design: hopper.yaml\njumps: [a.csv]\n", "hopper-jumps"),
        ("lengths: [100 mm]\n", "hopper-design"),
    ):
        path.write_text(text)
        assert f'write "kind: {kind}" as the first line' in error_text(
            ["hopper", str(path), "--out", str(tmp_path / "out")], capsys
        )


@pytest.mark.parametrize("value", ["x" * 5000, "x y " * 1250])
def test_a_long_value_is_shortened_in_the_message(
    tmp_path: Path, value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.yaml"
    path.write_text(f"kind: {value}\n")
    (tmp_path / "a.leg.yaml").write_text("kind: leg\n")
    out = ["--out", str(tmp_path / "out")]
    assert len(error_text(["fit", str(path), *out], capsys)) < 700
    path.write_text(f'kind: fit\nleg: "{value}"\ntrials: ["{value}", {{file: "{value}"}}]\n{value}: 1\n')
    text = error_text(["fit", str(path), *out], capsys)
    assert max(map(len, text.splitlines())) < 700
    assert len(error_text(["spring", "--rate", value, "--travel", "1 rad"], capsys)) < 700
    assert len(error_text([value], capsys)) < 700
    assert len(str(Problem(f"it says {value}"))) <= LONGEST + 100


def literals(path: Path) -> list[str]:
    """The texts of a module that might be shortened, with XX for what is filled in; without docstrings."""
    left, found = [ast.parse(path.read_text(encoding="utf-8"))], list[str]()
    while left:
        node: ast.AST = left.pop()
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.append(node.value)
        elif isinstance(node, ast.JoinedStr):
            found.append("".join(str(part.value) if isinstance(part, ast.Constant) else "XX" for part in node.values))
        elif not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            left += ast.iter_child_nodes(node)
    return [text for text in found if LONGEST_WORD < len(text) < 900 and "\n" not in text]


def test_no_text_of_the_program_loses_its_middle() -> None:
    """The closing mark of one word in quotes was paired with the opening one of the next, and two apostrophes too."""
    root = Path(synth.__file__).parent
    modules = [*root.rglob("*.py"), *(root / "cad").rglob("*.py"), *(root / "reports").rglob("*.py")]
    texts = {text for path in modules for text in literals(path)}
    assert len(texts) > 400
    assert {text: readable(text) for text in texts if readable(text) != text} == {}


@pytest.mark.parametrize("mark", ['"', "'"])
def test_only_what_stands_in_quotes_is_shortened(mark: str) -> None:
    between = "the leg's and the links' own words stand here, " * 3
    long = "x y " * 50
    for value in (long, f"it{mark}s so " + long):
        text = f"{mark}a{mark} {between}{mark}{value}{mark} is not allowed: {between}{mark}b{mark}"
        cut = f"{mark}{value[: LONGEST_WORD - 3]}...{mark}"
        assert readable(text) == f"{mark}a{mark} {between}{cut} is not allowed: {between}{mark}b{mark}"


def test_a_fit_without_trials_says_all_that_may_be_stated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "fit.yaml").write_text("kind: fit\n")
    text = error_text(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "out")], capsys)
    assert '"trials" is missing: write it, for example trials: [trials/*.csv], or state characteristics under ' in text
