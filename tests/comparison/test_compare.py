"""Legs side by side: exact in cases with a closed form; page and table have the JSON's numbers."""

from __future__ import annotations

import csv
import json
import re
import shutil
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from result_fields import require_explained
from synth.cli import main
from synth.comparison.compare_sides import Comparison, compare, warnings
from synth.comparison.recorded_sides import standard_release
from synth.comparison.shown_characteristics import alone
from synth.comparison.side import MODEL, Side, joints_of
from synth.comparison.side_source import read_source
from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"
SHARED = Path(__file__).resolve().parents[3] / "shared" / "aarl"


def pendulum(k: float = 2.0, b: float = 0.05, gravity: float = 9.81) -> Leg:
    """Two links; with ``gravity`` 0 springs and dampers alone move it."""
    link = Link(0.2, 0.3, 0.1, 1e-3)
    joints = tuple(
        Joint(name, link, zero=radians(90), spring=Spring(k, radians(100)), damper=Damper(b))
        for name in ("hip", "knee")
    )
    return Leg("two links", joints, gravity)


def side(name: str, leg: Leg, **more: Any) -> Side:
    return Side(name, name, MODEL, leg, joints_of(leg), **more)


def compared(*sides: Side, **options: Any) -> Comparison:
    return compare(list(sides), **options)


def test_a_leg_does_not_differ_from_itself() -> None:
    found = compared(side("a", pendulum()), side("b", pendulum()))
    assert found.starts_of == "standard"
    assert found.differences[0].overall == 0.0
    assert found.differences[0].basis == "predicted"


def test_without_gravity_a_quarter_of_the_spring_and_half_the_damper_move_twice_as_slowly() -> None:
    """Dimensional analysis: time goes as sqrt(I/k) and I/b. Stretched by two the motions are the same."""
    fast, slow = pendulum(4.0, 0.06, 0.0), pendulum(1.0, 0.03, 0.0)
    start = standard_release(fast, np.zeros(2), 2.0)
    start = replace(start, rate=np.array([1.0, -2.0]))
    found = compared(side("fast", fast), side("slow", slow), stretch={"fast": 2.0}, starts=[start], reference="slow")
    assert found.differences[0].overall < radians(0.001)
    apart = compared(side("fast", fast), side("slow", slow), starts=[start])
    assert apart.differences[0].overall > radians(2)


def test_a_leg_of_another_pace_is_overlaid_in_the_starts_time_and_shows_its_own() -> None:
    """As above, a leg half as fast: in the starts' time it moves alike, and its frequency is half the other's."""
    fast, slow = pendulum(4.0, 0.06, 0.0), pendulum(1.0, 0.03, 0.0)
    start = replace(standard_release(fast, fast.rest, 2.0), rate=np.array([3.0, -2.0]))
    found = compared(side("fast", fast), side("slow", slow, pace=2.0), starts=[start])
    assert found.differences[0].overall < radians(0.001)
    own, half = (each.joints["hip"]["damped_frequency"].median for each in found.characteristics)
    assert own / half == pytest.approx(2.0, rel=1e-3)
    assert found.clock == "time / time scale"
    assert found.as_json()["sides"][1]["pace"]["value"] == 2.0


def test_a_side_beside_a_family_of_time_scales_is_said_to_keep_its_time() -> None:
    leg = pendulum(gravity=0.0)
    sides = side("x1", leg), side("x2", leg, pace=2.0), side("robot", leg)
    sides = *(replace(each, source="family") for each in sides[:2]), sides[2]
    told = [text for text in warnings(compared(*sides)) if "in its own time" in text]
    assert [text.partition(":")[0] for text in told] == ["robot"]


def test_a_single_joint_alone_is_the_textbook_oscillator() -> None:
    """One link hanging straight down: stiffness k + m g c, inertia I + m c^2."""
    link = Link(0.3, 0.5, 0.12, 2e-3)
    leg = Leg("one", (Joint("hip", link, spring=Spring(1.5, 0.0), damper=Damper(0.02)),))
    found = alone(leg)["hip"]
    stiffness, inertia = 1.5 + 0.5 * 9.81 * 0.12, 2e-3 + 0.5 * 0.12**2
    assert found.stiffness == pytest.approx(stiffness)
    assert found.inertia == pytest.approx(inertia)
    assert found.frequency == pytest.approx(np.sqrt(stiffness / inertia))
    assert found.damping_ratio == pytest.approx(0.02 / (2 * np.sqrt(stiffness * inertia)))


def test_a_leg_counted_in_another_sense_is_the_same_leg() -> None:
    """The knee's sign and zero turned over: the rotations, and so the differences, stay."""
    leg = pendulum()
    turned = leg.with_joints(knee={"zero": radians(30), "sign": -1, "spring": Spring(2.0, radians(20))})
    assert turned.rest[1] == pytest.approx(leg.rest[1])
    assert compared(side("a", leg), side("b", turned)).differences[0].overall < 1e-12


def test_free_angles_are_all_in_the_first_sides_convention() -> None:
    """One leg counted in two ways showed free angles of 100 and 20 deg side by side."""
    leg = pendulum()
    turned = leg.with_joints(knee={"zero": radians(30), "sign": -1, "spring": Spring(2.0, radians(20))})
    known = {"knee": {"free_angle": {"value": 20.0, "unit": "deg", "interval90": [18.0, 23.0]}}}
    other = Side("b", "b", MODEL, turned, joints_of(turned, known))
    found = compared(side("a", leg), other)
    document = found.as_json()
    angles = [each["joints"]["knee"]["free_angle"] for each in document["sides"]]
    assert [angle["value"] for angle in angles] == pytest.approx([100.0, 100.0])
    assert angles[1]["interval90"] == pytest.approx([97.0, 102.0])
    assert document["sides"][1]["joints"]["hip"] == document["sides"][0]["joints"]["hip"]
    assert any("b: its file counts knee from another zero" in str(text) for text in document["warnings"])
    back = compared(other, side("a", leg)).as_json()["sides"]
    assert [each["joints"]["knee"]["free_angle"]["value"] for each in back] == pytest.approx([20.0, 20.0])
    assert not compared(side("a", leg), side("c", leg)).as_json()["warnings"]


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The fit example, fitted."""
    folder = tmp_path_factory.mktemp("fit")
    shutil.copytree(EXAMPLES / "fit", folder / "project")
    assert main(["fit", str(folder / "project" / "fit.yaml"), "--out", str(folder / "result"), "-q"]) == 0
    return folder


@pytest.fixture(scope="module")
def beside(fitted: Path) -> Path:
    """Recordings, the fitted leg, and the leg that made the recordings, compared."""
    out, truth = fitted / "beside", fitted / "truth.leg.yaml"
    _write_truth(fitted / "project", truth)
    assert main(["compare", f"fit={fitted / 'result'}", f"true={truth}", "--out", str(out), "-q"]) == 0
    return out


def _write_truth(project: Path, path: Path) -> None:
    from synth.files.leg_file import write_leg

    truth = json.loads((project / "truth.json").read_text())["robot"]
    leg = read_leg(project / "robot.leg.yaml")
    changes = {
        name: {
            "spring": Spring(values["spring_rate"]["value"], radians(values["free_angle"]["value"])),
            "damper": Damper(values["damper_rate"]["value"]),
        }
        for name, values in truth.items()
    }
    write_leg(leg.with_joints(**changes), path)


def test_the_fitted_leg_moves_like_the_one_that_was_recorded(beside: Path) -> None:
    """The example's samples scatter by 0.1 deg; the truth and the fit agree to less."""
    document = json.loads((beside / "compare.json").read_text())
    require_explained("compare.json", document)
    by_pair = {(item["from"], item["of"]): item for item in document["differences"]}
    assert by_pair["fit fitted", "true"]["overall"]["value"] < 0.1
    assert by_pair["fit recorded", "fit fitted"]["overall"]["value"] == pytest.approx(0.1, abs=0.03)
    assert document["reference"] == "fit recorded"
    assert document["starts_of"] == "fit recorded"


def test_starts_are_moved_under_the_recordings_conditions(fitted: Path, beside: Path) -> None:
    """The example's trials with locked joints or a tip mass are followed too: their RMS is the fit's own."""
    fit = json.loads((fitted / "result" / "fit.json").read_text())
    held = [trial for trial in fit["trials"] if trial.get("locked")]
    document = json.loads((beside / "compare.json").read_text())
    starts = {start["name"]: start for start in document["starts"]}
    for trial in held:
        assert starts[trial["file"]]["locked"] == trial["locked"]
    fitted_side = next(item for item in document["sides"] if item["name"] == "fit fitted")
    for joint, value in fit["rms"].items():
        assert fitted_side["off_reference"]["rms"][joint]["value"] == pytest.approx(value["value"], rel=0.1)


def test_the_table_holds_what_the_json_says(beside: Path) -> None:
    document = json.loads((beside / "compare.json").read_text())
    with (beside / "compare.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    found = {(row["side"], row["joint"], row["quantity"]): row for row in rows}
    for written in document["sides"]:
        for joint, values in written["joints"].items():
            row = found[written["name"], joint, "spring_rate"]
            assert float(row["value"]) == pytest.approx(values["spring_rate"]["value"], rel=1e-9)
            interval = values["spring_rate"].get("interval90")
            if interval:
                assert [float(row["low"]), float(row["high"])] == pytest.approx(interval, rel=1e-9)
        if "off_reference" in written:
            row = found[written["name"], "all", "rms_off_reference"]
            assert float(row["value"]) == pytest.approx(written["off_reference"]["overall"]["value"], rel=1e-9)


def test_the_page_opens_with_the_verdict_and_every_side(beside: Path) -> None:
    page = (beside / "report.html").read_text()
    document = json.loads((beside / "compare.json").read_text())
    opening = page[page.index('class="verdict') : page.index("<main>")]
    for written in document["sides"]:
        assert written["name"] in opening
    shown = re.search(r"([\d.]+)°", opening)
    assert shown is not None
    offs = [w["off_reference"]["overall"]["value"] for w in document["sides"] if "off_reference" in w]
    assert float(shown[1]) == pytest.approx(min(offs), rel=0.01)


def test_json_is_printed_and_a_second_run_gives_the_same_bytes(
    fitted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["compare", f"fit={fitted / 'result'}", f"true={fitted / 'project' / 'fit.yaml'}#fitted"]
    outs = [fitted / "first", fitted / "second"]
    for out in outs:
        capsys.readouterr()
        assert main([*arguments, "--out", str(out), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["format"] == "synth/compare/1"
    for name in ("compare.json", "compare.csv", "report.html"):
        assert (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes()


def test_time_scales_of_a_project_are_a_family(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The example's motion slowed twice: without gravity k would fall to a quarter, and gravity takes a part of it.

    Each leg is as far from the animal as recorded as its fit at its own scale says, in whatever order.
    """
    shutil.copytree(EXAMPLES / "leg", tmp_path / "leg")
    source, off = f"family={tmp_path / 'leg' / 'leg-design.yaml'}", {}
    for scales in ("1,2", "2,1"):
        out = tmp_path / f"out {scales}"
        assert main(["compare", source, "--time-scales", scales, "--out", str(out), "-q"]) == 0
        document = json.loads((out / "compare.json").read_text())
        require_explained("compare.json", document)
        sides = {item["name"]: item for item in document["sides"]}
        assert list(sides) == ["family animal", *(f"family x{scale}" for scale in scales.split(","))]
        assert [sides[f"family {name}"]["pace"]["value"] for name in ("animal", "x1", "x2")] == [1.0, 1.0, 2.0]
        assert "slowed" not in sides["family animal"]
        off[scales] = [sides[f"family x{k}"]["off_reference"]["overall"]["value"] for k in (1, 2)]
        for k in (1, 2):
            stated = [figure["value"]["value"] for figure in sides[f"family x{k}"]["stated"]]
            assert off[scales][k - 1] == pytest.approx(np.sqrt(np.mean(np.square(stated))), rel=1e-3)
    assert off["1,2"] == off["2,1"]
    seen = [sides[name]["characteristics"]["knee"]["rise_time"]["value"] for name in ("family animal", "family x2")]
    assert seen[1] / seen[0] == pytest.approx(2.0, rel=0.1)
    stiff = [sides[f"family x{k}"]["alone"]["knee"]["stiffness"]["value"] for k in (1, 2)]
    assert stiff[0] / stiff[1] == pytest.approx(4.0, rel=0.15)
    page = (out / "report.html").read_text()
    assert "time scales" in page
    assert "time / time scale [s]" in page
    assert "The legs of the time scales are drawn as fitted to that recording" in page
    said = capsys.readouterr()
    assert "its time / 2" in said.out
    assert "links as in the target's file (hip 222 g" in " ".join(document["warnings"])


def test_a_fit_with_a_free_angle_a_trial_follows_its_own_recordings(tmp_path: Path) -> None:
    """One common free angle was 2.5 deg off recordings that the fit follows to its noise."""
    leg, times = Leg("one", pendulum().joints[:1]), np.arange(0.0, 2.0, 0.01)
    (tmp_path / "trials").mkdir()
    for k, shift in enumerate(np.radians([-4.0, 1.0, 3.0])):
        spring = leg.joints[0].spring
        assert spring is not None
        own = Leg("one", (replace(leg.joints[0], spring=replace(spring, free_angle=spring.free_angle + shift)),))
        angle = simulate(own, np.array([0.5 - 0.4 * k]), np.zeros(1), times)
        angle = np.degrees(leg.to_measured(angle)) + np.random.default_rng(k).normal(0.0, 0.02, angle.shape)
        rows = [f"{t:.4f},{value:.4f}" for t, value in zip(times, angle[:, 0], strict=True)]
        (tmp_path / "trials" / f"{k}.csv").write_text("\n".join([f"time [s],{leg.joint_names[0]} [deg]", *rows]))
    write_leg(leg, tmp_path / "one.leg.yaml")
    (tmp_path / "fit.yaml").write_text("kind: fit\nleg: one.leg.yaml\ntrials: [trials/*.csv]\nfree_angle: per_trial\n")
    assert main(["fit", str(tmp_path / "fit.yaml"), "--out", str(tmp_path / "fit"), "-q"]) == 0
    for source in (tmp_path / "fit", tmp_path / "fit.yaml"):
        out = tmp_path / f"out {source.suffix}"
        assert main(["compare", f"a={source}", "--out", str(out), "-q"]) == 0
        document = json.loads((out / "compare.json").read_text())
        (off,) = [side["off_reference"]["overall"]["value"] for side in document["sides"] if "off_reference" in side]
        assert off < 0.04
        assert any("the fit's own start and free angle in each" in text for text in document["warnings"])


def test_an_animal_that_is_shown_slowed_says_by_how_much(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The project's own time scale, two: rates of its recordings are half of those as recorded."""
    shutil.copytree(EXAMPLES / "leg", tmp_path / "leg")
    project = tmp_path / "leg" / "leg-design.yaml"
    project.write_text(re.sub(r"time: [0-9.]+", "time: 2", project.read_text()))
    rates = {}
    for stretch in ([], ["--stretch", "leg-design animal=1"]):
        out = tmp_path / f"out{len(stretch)}"
        assert main(["compare", f"{project}", *stretch, "--out", str(out), "-q"]) == 0
        document = json.loads((out / "compare.json").read_text())
        rates[document["sides"][0].get("slowed", {}).get("value", 1.0)] = document["starts"][0]["rate"]["hip"]["value"]
        assert ("slowed 2 times" in capsys.readouterr().out) == (not stretch)
        assert ("slowed 2 times" in (out / "report.html").read_text()) == (not stretch)
    assert rates[1.0] / rates[2.0] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nowhere", "nowhere2"], "does not exist"),
        (["{fit}#built", "{leg}"], '"built" is not a view of a fit'),
        (["{leg}", "{leg}"], 'two sides are called "truth"'),
        (["{leg}"], "1 sides given"),
        (["a={leg}", "b={other}"], "only legs with the same joints"),
        (["a={leg}", "b={leg}", "--stretch", "c=2"], '"c" is not a side'),
        (["a={leg}", "b={leg}", "--stretch", "a=x"], "SIDE=FACTOR"),
        (["a={leg}", "b={leg}", "--start", "hip=60 deg"], "give knee, ankle too"),
        (["a={leg}", "b={leg}", "--start", "hip=60"], "no unit"),
        (["a={leg}", "b={leg}", "--time-scales", "1,2"], "is for a leg-design project"),
        (["a={trial}", "b={trial}"], "--leg FILE.leg.yaml"),
    ],
)
def test_mistakes_are_reported(
    arguments: list[str], told: str, fitted: Path, beside: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.leg.yaml"
    other.write_text((fitted / "truth.leg.yaml").read_text().replace("name: knee", "name: elbow"))
    trial = next((fitted / "project" / "trials").glob("*.csv"))
    names = {"fit": fitted / "result", "leg": fitted / "truth.leg.yaml", "other": other, "trial": trial}
    out = tmp_path / "out"
    assert main(["compare", *[text.format(**names) for text in arguments], "--out", str(out)]) == 2
    assert told in capsys.readouterr().err
    assert not out.exists()


def test_a_path_with_an_equals_sign_is_a_path(tmp_path: Path) -> None:
    folder = tmp_path / "a=b"
    folder.mkdir()
    shutil.copy(EXAMPLES / "fit" / "robot.leg.yaml", folder / "x.leg.yaml")
    assert read_source(str(folder / "x.leg.yaml")).label == "x"
    with pytest.raises(UserError, match="does not exist"):
        read_source("name=nowhere")


@pytest.mark.skipif(not SHARED.exists(), reason="the laboratory's recordings are not beside the checkout")
def test_the_laboratorys_built_leg_beside_its_recordings(tmp_path: Path) -> None:
    """Thesis, Figure 22: the leg as built against its model, and against one without springs."""
    shutil.copytree(SHARED / "dog", tmp_path / "dog")
    (tmp_path / "built.yaml").write_text(
        "kind: gap\nleg: dog/dog_built.leg.yaml\n"
        "trials:\n  - {file: dog/joint_tests/ankle_*.csv, locked: [hip, knee]}\n"
    )
    out = tmp_path / "out"
    assert main(["compare", f"new={tmp_path / 'built.yaml'}", f"bare={tmp_path / 'dog/dog_dampers.leg.yaml'}",
                 "--out", str(out), "-q"]) == 0  # fmt: skip
    document = json.loads((out / "compare.json").read_text())
    off = {item["name"]: item["off_reference"]["rms"] for item in document["sides"] if "off_reference" in item}
    assert set(off["new designed"]) == {"ankle"}  # the others were held
    assert off["new designed"]["ankle"]["value"] < 5.0 < off["bare"]["ankle"]["value"]
