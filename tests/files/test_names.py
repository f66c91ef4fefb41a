"""No name in a user's file leads a result out of its folder; a name that cannot name a file is refused when read."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth.cad.dimensions import _NAME as CAD_NAME
from synth.cad.parts import file_name
from synth.cli import main
from synth.errors import UserError
from synth.files.leg_file import read_leg
from synth.files.names import mixed_files, name_fault, same_file, title_fault, written_name
from synth.files.output import output_folder, place, stems, write_csv, write_json, write_text
from synth.files.paths import inside, matching

ROOT = Path(__file__).resolve().parents[2]
JOINT = """\
  - name: {name}
    zero: 90 deg
    sign: +1
    link: {{length: 200 mm, mass: 740 g, com: 91 mm, inertia: 3.5e-3 kg*m^2}}
"""
OUTSIDE = ["../../x", "/tmp/x", "..", ".", "a/b", "a\\b", "..\\x", "C:x", "~root", ".hidden", "x.", "x ", " x", "-x"]
UNPRINTED = ["a\nb", "a\tb", "a\x00b", "a\x1b[31mb", "a\u202eb", "a\u200bb", "\ud800"]
MARKUP = ["<b>", "a&b", "=1+1", "a,b", "a;b", "@x", "a'b", 'a"b', "a%sb", "a*b", "${x}", "x" * 61, ""]


def quoted(text: str) -> str:
    """The text as a YAML double-quoted scalar."""
    return '"' + "".join(c if c.isalnum() or c in " -./" else f"\\U{ord(c):08x}" for c in text) + '"'


@pytest.mark.parametrize("name", [*OUTSIDE, *UNPRINTED[:-1], *MARKUP])
def test_a_joint_is_not_called_by_a_path_markup_or_what_cannot_be_printed(name: str, tmp_path: Path) -> None:
    file = tmp_path / "bad.leg.yaml"
    file.write_text(f"kind: leg\nname: bad\njoints:\n{JOINT.format(name='good')}{JOINT.format(name=quoted(name))}")
    with pytest.raises(UserError) as caught:
        read_leg(file)
    (problem,) = [p for p in caught.value.problems if "name" in (p.key or "")]
    assert problem.line == 8
    assert problem.file == str(file)


@pytest.mark.parametrize("name", ["hip", "Hüfte", "膝", "knee 2", "left_hip", "tarsus-1", "j.1", "1st"])
def test_letters_of_every_alphabet_digits_and_four_signs_name_a_joint(name: str, tmp_path: Path) -> None:
    file = tmp_path / "good.leg.yaml"
    file.write_text(f"kind: leg\nname: good\njoints:\n{JOINT.format(name=quoted(name))}")
    assert read_leg(file).joint_names == (name,)


@pytest.mark.parametrize(("first", "second"), [("hip", "Hip"), ("left hip", "left_hip"), ("straße", "STRASSE")])
def test_two_joints_whose_files_a_disk_may_take_for_one_are_refused(first: str, second: str, tmp_path: Path) -> None:
    file = tmp_path / "twice.leg.yaml"
    joints = JOINT.format(name=quoted(first)) + JOINT.format(name=quoted(second))
    file.write_text(f"kind: leg\nname: twice\njoints:\n{joints}")
    with pytest.raises(UserError, match="share their files"):
        read_leg(file)
    assert same_file([first, "other"], second) == first


def test_drawings_of_a_joint_and_of_a_part_of_another_are_distinguished() -> None:
    assert mixed_files(["hip", "knee", "knee 2", "hip_roll", "legs"]) is None
    assert "rename" in (mixed_files(["knee", "knee upper"]) or "")
    assert "whole leg" in (mixed_files(["Leg"]) or "")
    assert "whole leg" in (mixed_files(["leg_assembly"]) or "")


@given(st.text(max_size=70))
def test_cad_draws_what_the_reader_lets_in(name: str) -> None:
    assert (name_fault(name) is None) == (CAD_NAME.fullmatch(name) is not None)


@pytest.mark.parametrize("name", [*UNPRINTED[:-1], "", "x" * 201])
def test_a_leg_is_not_titled_with_what_cannot_be_printed(name: str, tmp_path: Path) -> None:
    file = tmp_path / "bad.leg.yaml"
    file.write_text(f"kind: leg\nname: {quoted(name)}\njoints:\n{JOINT.format(name='hip')}")
    with pytest.raises(UserError) as caught:
        read_leg(file)
    assert [(p.key, p.line) for p in caught.value.problems] == [("name", 2)]
    assert title_fault("robot leg, as built (2 of 3)") is None


@pytest.mark.parametrize("name", UNPRINTED)
def test_files_whose_names_cannot_be_printed_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"U\+"):
        inside(tmp_path, name)
    if "\x00" not in name and name != "\ud800":
        (tmp_path / f"{name}.csv").write_text("")
        with pytest.raises(UserError, match=r"U\+"):
            matching(tmp_path, "*.csv")


@pytest.mark.parametrize("name", ["../x.csv", "../../x.csv", "{elsewhere}/x.csv", "link/x.csv", "link.csv", "."])
def test_the_writer_reaches_nothing_outside_its_folder(name: str, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "x.csv").write_text("mine")
    with output_folder(tmp_path / "out") as folder:
        (folder / "link").symlink_to(elsewhere)
        (folder / "link.csv").symlink_to(elsewhere / "x.csv")
        path = folder / name.format(elsewhere=elsewhere)
        for write in (
            lambda: write_csv(path, {"a": [1.0]}),
            lambda: write_json(path, {}),
            lambda: write_text(path, "x"),
            lambda: place(folder, name.format(elsewhere=elsewhere)),
        ):
            with pytest.raises(UserError, match="leads out"):
                write()
        (folder / "link").unlink()
        (folder / "link.csv").unlink()
    assert [path.name for path in (tmp_path / "out").iterdir()] == [".synth-output"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elsewhere", "out"]
    assert {path.name: path.read_text() for path in elsewhere.iterdir()} == {"x.csv": "mine"}


def test_two_names_that_give_one_file_are_reported_and_nothing_is_overwritten(tmp_path: Path) -> None:
    write_text(place(tmp_path, "a.csv"), "1")
    with pytest.raises(UserError, match="written twice"):
        place(tmp_path, "a.csv")


def test_every_file_that_is_called_by_a_name_goes_through_place() -> None:
    writers = {"write_csv", "write_curve", "write_json", "write_text", "copytree"}
    wrong = []
    for path in sorted((ROOT / "synth").rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(call, ast.Call) or _called(call) not in writers:
                continue
            for argument in call.args[:2]:
                placed = isinstance(argument, ast.Call) and _called(argument) == "place"
                named = any(isinstance(node, ast.JoinedStr | ast.Attribute) for node in _right_of_slash(argument))
                if named and not placed:
                    wrong.append(f"{path.relative_to(ROOT)}:{call.lineno}")
    assert not wrong


def _called(call: ast.Call) -> str:
    return getattr(call.func, "id", None) or getattr(call.func, "attr", "")


def _right_of_slash(node: ast.AST) -> list[ast.AST]:
    return [n.right for n in ast.walk(node) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Div)]


@pytest.mark.parametrize("name", ["../../x", "{outside}/x"])
def test_synth_leg_writes_nothing_outside_whatever_its_joints_are_called(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    project, outside = tmp_path / "deep" / "project", tmp_path / "outside"
    shutil.copytree(ROOT / "synth" / "examples" / "leg", project)
    outside.mkdir()
    (outside / "x.csv").write_text("mine")
    wicked = name.format(outside=outside)
    for leg in (project / "animal" / "animal.leg.yaml", project / "robot" / "robot.leg.yaml"):
        leg.write_text(leg.read_text().replace("name: hip", f'name: "{wicked}"'))
    for table in project.rglob("*.csv"):
        table.write_text(table.read_text().replace("hip", wicked))
    before = sorted(path for path in tmp_path.rglob("*"))
    design = project / "leg-design.yaml"
    design.write_text(
        design.read_text().replace("hip:", f'"{wicked}":').replace("locked: [hip", f'locked: ["{wicked}"')
    )
    assert main(["leg", str(design), "--out", str(tmp_path / "deep" / "result"), "--no-cad", "--no-cache"]) == 2
    told = capsys.readouterr().err
    assert "cannot be a joint's name" in told
    assert "animal.leg.yaml:7" in told
    assert sorted(path for path in tmp_path.rglob("*")) == before
    assert (outside / "x.csv").read_text() == "mine"


@given(st.text(max_size=90))
def test_files_that_we_write_are_called_by_the_joints_rule(name: str) -> None:
    """Of any name but one that is empty; twice the same is the same."""
    written = written_name(name)
    assert written_name(written) == written
    assert written == "_" or name_fault(written) is None
    assert stems([name, name])[0] != stems([name, name])[1]
    if name_fault(name) is None:
        assert written == name


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "..", ".hidden", "a\\b", ""])
def test_cad_calls_no_file_by_a_path(name: str) -> None:
    with pytest.raises(ValueError, match="cannot be called"):
        file_name(name)
