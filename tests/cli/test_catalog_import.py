"""``synth catalog import`` into a folder that holds other tables: nothing of the user's is lost."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from synth.cli import main
from synth.files import added_files
from synth.files.added_files import add_files
from synth.files.paths import matching
from synth.parts.catalogs import Catalogue

HEAD = "Part Number,Wire Dia. (in),O.D. (in),Coils,Leg Angle (deg),Torque (in-lb),Deflection (deg)\n"
ROW = ",0.08,0.75,6.17,120,4.18,100\n"
DAMPERS = "Part Number,Torque (in-oz),Max Speed (RPM)\nD1,31,50\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of tables with Alpha's A1 and A2, and a table of the user's."""
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "my_parts"
    made.mkdir()
    (made / "measured.csv").write_text("part,rate [N*m/rad]\nM1,0.5\n")
    assert imported("A1" + ROW + "A2" + ROW, "Alpha") == 0
    return made


def imported(rows: str, vendor: str, *more: str, head: str = HEAD) -> int:
    Path("table.csv").write_text(head + rows)
    return main(["-q", "catalog", "import", "table.csv", "--vendor", vendor, "--out", "my_parts", *more])


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_only_the_vendor_s_file_is_replaced(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The second import deleted the first vendor's file, edited or not."""
    edited = folder / "alpha.csv"
    edited.write_text(edited.read_text() + "A3,2.032,19.05,6.17,120,0.47,100,Alpha\n")
    before = contents(folder)
    assert imported("B1" + ROW, "Beta") == 0
    after = contents(folder)
    assert {name: after[name] for name in ("alpha.csv", "measured.csv")} == {
        name: before[name] for name in ("alpha.csv", "measured.csv")
    }
    assert sorted(after) == [".synth-added", "alpha.csv", "beta.csv", "measured.csv"]
    capsys.readouterr()
    assert imported("B2" + ROW, "Beta", "--json") == 0
    assert json.loads(capsys.readouterr().out)["gone"] == {"my_parts/beta.csv": ["B1"]}
    assert imported("B1" + ROW, "Beta") == 0
    assert "my_parts/beta.csv: replaced; parts of it that this table lacks (1): B2" in capsys.readouterr().out


def test_a_changed_file_is_not_replaced(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = folder / "alpha.csv"
    written = own.read_text()
    own.write_text(written.replace("A2,", "A2 measured,"))
    before = contents(folder)
    assert imported("A1" + ROW, "Alpha") == 2
    message = capsys.readouterr().err
    assert "my_parts/alpha.csv: was changed since its import" in message
    assert "my_parts/alpha_own.csv" in message
    assert contents(folder) == before
    own.rename(folder / "alpha_own.csv")  # as the message says
    assert imported("A1" + ROW, "Alpha") == 0
    own.write_text(written)  # what the first import wrote holds nothing of the user's
    assert imported("A1" + ROW, "Alpha") == 0
    (folder / "gamma.csv").write_text("part,rate [N*m/rad]\nG1,0.5\n")
    assert imported("G1" + ROW, "Gamma") == 2
    assert "my_parts/gamma.csv: was not written by synth catalog import" in capsys.readouterr().err


def test_rows_kept_in_a_file_of_one_s_own_replace_the_imported(folder: Path) -> None:
    """As the refusal says: the files of a project's pattern are read in order, alpha_own.csv after alpha.csv."""
    (folder / "alpha_own.csv").write_text((folder / "alpha.csv").read_text().replace("A2,2.032,", "A2,2.5,"))
    catalogue = Catalogue.load(matching(folder.parent, "my_parts/*.csv"))
    assert catalogue.find_spring("A2").wire_diameter == pytest.approx(2.5e-3)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("A1,-1,0.75,6.17,120,4.18,100\n", 'table.csv:2: Wire Dia. (in): "-1" must be above 0'),
        ("A1" + ROW + "\nA1" + ROW, "table.csv:4: Part Number: Alpha A1 is given twice in this table, first in line 2"),
        ("A\x07" + ROW, "table.csv:2: Part Number"),
    ],
)
def test_a_refused_table_leaves_the_folder_as_it_was(
    folder: Path, capsys: pytest.CaptureFixture[str], rows: str, said: str
) -> None:
    """It was written first and checked then: a table with mistakes took the place of a good one."""
    before = contents(folder)
    assert imported(rows, "Alpha") == 2
    assert said in capsys.readouterr().err
    assert contents(folder) == before
    assert main(["-q", "catalog", "import", "table.csv", "--vendor", "Alpha", "--out", "new/folder"]) == 2
    assert not Path("new").exists()


def test_what_only_the_whole_catalogue_refuses_is_named_in_the_vendor_s_table(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The converted files are loaded before anything is written; their mistakes are shown at their origin."""
    monkeypatch.setattr("synth.parts.catalog_import.require_allowed", lambda value, *_: value)
    before = contents(folder)
    assert imported("\nA1" + ROW + "A2,-1,0.75,6.17,120,4.18,100\n", "Alpha") == 2
    assert 'table.csv:4: Wire Dia. (in): "-25.4" must be above 0' in capsys.readouterr().err
    assert contents(folder) == before


def test_other_parts_under_the_same_file_name_are_not_replaced(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = contents(folder)
    assert imported("", "Alpha", head=DAMPERS) == 2
    assert "has the torsion springs of an earlier import, which these dampers would replace" in capsys.readouterr().err
    assert imported("A1" + ROW, "Alpha!") == 2
    assert "has parts of Alpha from an earlier import" in capsys.readouterr().err
    assert contents(folder) == before
    assert main(["-q", "catalog", "import", "table.csv", "--vendor", "Alpha", "--out", "my_parts/measured.csv/x"]) == 2
    assert contents(folder) == before


@pytest.mark.parametrize("name", [".synth-output", ".synth-added"])
def test_a_folder_that_cannot_be_added_to_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """A run's result, which its next run replaces whole; a record that is none."""
    (folder / name).write_text("report.html\n")
    assert imported("A1" + ROW, "Alpha") == 2
    assert f"my_parts/{name}" in capsys.readouterr().err


def test_a_link_is_not_followed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "beta.csv").symlink_to(folder / "measured.csv")
    before = contents(folder)
    assert imported("B1" + ROW, "Beta") == 2
    assert "my_parts/beta.csv: is a link" in capsys.readouterr().err
    assert contents(folder) == before


def test_a_kill_between_two_files_leaves_both_known(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each file is whole, and both its old and its new content count as imported."""
    add_files(folder, {"one.csv": b"1\n", "two.csv": b"1\n"})
    write, written = added_files.write_bytes_whole, []

    def killed(path: Path, *more: object) -> None:
        if written[-1:] == ["one.csv"]:
            raise KeyboardInterrupt
        write(path, *more)  # type: ignore[arg-type]
        written.append(path.name)

    monkeypatch.setattr(added_files, "write_bytes_whole", killed)
    with pytest.raises(KeyboardInterrupt):
        add_files(folder, {"one.csv": b"2\n", "two.csv": b"2\n"})
    monkeypatch.undo()
    assert ((folder / "one.csv").read_bytes(), (folder / "two.csv").read_bytes()) == (b"2\n", b"1\n")
    (folder / ".two.csv.x1.partial").write_bytes(b"2")  # what a kill within a file's writing leaves
    add_files(folder, {"one.csv": b"3\n", "two.csv": b"3\n"})
    assert not list(folder.glob("*.partial"))


def test_permissions_of_new_and_standing_files(folder: Path) -> None:
    assert (folder / "alpha.csv").stat().st_mode & 0o777 == (folder / "measured.csv").stat().st_mode & 0o777
    (folder / "alpha.csv").chmod(0o640)
    assert imported("A1" + ROW, "Alpha") == 0
    assert (folder / "alpha.csv").stat().st_mode & 0o777 == 0o640
