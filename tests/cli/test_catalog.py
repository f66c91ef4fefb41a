"""``synth catalog``: list, show, check."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from synth.cli import main
from synth.parts.catalogs import catalog_folder
from synth.parts.rows import FAMILIES

DAMPERS = "part,vendor,direction,continuous,max_torque [N*m],speed [rpm]\n"


def shown(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> list[str]:
    """The lines on stdout, or with status 2 those on stderr."""
    assert main(["catalog", *words]) == status
    captured = capsys.readouterr()
    assert (captured.out if status else captured.err) == ""
    return (captured.err if status else captured.out).splitlines()


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A table of the user's with markup in it; terminal codes are refused when it is read."""
    path = tmp_path / "mine.csv"
    path.write_text(DAMPERS + "<b>D1</b>,<i>Me</i> & Co,both,yes,0.3,50\n", encoding="utf-8")
    return path


def test_list_counts_every_row(capsys: pytest.CaptureFixture[str]) -> None:
    table = {cells[0]: list(map(int, cells[1:])) for line in shown(capsys, "list")[2:-1] if (cells := line.split())}
    assert sorted(table) == sorted(FAMILIES)
    for family, (rows, *parts) in table.items():
        with (catalog_folder() / f"{family}.csv").open(encoding="utf-8", newline="") as stream:
            assert rows == sum(1 for _ in csv.DictReader(stream)), family
        assert sum(parts) == rows


def test_list_shows_the_rows_of_a_family(capsys: pytest.CaptureFixture[str], mine: Path) -> None:
    lines = shown(capsys, "list", "dampers", "--catalog", str(mine))
    assert lines[0].startswith("part ")
    assert "max_torque [N*m]" in lines[0]
    assert "source" not in lines[0]
    (own,) = (line for line in lines if line.startswith("<b>D1</b>"))
    assert "<i>Me</i> & Co" in own
    assert len(lines) - len(shown(capsys, "list", "dampers")) == 1


def test_show_prints_values_source_and_derived_values(capsys: pytest.CaptureFixture[str]) -> None:
    lines = {line.partition("  ")[0]: line.partition("  ")[2].strip() for line in shown(capsys, "show", "6597k19")}
    assert lines["max_torque"] == "0.218908 N*m"  # 31 ozf in
    assert lines["speed"] == "50 rpm"
    assert lines["= rate at the published point"].startswith("0.04181 N*m*s/rad")  # 0.218908 / 5.23599
    assert lines["source"]
    assert lines["stands in"] == "catalogs/dampers.csv:3"


def test_show_compares_a_spring_with_its_geometry(capsys: pytest.CaptureFixture[str]) -> None:
    text = "\n".join(shown(capsys, "show", "LTR135H 10 M"))
    assert "26.035 mm" in text  # 29.464 - 3.429
    assert "2.233 N*m/rad (+0.4% of the published)" in text  # 193 GPa 3.429^4 / (64 26.035 7.17)
    assert "contradiction" in "\n".join(shown(capsys, "show", "9271K272"))


@pytest.mark.parametrize("name", ["music", "A228", "Music Wire"])
def test_show_accepts_the_names_of_wire_materials(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(capsys, "show", name)
    assert lines[0].startswith("music wire: ")
    assert sum(line.startswith("source ") for line in lines) > 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["lst"], "did you mean list?"),
        (["list", "damper"], 'no catalogue "damper"; did you mean dampers'),
        (["list", "dampers", "wire_materials"], "takes one family"),
        (["show"], "takes one part"),
        (["show", "6597k1"], "did you mean 6597K21 or 6597K19 or"),
        (["show", "<script>"], 'no part or wire material "<script>"'),
        (["check", "nowhere.csv"], "nowhere.csv: does not exist"),
        ([], "required"),
    ],
)
def test_a_wrong_catalog_command_gives_one_message(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (line,) = shown(capsys, *words, status=2)
    assert line.startswith("synth: ")
    assert message in line


def test_check_of_a_clean_table(capsys: pytest.CaptureFixture[str], mine: Path) -> None:
    assert shown(capsys, "check", str(mine)) == ["1 checked, no mistakes"]
    assert shown(capsys, "check", str(mine), "-q") == []


def test_check_reports_every_mistake(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    dampers, springs = tmp_path / "dampers.csv", tmp_path / "springs.csv"
    dampers.write_text(DAMPERS + "A,Me,bth,yes,0.3,50\nB,Me,both,yes,much,50\n", encoding="utf-8")
    springs.write_text(
        "part,rate [N*m/rad],material,wire_diameter [mm],outer_diameter [mm],body_coils [1]\n"
        "S1,9,music wire,1.0,11.0,5.25\n",  # 196.5 GPa 1^4 / (64 10 5.25) = 0.06 N m/rad
        encoding="utf-8",
    )
    lines = shown(capsys, "check", str(dampers), str(springs), status=2)
    assert [line.split(": ")[1] for line in lines] == [f"{dampers}:2", f"{dampers}:3", f"{springs}:2"]
    assert 'did you mean "both"?' in lines[0]
    assert '"much"' in lines[1]
    assert "9 N*m/rad published, its geometry gives 0.0" in lines[2]


def test_check_of_the_built_in_tables_lists_flagged_rows(capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(capsys, "check")
    assert lines[-1] == "the built-in catalogues have no other mistakes"
    assert any("9271K272" in line for line in lines)
    assert all(line.startswith("flagged, not used: ") for line in lines[:-1])
