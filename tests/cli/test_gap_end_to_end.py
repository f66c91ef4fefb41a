"""``synth gap`` with the diagnosis itself: a pendulum with dry friction that its design lacks, and the example."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.made_effect import CUBIC_DRAG
from synth.cli import main
from synth.files.leg_file import read_leg, write_leg
from synth.swing import effects
from synth.swing.chain import simulate
from synth.swing.effects.users_own import load_file
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "gap"
DOCS = EXAMPLE.parents[2] / "docs"
Json = dict[str, Any]

LINK = Link(0.3, 0.5, 0.15, 0.004)
NOMINAL = Leg("pendulum", (Joint("hinge", LINK, spring=Spring(1.0, 0.1), damper=Damper(0.01)),))
FRICTION = 0.03  # N m
WITH_FRICTION = NOMINAL.with_joints(hinge={"effects": {"coulomb_friction": {"torque": FRICTION}}})
TIME = np.arange(301) * 0.01
RELEASES = {"a": 0.5, "b": -0.35, "c": 0.25, "check": 0.65}  # rad from the free angle


@pytest.fixture
def pendulum(tmp_path: Path) -> Callable[..., Path]:
    """A function that makes projects from a pendulum's recordings and additions to the project file."""

    def made(
        name: str = "project", text: str = "", copies: dict[str, str] | None = None, built: Leg = WITH_FRICTION
    ) -> Path:
        folder = tmp_path / name
        (folder / "trials").mkdir(parents=True)
        write_leg(NOMINAL, folder / "nominal.leg.yaml")
        generator = np.random.default_rng(8)
        for trial, away in RELEASES.items():
            angle = np.degrees(simulate(built, [0.1 + away], [0.0], TIME)[:, 0]) + generator.normal(0.0, 0.1, len(TIME))
            rows = [f"{t:.2f},{a:.4f}" for t, a in zip(TIME, angle, strict=True)]
            (folder / "trials" / f"{trial}.csv").write_text("\n".join(["time [s],hinge [deg]", *rows, ""]))
        for copy, original in (copies or {}).items():
            shutil.copy(folder / "trials" / f"{original}.csv", folder / "trials" / f"{copy}.csv")
        text = text or 'trials: ["trials/[a-c].csv", {file: trials/check.csv, held_out: true}]\n'
        (folder / "gap.yaml").write_text(f"kind: gap\nleg: nominal.leg.yaml\n{text}")
        return folder

    return made


def run(folder: Path) -> Json:
    """Run and give ``gap.json``."""
    assert main(["-q", "gap", str(folder / "gap.yaml"), "--out", str(folder / "out")]) == 0
    found: Json = json.loads((folder / "out" / "gap.json").read_text())
    assert (folder / "out" / "report.html").is_file()
    read_leg(folder / "out" / "diagnosed.leg.yaml")
    return found


def numbers_of(gap: Json) -> Json:
    """The diagnosis without the names of its input."""
    return {
        key: gap[key] for key in ("verdict", "sentence", "explanation", "ranked", "gap", "where", "next_experiment")
    }


def test_the_friction_is_found_repeatably(pendulum: Callable[..., Path]) -> None:
    gap = run(pendulum())
    assert gap["verdict"] in ("effect", "tie")
    assert (gap["explanation"][0]["effect"], gap["explanation"][0]["joint"]) == ("coulomb_friction", "hinge")
    assert gap["explanation"][0]["parameters"]["torque"]["value"] == pytest.approx(FRICTION, rel=0.1)
    assert gap["gap"]["after"]["value"] < 0.3 * gap["gap"]["before"]["value"]
    assert gap["warnings"] == []
    assert numbers_of(run(pendulum("again"))) == numbers_of(gap)


@pytest.mark.slow  # like ``diagnosis/test_diagnosis``, by files
def test_identical_copies_do_not_count_twice(pendulum: Callable[..., Path]) -> None:
    given = 'trials: ["trials/*.csv"]\n'
    once = run(pendulum("once", given))
    thrice = run(pendulum("thrice", given, {"e": "a", "f": "a"}))
    assert numbers_of(thrice) == numbers_of(once)
    said = " ".join(thrice["warnings"])
    assert "trials/e.csv is a copy of trials/a.csv" in said
    assert "trials/f.csv is a copy of trials/" in said


def test_a_held_out_copy_of_a_given_trial_is_not_unseen(pendulum: Callable[..., Path]) -> None:
    text = 'trials: ["trials/[a-c].csv", {file: trials/z.csv, held_out: true}]\n'
    gap = run(pendulum("copied", text, {"z": "a"}))
    assert "trials/z.csv" not in gap["gap"]["scored_on"]
    assert any("trials/z.csv is a copy of trials/a.csv" in item for item in gap["warnings"])


def test_one_trial_is_diagnosed_with_a_warning(pendulum: Callable[..., Path]) -> None:
    gap = run(pendulum("one", "trials: [trials/a.csv]\n"))
    assert gap["gap"]["scored_on"] == ["trials/a.csv"]
    assert any(item.startswith("only one training trial") for item in gap["warnings"])


def test_a_leg_without_tolerances_is_diagnosed(pendulum: Callable[..., Path]) -> None:
    zero = "length: 0 %, mass: 0 %, com: 0 %, inertia: 0 %, spring: 0 %, damper: 0 %, free_angle: 0 deg"
    text = f'trials: ["trials/[a-c].csv", {{file: trials/check.csv, held_out: true}}]\ntolerance: {{{zero}}}\n'
    gap = run(pendulum("exact", text))
    assert gap["explanation"][0]["effect"] == "coulomb_friction"
    assert gap["gap"]["as_designed"] == gap["gap"]["before"]


def test_a_known_torque_causes_no_gap(pendulum: Callable[..., Path]) -> None:
    """A recorded torque is applied: a trial that it drove is explained by it."""
    folder = pendulum("driven", "trials: [trials/driven.csv, trials/driven_2.csv]\n")
    torque = 0.05 * np.sin(4.0 * TIME)
    generator = np.random.default_rng(1)
    for name, away in (("driven", 0.4), ("driven_2", -0.3)):
        motion = simulate(NOMINAL, [0.1 + away], [0.0], TIME, known_torque=(TIME, torque[:, None]))
        angle = np.degrees(motion[:, 0]) + generator.normal(0.0, 0.1, len(TIME))
        rows = [f"{t:.2f},{a:.4f},{u:.6f}" for t, a, u in zip(TIME, angle, torque, strict=True)]
        text = "\n".join(["time [s],hinge [deg],hinge torque [N*m]", *rows, ""])
        (folder / "trials" / f"{name}.csv").write_text(text)
    gap = run(folder)
    assert gap["verdict"] == "none"
    assert gap["gap"]["before"]["value"] == pytest.approx(0.1, rel=0.15)
    assert any("applied as known torques" in item for item in gap["warnings"])


@pytest.mark.parametrize("command", ["gap", "fit"])
def test_a_torque_sampled_more_densely_than_the_angle_is_applied(
    pendulum: Callable[..., Path], tmp_path: Path, command: str
) -> None:
    """Pulses of 3 ms between samples 10 ms apart: all that moves the leg in the second half of each trial."""
    folder = pendulum("dense", "trials: [trials/driven.csv, trials/driven_2.csv]\n")
    moments = np.round(np.arange(0.0, TIME[-1] + 5e-4, 1e-3), 6)
    generator = np.random.default_rng(1)
    pulses = np.zeros(len(moments))
    for at in generator.uniform(0.1, TIME[-1] - 0.1, 12):
        pulses[(moments > at) & (moments < at + 3.5e-3)] = generator.choice([-4.0, 4.0])
    for name, away in (("driven", 0.2), ("driven_2", -0.3)):
        motion = simulate(NOMINAL, [0.1 + away], [0.0], TIME, known_torque=(moments, pulses[:, None]))
        angle = np.degrees(motion[:, 0]) + generator.normal(0.0, 0.1, len(TIME))
        cells = dict(zip(np.round(TIME, 6).tolist(), angle.tolist(), strict=True))
        rows = [f"{t:.4f},{cells.get(t, '')},{u:g}" for t, u in zip(moments.tolist(), pulses.tolist(), strict=True)]
        text = "\n".join(["time [s],hinge [deg],hinge torque [N*m]", *rows, ""])
        (folder / "trials" / f"{name}.csv").write_text(text)
    if command == "gap":
        gap = run(folder)
        assert gap["verdict"] == "none"
        assert gap["gap"]["before"]["value"] == pytest.approx(0.1, rel=0.2)
        return
    (folder / "fit.yaml").write_text(
        "kind: fit\nleg: nominal.leg.yaml\ntrials: [trials/driven*.csv]\n"
        "tolerance: {length: 0 %, mass: 0 %, com: 0 %, inertia: 0 %}\n"  # the interval is to be that of the torque
    )
    assert main(["-q", "fit", str(folder / "fit.yaml"), "--out", str(tmp_path / "out")]) == 0
    fit = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert fit["rms"]["hinge"]["value"] == pytest.approx(0.1, rel=0.2)
    wanted = NOMINAL.joints[0].spring
    assert wanted is not None
    low, high = fit["joints"]["hinge"]["spring_rate"]["interval90"]
    assert abs(fit["joints"]["hinge"]["spring_rate"]["value"] / wanted.rate - 1.0) < 0.02
    assert high - low < 0.05 * wanted.rate


def test_a_users_effect_is_found_among_the_built_in_ones(
    pendulum: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drag by the cube of speed is found, and known to be one with drag by a free power of speed."""
    monkeypatch.setattr(effects, "from_files", {})
    (tmp_path / "cubic.py").write_text(CUBIC_DRAG)
    load_file(tmp_path / "cubic.py")
    drag = {"cubic_drag": {"strength": 0.004}}
    folder = pendulum("own", built=NOMINAL.with_joints(hinge={"effects": drag}))
    command = ["-q", "gap", str(folder / "gap.yaml"), "--effect", str(tmp_path / "cubic.py")]
    assert main([*command, "--out", str(tmp_path / "out")]) == 0
    gap = json.loads((tmp_path / "out" / "gap.json").read_text())
    named = {entry["effect"]: entry for entry in gap["ranked"]}
    assert named["cubic_drag"]["probability"] > 0.3
    assert named["cubic_drag"]["parameters"]["strength"]["value"] == pytest.approx(0.004, rel=0.1)
    assert named["cubic_drag"]["probability"] + named["quadratic_damping"]["probability"] > 0.9
    assert gap["inputs"]["cubic.py"]


def test_a_held_out_trial_with_a_locked_joint_is_scored(tmp_path: Path) -> None:
    """Its cells are empty, and the rest of it counts."""
    shutil.copytree(EXAMPLE, tmp_path / "project")
    text = (EXAMPLE / "gap.yaml").read_text()
    project = tmp_path / "project" / "gap.yaml"
    project.write_text(text.replace("locked: [hip]}", "locked: [hip], held_out: true}"))
    gap = run(tmp_path / "project")
    assert "trials/locked_hip.csv" in gap["gap"]["scored_on"]
    lines = (tmp_path / "project" / "out" / "predicted" / "locked_hip.csv").read_text().splitlines()
    header, first = lines[0].split(","), lines[1].split(",")
    assert first[header.index("hip measured [deg]")] == ""
    assert first[header.index("knee measured [deg]")] != ""
    (trial,) = (trial for trial in gap["trials"] if trial["file"] == "trials/locked_hip.csv")
    assert set(trial["rms"]) == {"knee", "ankle"}


def test_the_example_names_the_friction_at_the_knee(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLE, tmp_path / "project")
    gap = run(tmp_path / "project")
    truth = json.loads((EXAMPLE / "truth.json").read_text())["coulomb_friction"]
    assert gap["verdict"] == "effect"
    assert [(cause["effect"], cause["joint"]) for cause in gap["explanation"]] == [("coulomb_friction", truth["joint"])]
    (friction,) = (e for e in gap["ranked"] if (e["effect"], e["joint"]) == ("coulomb_friction", truth["joint"]))
    assert friction["parameters"]["torque"]["value"] == pytest.approx(truth["torque"]["value"], rel=0.03)
    assert gap["gap"]["shrink"]["value"] > 0.9
    assert sum(e["probability"] for e in gap["ranked"] if "friction" in e["effect"]) > 0.93  # some doubt is always left
    (falling,) = (e for e in gap["ranked"] if (e["effect"], e["joint"]) == ("stribeck_friction", truth["joint"]))
    errors = {stage: gap["gap"][stage]["value"] for stage in ("as_designed", "before", "after")}
    for stated in (
        f"finds {friction['parameters']['torque']['value']:.3f} N·m of friction",
        f"({100 * friction['probability']:.0f} %; that it falls with speed, {100 * falling['probability']:.0f} %)",
        "from {as_designed:.2f}° as designed, or {before:.2f}° at best within the tolerances, to {after:.2f}°".format(
            **errors
        ),
    ):
        assert stated in " ".join((DOCS / "why_otherwise.md").read_text(encoding="utf-8").split())
