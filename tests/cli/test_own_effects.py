"""A leg that holds an effect of the user's own: every command reads it with ``--effect``, and no other way."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import synth
from diagnosis.made_effect import CUBIC_DRAG
from synth.cli import main, parser_of
from synth.commands.common_options import WITH_EFFECTS
from synth.errors import UserError
from synth.files.program_versions import versions
from synth.files.run_manifest import sha256_file
from synth.files.stage_cache import key_of
from synth.swing import effects
from synth.swing.foreign_effects import OwnFile, know, known_effects

INERTIA = 0.004 + 0.5 * 0.15**2  # kg m^2 about the joint
RATE, DAMPING, DRAG = 1.0, 0.01, 0.004  # N m/rad, N m s/rad, N m at 1 rad/s
LEG = f"""kind: leg
name: pendulum
joints:
  - name: hinge
    zero: 0 deg
    sign: +1
    link: {{length: 300 mm, mass: 0.5 kg, com: 150 mm, inertia: 0.004 kg*m^2}}
    spring: {{rate: 0.9 N*m/rad, free_angle: 0.1 rad}}
    damper: {{rate: 0.02 N*m*s/rad}}
    effects: [cubic_drag: {{strength: {DRAG} N*m}}]
"""
HINT = "can hold (one of your own: give its file with --effect FILE.py, in Python with synth.load_effect, or install a "


@pytest.fixture(autouse=True)
def forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test loads is forgotten afterwards."""
    monkeypatch.setattr(effects, "from_files", {})


@pytest.fixture
def bench(tmp_path: Path) -> Path:
    """Projects on a pendulum with drag by the cube of its speed, whose motion ``solve_ivp`` computed."""
    folder = tmp_path / "bench"
    (folder / "trials").mkdir(parents=True)
    generator, time = np.random.default_rng(4), np.arange(201) * 0.01

    def change(_: float, state: np.ndarray) -> list[float]:
        angle, rate = state
        torque = -RATE * (angle - 0.1) - DAMPING * rate - DRAG * rate**3 - 0.5 * 9.81 * 0.15 * np.sin(angle)
        return [rate, torque / INERTIA]

    for name, start in (("a", 0.8), ("b", -0.6), ("c", 0.5)):
        angle = solve_ivp(change, (0.0, 2.0), [start, 0.0], t_eval=time, rtol=1e-9, atol=1e-10).y[0]
        read = np.degrees(angle) + generator.normal(0.0, 0.05, len(time))
        rows = [f"{t:.2f},{a:.4f}" for t, a in zip(time, read, strict=True)]
        (folder / "trials" / f"{name}.csv").write_text("\n".join(["time [s],hinge [deg]", *rows, ""]))
    (folder / "own.leg.yaml").write_text(LEG)
    (folder / "fit.yaml").write_text("kind: fit\nleg: own.leg.yaml\ntrials: [trials/*.csv]\nrelease: recorded\n")
    (folder / "gap.yaml").write_text("kind: gap\nleg: own.leg.yaml\ntrials: [trials/*.csv]\n")
    source = "source: {leg: own.leg.yaml, trials: [trials/*.csv]}"
    (folder / "leg.yaml").write_text(f"kind: leg-design\n{source}\ntarget: own.leg.yaml\n")
    (folder / "mine.py").write_text(CUBIC_DRAG)
    return folder


COMMANDS = {
    "fit": ["fit", "fit.yaml", "--dry-run"],
    "gap": ["gap", "gap.yaml", "--dry-run"],
    "leg": ["leg", "leg.yaml", "--dry-run"],
    "import": ["import", "trials/a.csv", "--leg", "own.leg.yaml", "--dry-run"],
    "compare": ["compare", "a=own.leg.yaml", "b=own.leg.yaml"],
    "check": ["check", "own.leg.yaml"],
}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_knows_the_effects_that_it_is_given(
    command: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(bench)
    words = [*COMMANDS[command], "--out", "out"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert f'"cubic_drag" is no effect that a joint {HINT}package' in said
    assert main([*words, "--effect", "mine.py"]) == 0
    assert "cubic_drag" not in [effect.name for effect in effects.registered()]
    assert main(words) == 2


def test_each_command_that_reads_a_swinging_leg_takes_effects() -> None:
    assert set(COMMANDS) == set(WITH_EFFECTS)
    for command in WITH_EFFECTS:
        assert "--effect" in parser_of(command)._option_string_actions


def test_a_fit_and_the_workers_of_a_folder_simulate_the_effect(bench: Path, tmp_path: Path) -> None:
    command = ["-q", "fit", str(bench / "fit.yaml"), "--out", str(tmp_path / "one"), "--effect", str(bench / "mine.py")]
    assert main(command) == 0
    (bench / "gap.yaml").unlink()
    command = ["-q", "fit", str(bench), "--out", str(tmp_path / "many"), "--effect", str(bench / "mine.py")]
    assert main(command) == 0
    one, many = (
        json.loads((tmp_path / path / "fit.json").read_text(encoding="utf-8")) for path in ("one", "many/legs/fit")
    )
    assert one == many
    assert set(one["inputs"]) == {"fit.yaml", "own.leg.yaml", "mine.py", *(f"trials/{name}.csv" for name in "abc")}
    found = one["joints"]["hinge"]
    assert found["spring_rate"]["value"] == pytest.approx(RATE, rel=0.005)
    assert found["damper_rate"]["value"] == pytest.approx(DAMPING, rel=0.05)
    assert found["free_angle"]["value"] == pytest.approx(np.degrees(0.1), abs=0.1)
    assert "cubic_drag" in (tmp_path / "one" / "fitted.leg.yaml").read_text(encoding="utf-8")


def test_the_library_knows_an_effect_that_it_has_loaded(bench: Path) -> None:
    with pytest.raises(UserError, match=r"with synth\.load_effect"):
        synth.read_leg(bench / "own.leg.yaml")
    assert synth.load_effect(bench / "mine.py").name == "cubic_drag"
    leg = synth.read_leg(bench / "own.leg.yaml")
    made = synth.Leg("made", (synth.Joint("hinge", leg.joints[0].link, effects={"cubic_drag": {"strength": DRAG}}),))
    assert synth.compare({"read": leg}, {"made": made}).result.inputs["mine.py"]
    fit = synth.fit(bench / "fit.yaml")
    assert fit.joints["hinge"].damper_rate.value == pytest.approx(DAMPING, rel=0.05)
    with pytest.raises(UserError, match="is no file's name"):
        synth.load_effect(b"mine.py")  # type: ignore[arg-type]


def test_an_imported_leg_is_fitted_with_the_effects_of_its_import(
    bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(bench)
    words = ["import", "trials/a.csv", "--leg", "own.leg.yaml", "--out", "new", "--effect", "mine.py"]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "synth fit new/fit.yaml --out new_fit --effect mine.py" in told


def test_a_project_names_no_effect_file(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its code would run because somebody's project was opened."""
    (bench / "mine.py").write_text("raise SystemError('executed')\n")
    for key in ("effect", "effects"):
        text = (bench / "fit.yaml").read_text()
        (bench / "other.yaml").write_text(f"{text}{key}: [mine.py]\n")
        assert main(["fit", str(bench / "other.yaml"), "--out", str(bench / "out")]) == 2
        assert "executed" not in capsys.readouterr().err


def test_an_effect_is_refused_where_it_cannot_act(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = ["--effect", str(bench / "mine.py")]
    assert main(["init", "hopper", str(bench / "hop")]) == 0
    assert main(["check", str(bench / "hop" / "hopper.yaml"), *own]) == 2
    assert "--effect applies to swinging legs" in capsys.readouterr().err
    (bench / "gap.yaml").unlink()
    out = ["--out", str(bench / "many"), "--scheduler", "tcp://127.0.0.1:1"]
    assert main(["fit", str(bench), *out, *own]) == 2
    assert "mine.py: --effect: is a file of this machine" in capsys.readouterr().err


def test_a_design_in_which_an_effect_acts_says_what_no_export_holds(bench: Path, tmp_path: Path) -> None:
    own = ["--effect", str(bench / "mine.py")]
    assert main(["-q", "leg", str(bench / "leg.yaml"), "--out", str(tmp_path / "out"), "--no-cad", *own]) == 0
    told = json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8"))["warnings"]
    words = " ".join(item["text"] for item in told)
    assert "cubic_drag of the hinge is in every simulated leg" in words
    assert "leg.mjcf.xml does not represent all of the leg: hinge: not held: cubic_drag" in words


def test_results_of_another_version_of_an_effect_are_not_reused(bench: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The version of its file, or of what the file imports."""
    monkeypatch.syspath_prepend(bench)
    imports = CUBIC_DRAG.replace("\n\n\n@inlined", "\nfrom drag_numbers import FACTOR\n\n\n@inlined", 1)
    used = imports.replace("-strength *", "-FACTOR * strength *")
    keys = [key_of("leg")]
    assert "effect cubic_drag" not in versions()
    for factor, text in (("1.0", imports), ("1.0", used), ("20.0", used), ("1.0", used)):
        (bench / "drag_numbers.py").write_text(f"FACTOR = {factor}\n")
        (bench / "mine.py").write_text(text)
        with known_effects([str(bench / "mine.py")]):
            keys.append(key_of("leg"))
            assert "effect cubic_drag" in versions()
        del sys.modules["drag_numbers"]
    assert len(set(keys)) == 4
    assert keys[2] == keys[4]
    assert key_of("leg") == keys[0]


def test_a_worker_refuses_a_file_that_was_changed_meanwhile(bench: Path) -> None:
    know(OwnFile(bench / "mine.py", sha256_file(bench / "mine.py")))
    with pytest.raises(UserError, match="was changed while the command ran"):
        know(OwnFile(bench / "mine.py", "of another"))
