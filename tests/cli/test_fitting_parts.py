"""``synth catalog show knee.yaml``: parts that fit a joint, reasons why others do not, and hostile names."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from synth.cli import main
from synth.parts.catalogs import Catalogue

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "leg"
WISH = """kind: part-wish
spring: {rate: 2.2 N*m/rad, rate_tolerance: 10 %, included_angle: 120 deg, max_outer_diameter: 1.25 in, parallel: 2}
damper: {torque: 0.1 N*m, speed: 10 rpm, ratios: [1, 1.5]}
catalogs: [parts/*.csv]
"""
HEAD = (
    "part,vendor,material,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],body_coils [1]\n"
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    # E d^4 / (64 D N) of 3.2 mm wire, E 193 GPa: 2.26 N m/rad at D 27 mm, N 5.17; 1.13 at twice the coils
    (tmp_path / "parts" / "mine.csv").write_text(
        HEAD + "=cmd|' /C calc'!A0,<b>V</b>,music wire,120,2.26,3.2,30.2,5.17\n"
        "H/2 ../x,V,music wire,120,1.13,3.2,30.2,10.17\nBig,V,music wire,120,2.3,4.0,60,6.17\n"
    )
    (tmp_path / "knee.yaml").write_text(WISH)
    return tmp_path


def shown(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert main(["catalog", "show", *words]) == 0
    return capsys.readouterr().out.splitlines()


def test_fitting_parts_are_listed_nearest_first_in_both_unit_systems(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = shown(capsys, "knee.yaml")
    assert lines[0] == "springs of 2.2 N*m/rad: 3 fit:"
    assert [line.split("  ")[0] for line in lines[3:6]] == ["LTR135H 10 M", "=cmd|' /C calc'!A0", "2 x H/2 ../x"]
    lee = lines[3].split()
    assert lee[-10:-2] == ["0.3437", "+1%", "3.429", "0.135", "29.46", "1.16", "7.17", "120"]  # 0.34367 in-lb/deg
    dampers = next(k for k, line in enumerate(lines) if line.startswith("dampers of 0.1 N*m at 10 rpm"))
    # 0.218908 N m at 50 rpm by the law of 0.47: 0.218908 / 5^0.47 = 0.1027 at 10 rpm, the curve's chord a little less
    assert lines[dampers + 3].split()[:3] == ["6597K19", "McMaster-Carr", "0.1022"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("without: [Lee Spring]", 'knee.yaml:5: without[1]: "Lee Spring" is no part in the catalogues'),
        (
            "vendors: [McMaster-Carr, Lee Sprng]",
            'vendors[2]: "Lee Sprng" is no vendor in the catalogues; did you mean Lee',
        ),
    ],
)
def test_unknown_vendors_and_parts_to_leave_out_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], line: str, message: str
) -> None:
    (folder / "knee.yaml").write_text(f"{WISH}{line}\n")
    assert main(["catalog", "show", "knee.yaml"]) == 2
    assert message in capsys.readouterr().err


def test_reasons_are_given_for_parts_that_do_not_fit(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "\n".join(shown(capsys, "knee.yaml"))
    assert "outer diameter over 31.75 mm" in text  # Big
    assert "-31%   complete  rate not within 10% of 2.2 N*m/rad; included angle is not 120 deg" in text  # 9271K589
    assert "torque not within 50% of 0.1 N*m" in text
    assert "incomplete: no rate" in text
    (folder / "knee.yaml").write_text(WISH + "vendors: [Lee Spring]\nwithout: [LTR135H 10 M]\n")
    text = "\n".join(shown(capsys, "knee.yaml"))
    assert "springs of 2.2 N*m/rad: 0 fit" in text
    assert "excluded by select.without" in text
    assert "not of Lee Spring" in text


def test_springs_that_do_not_bear_the_travel_do_not_fit(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """LTR080F 10 S reaches its allowable moment, 0.771 N m by Shigley's Table 10-4, at 93 deg; it fitted 170 deg."""
    request = "kind: part-wish\nspring: {rate: 0.47 N*m/rad, travel: %s}\ncatalogs: [parts/*.csv]\n"
    limits = HEAD.strip() + ",max_deflection [deg],max_torque [N*m]\n"
    # E d^4 / (64 D N) of 2 mm music wire, E 196.5 GPa: 0.47 N m/rad at D 17 mm, N 6.17
    (folder / "parts" / "limits.csv").write_text(
        limits + "Turned,V,music wire,120,0.47,2,19,6.17,50,\nLoaded,V,music wire,120,0.47,2,19,6.17,,0.4\n"
    )
    (folder / "wish.yaml").write_text(request % "170 deg")
    lines = shown(capsys, "wish.yaml")
    assert lines[0] == "springs of 0.47 N*m/rad: 0 fit"
    why = {line.split("  ")[0]: line.split("  ")[-1] for line in lines}
    assert why["LTR080F 10 S"] == "yields within 170 deg"
    (folder / "wish.yaml").write_text(request % "60 deg")
    lines = shown(capsys, "wish.yaml")
    why = {line.split("  ")[0]: line.split("  ")[-1] for line in lines}
    assert why["Turned"] == "turned 60 deg, beyond its vendor's max_deflection"
    assert why["Loaded"] == "loaded beyond its vendor's max_torque at 60 deg"
    fits = next(line for line in lines if line.startswith("LTR080F 10 S"))
    angle, status = fits.split()[-2:]
    assert 80.0 < float(angle) < 95.0
    assert status == "complete"


def test_usable_parts_are_listed_with_their_status(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They were counted as unusable, although ``synth leg`` chooses them."""
    (folder / "wish.yaml").write_text(
        "kind: part-wish\nspring: {}\ndamper: {torque: 1 N*m, speed: 10 rpm, parallel: 2, travel: 90 deg}\n"
    )
    assert main(["catalog", "show", "wish.yaml", "--json"]) == 0
    springs, dampers = json.loads(capsys.readouterr().out)["wishes"]
    catalogue = Catalogue.load()
    for block, rows in ((springs, catalogue.springs), (dampers, catalogue.dampers)):
        assert sum(block["cannot_be_used"].values()) == sum(not row.choosable for row in rows)
        assert not any(status.startswith("usable") for status in block["cannot_be_used"])
        assert {row["status"] for row in block["do_not"]} <= {"complete", "usable"}
    assert {row["spring"] for row in springs["fit"]} == {row.part for row in catalogue.springs if row.choosable}
    assert {row["status"] for row in springs["fit"]} == {row.status for row in catalogue.springs if row.choosable}
    found = next(row for row in dampers["fit"] if "TD99 (H)" in row["damper"])
    assert found["status"].startswith("usable: ")
    assert " at " in found["damper"]  # the torque to order


def test_dampers_that_cannot_be_arranged_stand_once_at_their_place(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One-way dampers, without a pair, by their torque to order; their distance was none, so they stood before all."""
    for asked, off in (("torque: 1 N*m, speed: 10 rpm", True), ("direction: both", False)):
        (folder / "wish.yaml").write_text(f"kind: part-wish\ndamper: {{{asked}}}\n")
        assert main(["catalog", "show", "wish.yaml", "--json"]) == 0
        (dampers,) = json.loads(capsys.readouterr().out)["wishes"]
        one_way = [row for row in dampers["do_not"] if "damps one way only" in row["why"]]
        assert len(one_way) == sum(row.choosable and row.direction != "both" for row in Catalogue.load().dampers)
        assert all(bool(row["off"]) == off for row in one_way)
        assert any(" at " in row["part"] for row in one_way) == off


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind: part-wish\n", "requests nothing"),
        ("kind: part-wsh\n", "did you mean"),
        ("kind: leg-design\n", 'is read by "synth leg"'),
        ("kind: part-wish\nspring: {rate: 2.2}\n", "spring.rate"),
        ("kind: part-wish\nspring: {rate: 2.2 N*m/rad, rate_tolerence: 5 %}\n", "rate_tolerance"),
        ("kind: part-wish\ndamper: {torque: 1 N*m}\n", "give both or neither"),
        ("kind: part-wish\nspring: {rate: 2.2 N*m/rad}\ncatalogs: [none/*.csv]\n", "none/*.csv"),
    ],
)
def test_invalid_requests_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], text: str, message: str
) -> None:
    (folder / "knee.yaml").write_text(text)
    assert main(["catalog", "show", "knee.yaml"]) == 2
    assert message in capsys.readouterr().err


def test_hostile_part_names_are_escaped(folder: Path) -> None:
    """Through the whole of a leg: defused in the list of parts, escaped on the page, no file outside the folder."""
    shutil.copytree(EXAMPLE, folder / "leg")
    (folder / "leg" / "parts").mkdir()
    (folder / "leg" / "parts" / "mine.csv").write_text(
        HEAD + "=cmd|' /C calc'!A0,<script>alert(1)</script>,music wire,90,0.6,1.5,17.3,1.75\n"
        "../../x <b>1</b>,@V,music wire,90,1.65,2.2,19.6,2.25\n"
    )
    path = folder / "leg" / "leg-design.yaml"
    chosen = """  joints:
    ankle: {spring: {part: "=cmd|' /C calc'!A0"}}
    knee: {spring: {part: ../../x <b>1</b>}}"""
    dropped = ("dampers:", "  knee: {part", "    ankle:", "    knee:")
    lines = [line for line in path.read_text().splitlines() if not line.startswith(dropped)]
    text = "\n".join(chosen if line.strip() == "joints:" else line for line in lines) + "\n"
    text = text.replace("release_*.csv", "release_[12].csv", 1)
    path.write_text(text.replace("select:", "select:\n  catalogs: [parts/*.csv]", 1))
    out = folder / "out"
    assert main(["-q", "leg", str(path), "--out", str(out), "--no-cad"]) == 0
    with (out / "bom.csv").open(newline="") as stream:
        cells = [cell for row in csv.reader(stream) for cell in row]
    assert "'=cmd|' /C calc'!A0" in cells
    assert "'@V" in cells
    assert not any(cell.lstrip()[:1] in ("=", "+", "@") for cell in cells)
    page = (out / "report.html").read_text()
    assert "<script>alert" not in page
    assert "<b>1</b>" not in page
    assert "&lt;b&gt;1&lt;/b&gt;" in page
    design = json.loads((out / "design.json").read_text())
    assert design["joints"]["knee"]["spring"]["part"] == "../../x <b>1</b>"
    assert {path.name for path in folder.iterdir()} == {"parts", "knee.yaml", "leg", "out"}
