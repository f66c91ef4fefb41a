"""``synth spring`` from the command line to the files for a workshop."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synth.cli import main

WISH = ["--rate", "1.7 N*m/rad", "--travel", "40 deg", "--included-angle", "120 deg", "--arbor", "12 mm"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def spring(*words: str) -> dict[str, Any]:
    """The result of a run that ends well."""
    assert main(["spring", "-q", *words, "--json", "spring.json"]) == 0
    content: dict[str, Any] = json.loads(Path("spring.json").read_text(encoding="utf-8"))
    return content


def value(item: dict[str, Any], unit: str) -> float:
    assert item["unit"] == unit
    number: float = item["value"]
    return number


def problems(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    """The messages of a run that ends with status 2 and leaves nothing."""
    before = sorted(Path.cwd().rglob("*"))
    assert main(["spring", *words]) == 2
    assert sorted(Path.cwd().rglob("*")) == before
    shown = capsys.readouterr()
    assert shown.out == ""
    lines = shown.err.splitlines()
    assert all(line.startswith("synth: ") for line in lines)
    return [line.removeprefix("synth: ") for line in lines]


def test_the_spring_meets_the_requirements() -> None:
    content = spring(*WISH)
    assert content["format"] == "synth/spring/1"
    assert value(content["wanted"]["arbor_diameter"], "mm") == 12.0
    made = content["make"]
    d, mean = value(made["wire_diameter"], "mm"), value(made["mean_diameter"], "mm")
    coils, modulus = value(made["body_coils"], "1"), value(made["elastic_modulus"], "GPa")
    # Shigley 10-48 and 10-51 in N mm: k = E d^4 / (64 D Na), Na = Nb + (l1 + l2) / (3 pi D)
    active = coils + 50.0 / (3.0 * math.pi * mean)
    assert modulus * 1e3 * d**4 / (64.0 * mean * active) == pytest.approx(1700.0, rel=1e-6)
    assert 180.0 - 360.0 * (coils % 1.0) == pytest.approx(120.0)
    # Shigley 10-43 and 10-44 at 40 degrees
    index = mean / d
    factor = (4 * index**2 - index - 1) / (4 * index * (index - 1))
    stress = factor * 32.0 * 1700.0 * math.radians(40.0) / (math.pi * d**3)
    assert value(made["stress"], "MPa") == pytest.approx(stress, rel=1e-6)
    assert stress <= value(made["allowed_stress"], "MPa")
    # Shigley 10-53: the wound coil leaves the arbor its tenth
    assert mean * coils / (coils + 40.0 / 360.0) - d >= 12.0 / 0.9 - 1e-6
    others = [value(other["wire_diameter"], "mm") for other in content["alternatives"]]
    assert len(others) == 4
    assert d not in others


def test_the_printed_table_equals_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spring", *WISH, "--json", "spring.json"]) == 0
    shown = capsys.readouterr().out
    made = json.loads(Path("spring.json").read_text(encoding="utf-8"))["make"]
    rows = {line[:32].strip(): line[32:].split() for line in shown.splitlines()[2:]}
    assert float(rows["wire diameter [mm]"][0]) == pytest.approx(made["wire_diameter"]["value"], rel=1e-3)
    assert float(rows["travel to yield [deg]"][0]) == pytest.approx(made["free_travel"]["value"], abs=0.05)
    assert float(rows["mass [g]"][0]) == pytest.approx(made["mass"]["value"], abs=0.05)
    assert shown.splitlines()[-1] == "written: spring.json"


def test_without_out_one_line_is_printed_and_no_file_written(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spring", *WISH]) == 0
    assert list(Path.cwd().iterdir()) == []
    first = capsys.readouterr().out.splitlines()[0]
    found = re.fullmatch(r"Wind ([\d.]+) coils of ([\d.]+) mm music wire, mean diameter ([\d.]+) mm: (.*)\.", first)
    assert found is not None
    made = spring(*WISH)["make"]
    assert float(found[1]) == pytest.approx(value(made["body_coils"], "1"), abs=1e-3)
    assert float(found[2]) == pytest.approx(value(made["wire_diameter"], "mm"), rel=1e-3)
    share = value(made["stress"], "MPa") / value(made["allowed_stress"], "MPa")
    first, lasts = found[4].split(", and against fatigue ")
    assert first == f"1.7 N*m/rad over 40 deg, at {share:.0%} of the allowed stress"
    factors = [value(made["fatigue"][key], "1") for key in ("safety_1e5", "safety_1e6")]
    assert lasts == "strength over stress {:.2f} for 1e5 full turns, {:.2f} for 1e6".format(*factors)


def test_output_units_follow_the_input_units(capsys: pytest.CaptureFixture[str]) -> None:
    """The same spring in inches where it was asked for in inches, or where --units says so; the file stays as it is."""
    inch = ["--rate", "15 in-lb/rad", "--travel", "40°", "--arbor", "1/2 in"]
    tables = {}
    for name, more in {"inch": [], "metric": ["--units", "metric"]}.items():
        assert main(["spring", *inch, *more, "--json", f"{name}.json"]) == 0
        tables[name] = {line.partition("[")[0].strip(): line for line in capsys.readouterr().out.splitlines()[2:]}
    assert Path("inch.json").read_bytes() == Path("metric.json").read_bytes()
    for head, unit, factor in (
        ("wire diameter", "in", 25.4),
        ("rate", "in*lbf/rad", 0.1129848),
        ("mass", "oz", 28.3495),
    ):
        assert f"[{unit}]" in tables["inch"][head]
        numbers = [float(tables[name][head].partition("]")[2].split()[0]) for name in ("metric", "inch")]
        assert numbers[0] == pytest.approx(numbers[1] * factor, rel=6e-3, abs=0.05)
    assert main(["spring", *inch, "--out", "out"]) == 0
    sheet = Path("out/winding_sheet.txt").read_text(encoding="utf-8")
    assert "in*lbf" in sheet
    assert " mm" not in sheet


INCH_COIL = ["--wire-diameter", "0.08 in", "--mean-diameter", "0.75 in", "--coils", "5.25", "--travel", "40 deg"]


@pytest.mark.parametrize(
    "words",
    [
        [*INCH_COIL, "--rate", "15 in-lb/rad", "--max-outer-diameter", "0.8 in", "--arbor", "0.7 in", "--out", "out"],
        [*INCH_COIL[:5], "1.25", *INCH_COIL[6:], "--travel", "60 deg", "--max-outer-diameter", "0.8 in"],
        ["--rate", "700 in-lb/rad", "--travel", "60 deg", "--max-outer-diameter", "2.4 in"],
        ["--rate", "180 in-lb/rad", "--travel", "60 deg"],
        ["--rate", "10 in-lb/rad", "--travel", "60 deg", "--max-body-length", "0.2 in"],
    ],
)
def test_sentences_are_in_the_units_of_the_table(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """In inches no sentence has a metric unit, and in metric units each says what the result file says."""
    metric = re.compile(r"\d (mm|MPa|N\*m|g)\b")
    assert main(["spring", "-q", *words, "--json", "spring.json"]) in (0, 1)
    assert not metric.search(capsys.readouterr().out)
    if "--out" in words:
        assert not metric.search(Path("out/winding_sheet.txt").read_text(encoding="utf-8"))
    content = json.loads(Path("spring.json").read_text(encoding="utf-8"))
    assert main(["spring", "-q", *words, "--units", "metric"]) in (0, 1)
    shown = capsys.readouterr().out
    texts = [*content["binding"], *(item["text"] for item in (*content["nearest"], *content.get("lasting", ())))]
    assert texts
    assert all(text in shown for text in texts)


def test_one_broken_limit_is_one_and_one_spring_is_not_counted(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spring", *INCH_COIL]) == 0
    capsys.readouterr()
    assert main(["spring", *INCH_COIL, "--max-outer-diameter", "0.8 in"]) == 1
    shown = capsys.readouterr().out
    assert shown.startswith("It breaks 1 limit: 5.25 coils")
    assert "  - outer diameter 0.83 in, allowed 0.8 in\n" in shown
    assert "in parallel" not in shown


def test_an_impossible_spring_is_explained_with_alternatives(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--rate", "79 N*m/rad", "--travel", "45 deg", "--max-outer-diameter", "60 mm"]
    assert main(["spring", *words, "--json", "spring.json"]) == 1
    shown = capsys.readouterr().out
    assert shown.startswith("No single spring of music wire gives 79 N*m/rad over 45 deg")
    content = json.loads(Path("spring.json").read_text(encoding="utf-8"))
    assert content["make"] is None
    assert content["binding"]
    assert content["nearest"]
    assert all(text in shown for text in [*content["binding"], *(item["text"] for item in content["nearest"])])
    for item in content["nearest"]:
        rate = value(item["make"]["rate"], "N*m/rad") * item["make"]["count"]
        assert rate == pytest.approx(79.0, rel=1e-6)


def test_where_no_single_change_helps_springs_in_parallel_with_less_travel_are_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["spring", "--rate", "79 N*m/rad", "--travel", "170 deg", "--json", "spring.json"]) == 1
    assert "4 in parallel, each of 19.75 N*m/rad, with a smaller travel, 78.4 deg of 170 deg" in capsys.readouterr().out
    (nearest,) = json.loads(Path("spring.json").read_text(encoding="utf-8"))["nearest"]
    made = nearest["make"]
    assert made["violations"] == []
    assert value(made["rate"], "N*m/rad") * made["count"] == pytest.approx(79.0, rel=1e-6)
    assert value(made["travel"], "deg") == pytest.approx(78.4)


def test_a_given_spring_is_checked(capsys: pytest.CaptureFixture[str]) -> None:
    sizes = ["--wire-diameter", "2 mm", "--mean-diameter", "20 mm", "--coils", "4.25", "--travel", "60 deg"]
    assert main(["spring", *sizes, "--rate", "1.2 N*m/rad", "--arbor", "17 mm", "--json", "spring.json"]) == 1
    shown = capsys.readouterr().out
    content = json.loads(Path("spring.json").read_text(encoding="utf-8"))
    assert value(content["checked"]["moment"], "N*m") == pytest.approx(1.2 * math.pi / 3.0)
    assert content["make"] is None  # the stress is too high and it grips the arbor
    assert [text.split()[0] for text in content["binding"]] == ["stress", "inside"]
    assert all(text in shown for text in content["binding"])
    assert (
        "the given rate differs by +121% from the rate of these sizes" in shown
    )  # 196.5 GPa, 4.25 + 0.265 coils: 0.544
    assert spring(*sizes[:-1], "20 deg")["make"] is not None


def test_the_output_folder_has_solid_and_sheet(capsys: pytest.CaptureFixture[str]) -> None:
    import cadquery as cq
    import trimesh

    assert main(["spring", *WISH, "--leg-length", "30 mm", "--hand", "left", "--out", "out/spring"]) == 0
    capsys.readouterr()
    out = Path("out/spring")
    visible = sorted(path.name for path in out.iterdir() if not path.name.startswith("."))
    assert visible == [
        "request_for_quotation.dxf",
        "spring.json",
        "spring.step",
        "spring.stl",
        "winding_sheet.html",
        "winding_sheet.txt",
    ]
    assert not Path("spring.json").exists()
    made = json.loads((out / "spring.json").read_text(encoding="utf-8"))["make"]
    d, mean = made["wire_diameter"]["value"], made["mean_diameter"]["value"]
    coils = made["body_coils"]["value"]
    assert all(arm["value"] > 30.0 + 2.5 * d for arm in made["arm_lengths"])  # the arms pass their load
    # Pappus: section times length; the drawn coils do not quite touch, a pitch of 1.03 wires
    length = coils * math.hypot(math.pi * mean, 1.03 * d) + sum(arm["value"] for arm in made["arm_lengths"])
    volume = math.pi * d**2 / 4.0 * length
    solid = cq.importers.importStep(str(out / "spring.step")).val()
    assert solid.Volume() == pytest.approx(volume, rel=1e-4)
    mesh = trimesh.load_mesh(out / "spring.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume, rel=5e-3)
    # left-hand: going up along z, the wire turns clockwise, over -y before +y
    x, y, z = mesh.vertices.T
    across = np.abs(x) < 0.2 * mean  # the lower arm starts from +x
    assert z[across & (y < -0.3 * mean)].min() < z[across & (y > 0.3 * mean)].min() - 0.4 * d
    sheet = (out / "winding_sheet.txt").read_text(encoding="utf-8")
    assert f"{coils:.3f} coils, left-hand" in sheet
    assert f"music wire, {d:.4g} mm" in sheet
    angle, torque = re.findall(r"^([\d.]+) +([\d.]+)$", sheet, re.MULTILINE)[-1]
    assert float(angle) == 40.0
    assert float(torque) == pytest.approx(1.7 * math.radians(float(angle)), rel=1e-3)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert main(["spring", *WISH, "--leg-length", "30 mm", "--hand", "left", "--out", "out/spring"]) == 0
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize(
    ("wish", "told"),
    [
        (["0.5 mN*m/rad", "--arbor", "0.5 mm", "--leg-length", "2 mm"], "wire_diameter = 0.1524: allowed is 0.2 to"),
        (["1 N*m/rad", "--included-angle", "359 deg"], "included_angle = 359: allowed is 5 to 355 deg"),
    ],
)
def test_a_spring_that_is_not_drawn_has_its_winding_sheet(
    wish: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a thinner wire than is drawn no file was written, though the sheet needs no solid."""
    assert main(["spring", "--rate", *wish, "--travel", "30 deg", "--out", "out"]) == 0
    assert f"note: no STEP or STL, it cannot be drawn: {told}" in capsys.readouterr().out
    written = {"spring.json", "winding_sheet.html", "winding_sheet.txt", "request_for_quotation.dxf"}
    assert {path.name for path in Path("out").iterdir() if not path.name.startswith(".")} == written


def test_legs_that_cannot_be_drawn_give_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spring", *WISH, "--legs", "radial", "--out", "out"]) == 0
    assert "note: no STEP or STL" in capsys.readouterr().out
    assert not list(Path("out").glob("spring.st*"))


def test_all_mistakes_are_reported_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--rate", "38 N*m", "--travel", "45", "--arbor", "-3 mm", "--safety", "90 %", "--leg-length", "2 furlong"]
    lines = problems(capsys, *words, "--opening-travel=-5 deg", "--included-angle", "400 deg")
    keys = [line.partition(":")[0] for line in lines]
    assert sorted(keys) == sorted(
        ["--rate", "--travel", "--arbor", "--safety", "--leg-length", "--opening-travel", "--included-angle"]
    )
    text = "\n".join(lines)
    assert "did you mean N*m/rad?" in text
    assert '"45" has no unit' in text
    assert 'unit "furlong"' in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--rate", "1 N*m/rad"], "--travel: is required"),
        (["--travel", "45 deg"], "--rate: is required"),
        (["--travel", "45 deg", "--wire-diameter", "2 mm", "--mean-diameter", "9 mm"], "--coils: checking needs"),
        ([*WISH, "--material", "musik"], 'no wire material "musik"; did you mean music?'),
        ([*WISH, "--system", "metrik"], "did you mean metric?"),
        ([*WISH, "--max-outer-diameter", "20 m"], '--max-outer-diameter: "20 m" must be above 0 and at most 1 m'),
        (["--rate", "1 N*m/rad", "--travel", "4000 deg"], '--travel: "4000 deg" must be above 0 and at most 3600 deg'),
        ([*WISH, "--json", "nowhere/spring.json"], "nowhere/spring.json: cannot be written: No such file"),
        ([*WISH, "--json", "/proc/spring.json"], "/proc/spring.json: cannot be written"),
        ([*WISH, "--json", "."], ".: exists and is no result"),
        ([*WISH, "--out", "/proc/spring"], "/proc/spring: cannot be written"),
        ([*WISH, "--catalog", "my.csv"], "my.csv: does not exist"),
        (
            ["--wire-diameter", "2 mm", "--mean-diameter", "1 mm", "--coils", "4", "--travel", "1 deg"],
            "no coil can have",
        ),
        (["--wire-diameter", "9 m", "--mean-diameter", "90 m", "--coils", "4", "--travel", "1 deg"], "no strength"),
    ],
)
def test_each_mistake_gives_one_message(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    (line,) = problems(capsys, *words, "-q")
    assert message in line


def test_a_file_of_the_user_is_not_replaced(capsys: pytest.CaptureFixture[str]) -> None:
    Path("leg.yaml").write_text("kind: leg\n", encoding="utf-8")
    assert "is no result of synth spring" in problems(capsys, *WISH, "--json", "leg.yaml")[0]
    assert Path("leg.yaml").read_text(encoding="utf-8") == "kind: leg\n"
    spring(*WISH)
    assert value(spring("--rate", "1 N*m/rad", "--travel", "20 deg")["wanted"]["rate"], "N*m/rad") == 1.0
    assert [path.name for path in Path.cwd().iterdir() if path.name.startswith(".")] == []


def test_a_folder_name_with_markup_is_handled(tmp_path: Path) -> None:
    folder = tmp_path / "<b>&amp; springs"
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, "-m", "synth", "spring", *WISH, "--json", str(folder / "a.json")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith(f"written: {folder / 'a.json'}\n")
    assert json.loads((folder / "a.json").read_text(encoding="utf-8"))["make"]["count"] == 1


def test_the_winding_sheet_is_complete(capsys: pytest.CaptureFixture[str]) -> None:
    """Direction, mandrel, heat, tolerances and torques stand on the page, and it needs nothing outside itself."""
    words = [*WISH, "--cycles", "1e6", "--closes", "counter-clockwise", "--objective", "space", "--out", "out"]
    assert main(["spring", *words]) == 0
    capsys.readouterr()
    content = json.loads(Path("out/spring.json").read_text())
    made = content["make"]
    page = Path("out/winding_sheet.html").read_text(encoding="utf-8")
    assert made["hand"] == "left"
    assert made["fatigue"]["safety_1e6"]["value"] >= 1.0
    assert value(content["wanted"]["cycles"], "1") == 1e6
    text = " ".join(re.sub(r"<[^>]+>", " ", page).split()).replace("\xa0", " ")
    assert "Let the load turn the far arm counter-clockwise against the near one" in text
    assert f"on a mandrel of {made['mandrel']['diameter']['value']:.4g} mm" in text
    assert "230 °C for 30 min" in text
    assert "seen along the axis, left-hand" in text
    torque = made["rate"]["value"] * math.radians(40.0)
    assert f"{torque:.4g} N·m" in text
    assert not re.search(r"(src|href)=\"http", page)
    assert page.count("<svg") == 1


def test_a_longer_life_needs_more_mass(capsys: pytest.CaptureFixture[str]) -> None:
    light, lasting = (spring(*WISH, "--objective", each)["make"] for each in ("mass", "life"))
    assert lasting["fatigue"]["safety_1e6"]["value"] > light["fatigue"]["safety_1e6"]["value"]
    assert lasting["mass"]["value"] > light["mass"]["value"]


def test_contradicting_hand_and_direction_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    (said,) = problems(capsys, *WISH, "--closes", "clockwise", "--hand", "left")
    assert said.startswith(
        "--hand: work that turns the far arm clockwise closes a right-hand coil and opens a left-hand"
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--cycles", "1e8"], '--cycles: "1e8" must be from 1 to 1e6: fatigue is known up to 1e6 cycles'),
        (["--fatigue-safety", "1.2"], "--fatigue-safety: needs --cycles as well"),
        (["--bend-radius", "3"], "--bend-radius"),
        (["--bend-radius", "-3 mm"], "--bend-radius"),
    ],
)
def test_invalid_fatigue_options_are_refused(
    capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert any(line.startswith(message) for line in problems(capsys, *WISH, *words))


def test_the_rate_formula_can_be_chosen() -> None:
    plain, friction = (spring(*WISH, "--rate-formula", formula)["make"] for formula in ("64", "10.8"))
    for made, used in ((plain, "rate_bending_form"), (friction, "rate_friction_form")):
        assert value(made["rate"], "N*m/rad") == pytest.approx(value(made[used], "N*m/rad"))
    assert friction["rate_formula"] == "10.8"


def test_material_names_are_read_in_any_case() -> None:
    assert spring(*WISH, "--material", "Music Wire")["make"] == spring(*WISH)["make"]


def test_the_request_for_quotation_is_complete(tmp_path: Path) -> None:
    import ezdxf

    assert main(["spring", "-q", *WISH, "--out", str(tmp_path / "s")]) == 0
    made = json.loads((tmp_path / "s" / "spring.json").read_text(encoding="utf-8"))["make"]
    space = ezdxf.readfile(tmp_path / "s" / "request_for_quotation.dxf").modelspace()
    circles = sorted(2 * item.dxf.radius for item in space.query("CIRCLE"))
    mean, wire = value(made["mean_diameter"], "mm"), value(made["wire_diameter"], "mm")
    assert circles == pytest.approx([mean - wire, mean, mean + wire])
    words = "\n".join(item.dxf.text for item in space.query("TEXT"))
    grade = made["grade"]
    quality = f"DIN 2194, grade {grade['grade']}: free angle within {value(grade['free_angle'], 'deg'):.2g} deg"
    assert all(
        part in words
        for part in (
            "REQUEST FOR QUOTATION",
            "T1:",
            "T2:",
            "Test: loose on an arbor",
            "Rate in this test:",
            quality,
            "hand",
        )
    )
    assert len(space.query("DIMENSION")) == 5


def test_wound_samples_correct_mandrel_and_rate(tmp_path: Path) -> None:
    """Samples that were made with a flow stress of 0.9 of the strength and a rate 4 % under the formula."""
    from synth.parts.catalogs import Catalogue
    from synth.parts.coil_rate import rate
    from synth.spring.winding import mandrel_diameter, turns_on_mandrel

    wire = Catalogue.load().find_material("music")
    lines = ["mandrel [mm],wire [mm],turns [1],coils [1],rate [N*mm/rad],leg_length [mm]"]
    for d, mean, coils in ((2e-3, 20e-3, 5.25), (1.5e-3, 12e-3, 6.25), (2e-3, 15e-3, 4.25)):
        known = wire.properties(d)
        mandrel = mandrel_diameter(mean, d, known.elastic_modulus, 0.9 * known.strength.value)
        turns = turns_on_mandrel(mean, d, coils, mandrel)
        measured = 0.96 * rate(known.elastic_modulus, d, mean, coils)
        lines.append(f"{mandrel * 1e3},{d * 1e3},{turns},{coils},{measured * 1e3},0")
    table, found = tmp_path / "samples.csv", tmp_path / "calibration.json"
    table.write_text("\n".join(lines) + "\n")
    assert main(["spring", "-q", "calibrate", str(table), "--json", str(found)]) == 0
    content = json.loads(found.read_text())
    assert value(content["spring_back"], "1") == pytest.approx(0.9, abs=1e-6)
    assert value(content["rate"], "1") == pytest.approx(0.96, abs=1e-9)
    before, after = spring(*WISH)["make"], spring(*WISH, "--calibration", str(found))["make"]
    d, mean = (value(after[name], "mm") for name in ("wire_diameter", "mean_diameter"))
    coils = value(after["active_coils"], "1")
    formula = value(after["elastic_modulus"], "GPa") * 1e3 * d**4 / (64 * mean * coils) * 1e-3
    assert value(after["rate"], "N*m/rad") == pytest.approx(0.96 * formula)
    assert value(after["rate"], "N*m/rad") == pytest.approx(value(before["rate"], "N*m/rad"))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("10,2,5,5.25,abc", "is not a number"),
        ("10,2,,5.25,", "or outer_diameter (of the free coil) is required"),
        (",2,5,5.25,", "no mandrel"),
    ],
)
def test_an_impossible_sample_is_reported_with_its_line(
    line: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "samples.csv"
    table.write_text(f"mandrel [mm],wire [mm],turns [1],coils [1],rate [N*mm/rad]\n{line}\n")
    (message,) = problems(capsys, "calibrate", str(table))
    assert f"{table}:2" in message
    assert said in message


def test_a_calibration_says_what_no_sample_measured(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "samples.csv"
    table.write_text("mandrel [mm],wire [mm],coils [1],outer_diameter [mm]\n14,2,5.25,20\n")
    assert main(["spring", "calibrate", str(table)]) == 0
    shown = capsys.readouterr().out
    assert "(1 sample); sets the mandrel" in shown
    assert "rate: no sample has one" in shown
    table.write_text(
        "mandrel [mm],wire [mm],coils [1],outer_diameter [mm],rate [N*m/rad],leg_length [mm]\n14,2,5.25,20,0.66,25\n"
    )
    assert main(["spring", "calibrate", str(table)]) == 0  # 0.492 by the formula
    assert "note: the rate is far from the formula's" in capsys.readouterr().out


def test_a_calibration_is_for_its_own_wire_and_rate_formula(capsys: pytest.CaptureFixture[str]) -> None:
    """The coil that was measured is answered with the rate that was measured, and the formulas stay what they are."""
    header = "mandrel [mm],wire [mm],coils [1],outer_diameter [mm],rate [N*m/rad],leg_length [mm]"
    Path("samples.csv").write_text(f"{header}\n14,2,5.25,20,0.47,25\n")
    coil = ["--wire-diameter", "2 mm", "--mean-diameter", "18 mm", "--coils", "5.25", "--travel", "40 deg"]
    plain = spring(*coil)["checked"]
    assert "rate_factor" not in plain
    forms = {"64": "rate_bending_form", "10.8": "rate_friction_form"}
    for made, other in (("64", "10.8"), ("10.8", "64")):
        words = ["--rate-formula", made, "--json", f"{made}.json"]
        assert main(["spring", "-q", "calibrate", "samples.csv", *words]) == 0
        calibrated = ["--calibration", f"{made}.json"]
        checked = spring(*coil, *calibrated, "--rate-formula", made)["checked"]
        assert value(checked["rate"], "N*m/rad") == pytest.approx(0.47)
        for form in forms.values():
            assert checked[form] == plain[form]
        factor = value(checked["rate_factor"], "1")
        assert factor * value(plain[forms[made]], "N*m/rad") == pytest.approx(0.47)
        capsys.readouterr()
        (said,) = problems(capsys, *coil, *calibrated, "--rate-formula", other)
        assert said.startswith(f"the calibration is a factor on the rate formula {made}, and {other} is chosen")
        for sizes in (coil, WISH):
            words = [*sizes, *calibrated, "--rate-formula", made, "--material", "stainless"]
            assert "was measured on music wire, and the spring is of stainless" in problems(capsys, *words)[0]
    assert main(["spring", *coil, "--calibration", "64.json"]) == 0
    rows = {line[:32].strip(): line[32:].split() for line in capsys.readouterr().out.splitlines()[2:]}
    assert rows["rate over the formula's, samples"] == [f"{0.47 / value(plain['rate_bending_form'], 'N*m/rad'):.3f}"]
    assert main(["spring", "-q", *coil, "--calibration", "64.json", "--out", "out"]) == 0
    assert "The rates are 0.955 times the formula's" in Path("out/winding_sheet.txt").read_text(encoding="utf-8")


def test_a_nearest_spring_of_another_wire_has_no_calibration() -> None:
    """Whatever music wire's samples gave, the spring of another wire is by its formula."""
    Path("calibration.json").write_text(
        '{"format": "synth/spring/calibration/1", "material": "music wire", "source": "s.csv", "rate_formula": "64",'
        ' "spring_back": {"value": 0.9, "unit": "1", "samples": 1}, "rate": {"value": 0.9, "unit": "1", "samples": 1}}'
    )
    words = ["--rate", "40 N*m/rad", "--travel", "60 deg", "--calibration", "calibration.json", "--json", "s.json"]
    assert main(["spring", "-q", *words]) == 1
    nearest = {item["kind"]: item["make"] for item in json.loads(Path("s.json").read_text())["nearest"]}
    for kind, made in nearest.items():
        calibrated = made.get("rate_factor", {"value": 1.0})["value"]
        assert calibrated == (1.0 if kind == "other_material" else 0.9)
        assert value(made["rate"], "N*m/rad") == pytest.approx(calibrated * value(made["rate_bending_form"], "N*m/rad"))
    assert "other_material" in nearest


def test_the_sheet_for_the_bench_is_in_inches_where_the_input_is(tmp_path: Path) -> None:
    """The text beside it was in inches, the page in millimetres."""
    assert main(["-q", "spring", "--rate", "15 in*lbf/rad", "--travel", "40 deg", "--out", str(tmp_path / "in")]) == 0
    html = (tmp_path / "in" / "winding_sheet.html").read_text(encoding="utf-8")
    body = re.sub(r"<(style|script).*?</\1>|<[^>]*>", " ", html, flags=re.DOTALL).replace("\u00a0", " ")
    assert not re.search(r"\d ?(mm|MPa|GPa|N·m|N|g|kg)\b", body)
    assert "15 in·lbf/rad" in body
    sheet = (tmp_path / "in" / "winding_sheet.txt").read_text(encoding="utf-8")
    wire = re.search(r"Wire: music wire, ([\d.]+) in", sheet)
    assert wire is not None
    assert f"wire Ø {wire[1]} in" in body
    # A quarter of the travel, a quarter of the torque: 15 in*lbf/rad over 10 deg.
    assert re.search(r"10°\s+2\.618 in·lbf", body)
    assert json.loads((tmp_path / "in" / "spring.json").read_text())["make"]["wire_diameter"]["unit"] == "mm"
    assert main(["-q", "spring", "--rate", "1.7 N*m/rad", "--travel", "40 deg", "--out", str(tmp_path / "mm")]) == 0
    assert "15 in·lbf/rad" not in (tmp_path / "mm" / "winding_sheet.html").read_text("utf-8").replace("\u00a0", " ")
    assert "1.7 N·m/rad" in (tmp_path / "mm" / "winding_sheet.html").read_text("utf-8").replace("\u00a0", " ")
