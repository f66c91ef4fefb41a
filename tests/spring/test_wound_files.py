"""Files of wound samples that are no files of samples: refused, and not waited for."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from synth.errors import UserError
from synth.parts.catalogs import Catalogue
from synth.spring.evaluate import check_spring
from synth.spring.spring_task import SpringTask
from synth.spring.wound_samples import calibration_of, read_calibration, read_samples

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("read", [read_samples, read_calibration])
def test_a_pipe_a_folder_and_what_is_no_text_are_refused(tmp_path: Path, read: object) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "deep").write_text("[" * 100_000)
    for name in ("pipe", "bytes", "deep", ".", "gone"):
        with pytest.raises(UserError):
            read(tmp_path / name)  # type: ignore[operator]


def test_counts_need_no_unit(tmp_path: Path) -> None:
    said = []
    for turns, coils in (("turns [1]", "coils [1]"), ("turns", "coils"), ("Turns [turns]", "Coils [coils]")):
        path = tmp_path / "samples.csv"
        path.write_text(f"mandrel [mm],wire [mm],{turns},{coils}\n10,2,6,5.25\n", encoding="utf-8")
        said.append(read_samples(path))
    assert said[0] == said[1] == said[2]
    path.write_text("mandrel [mm],wire [mm],turns,coils [mm]\n10,2,6,5.25\n", encoding="utf-8")
    with pytest.raises(UserError, match="coils"):
        read_samples(path)


def wound(tmp_path: Path, header: str, *rows: str) -> Path:
    """A table of wound samples."""
    path = tmp_path / "samples.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("separator", [";", "\t"])
def test_semicolons_and_decimal_commas_are_read_as_an_import_reads_them(separator: str, tmp_path: Path) -> None:
    """As a spreadsheet in many languages writes a table; only "there is no column mandrel" was said."""
    header, row = "mandrel [mm],wire [mm],turns,coils,free_angle [deg]", "10.5,2,6.25,5.25,90"
    plain = read_samples(wound(tmp_path, header, row))
    other = row.replace(",", separator).replace(".", ",")
    assert read_samples(wound(tmp_path, header.replace(",", separator), other)) == plain
    assert read_samples(wound(tmp_path, "\ufeff" + header.replace(",", separator), other.replace(",", "."))) == plain
    broken = other.replace(f"{separator}2{separator}", f"{separator}2 mm{separator}")
    with pytest.raises(UserError, match=r'2: wire: "2 mm" is not a number'):
        read_samples(wound(tmp_path, header.replace(",", separator), broken))
    with pytest.raises(UserError, match="has 6 cells under 5 headers; write decimals with a point, or separate cells"):
        read_samples(wound(tmp_path, header, "10,5,2,6,5.25,90"))


def test_the_columns_of_the_documentation_give_a_coil_its_own_rate_back(tmp_path: Path) -> None:
    """A coil that has the formula's rate with its legs has a factor of 1; without the legs it was 5 % off."""
    text = (ROOT / "docs" / "build_joint.md").read_text(encoding="utf-8")
    listed = text[text.index("`wound.csv` has") :].partition("Columns of notes")[0]
    quoted = ",".join(listed.split("`")[3::2]).split(",")
    values = {
        "mandrel [mm]": "13.64", "wire [mm]": "2", "coils [1]": "5.25", "outer_diameter [mm]": "20",
        "turns [1]": "5.96", "free_angle [deg]": "90", "leg_length [mm]": "25",
    }  # fmt: skip
    music = Catalogue.load().find_material("music")
    made = check_spring(music, 2e-3, 18e-3, 5.25, SpringTask(0.7, leg_lengths=(0.025, 0.025)))
    values["rate [N*m/rad]"] = str(made.rate)
    assert set(quoted) == set(values)
    path = wound(tmp_path, ",".join(quoted), ",".join(values[name] for name in quoted))
    assert calibration_of(read_samples(path), music, "bending").rate == pytest.approx(1.0, abs=1e-6)


BASE = "mandrel [mm],wire [mm],coils [1],outer_diameter [mm]"


@pytest.mark.parametrize(
    ("header", "row", "said"),
    [
        (f"{BASE},rate [N*m/rad]", "14,2,5.25,20,0.49", ":2: rate needs its leg_length"),
        (f"{BASE},rate [N*m/rad],leg_length [mm]", "14,2,5.25,20,0.49,", ":2: rate needs its leg_length"),
        (f"{BASE},leg_length [mm]", "14,2,5.25,20,-25", ':2: leg_length: "-25" must be 0 or more'),
        (f"{BASE},leglength [mm]", "14,2,5.25,20,25", ":1: .*leglength .*did you mean leg_length"),
        (f"{BASE},rates", "14,2,5.25,20,25", ":1: .*rates.* did you mean rate"),
        (f"{BASE},lever [mm]", "14,2,5.25,20,25", ":1: .*lever .* the columns are mandrel, "),
        (f"{BASE},Wire [in]", "14,2,5.25,20,0.08", ":1: wire: the column is given twice"),
        (BASE, "14,2,5,25,20", ":2: has 5 cells under 4 headers"),
    ],
)
def test_columns_and_cells_that_would_be_ignored_are_refused(tmp_path: Path, header: str, row: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        read_samples(wound(tmp_path, header, row))


def test_notes_beside_the_samples_are_left_alone(tmp_path: Path) -> None:
    plain = read_samples(wound(tmp_path, BASE, "14,2,5.25,20"))
    assert read_samples(wound(tmp_path, f"sample,{BASE},who wound it,", "a,14,2,5.25,20,me,")) == plain


HEADER = "mandrel [mm],wire [mm],coils [1],turns [1],outer_diameter [mm],rate [N*m/rad],leg_length [mm]"


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("14,2,5.25,,20,28.07,25", "samples.csv:3: rate: 28.07 .* 57 times .*check its unit"),
        ("14,2,5.25,,20,0.0086,25", "samples.csv:3: rate: 0.0086 .* 0.0175 times"),
        ("14,2,5.25,,60,,", "samples.csv:3: springs back .* to 56 mm inside"),
        ("14,2,5.25,15,,,", "samples.csv:3: springs back"),
        ("14,2,5.25,5,,0.49,25", "samples.csv:3: turns: 5 on the mandrel cannot leave 5.25 coils"),
        ("14,2,5.25,,17.9,0.49,25", "samples.csv:3: .* 13.9 mm inside, smaller than its mandrel of 14 mm"),
        ("14,90,5.25,,200,,", "samples.csv:3: no strength known for music wire"),
    ],
)
def test_a_sample_that_cannot_be_is_refused_and_not_left_out(tmp_path: Path, row: str, said: str) -> None:
    music = Catalogue.load().find_material("music")
    path = wound(tmp_path, HEADER, "14,2,5.25,5.9,20,0.49,25", row)
    with pytest.raises(UserError, match=said):
        calibration_of(read_samples(path), music, "bending", str(path))


def calibration(tmp_path: Path, **factors: float) -> Path:
    """A calibration file with these factors."""
    content: dict[str, Any] = {
        "format": "synth/spring/calibration/1", "material": "music wire", "source": "samples.csv", "rate_formula": "64",
    }  # fmt: skip
    for name in ("spring_back", "rate"):
        content[name] = {"value": factors.get(name, 1.0), "unit": "1", "samples": 1}
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def test_a_file_with_an_impossible_factor_is_refused_for_that(tmp_path: Path) -> None:
    assert read_calibration(calibration(tmp_path, rate=0.95)).rate == 0.95
    for name, value in (("rate", 10.66), ("rate", -1.0), ("rate", float("nan")), ("spring_back", 3.0)):
        with pytest.raises(UserError, match=f"{name}: the factor {value:.4g} is impossible"):
            read_calibration(calibration(tmp_path, **{name: value}))
