"""Parts chosen for the diagnosed leg against parts chosen without the diagnosis: the whole loop once.

The built-in example's robot is designed, built with a knee whose dry friction nobody knew of and with links off within
tolerance, recorded, diagnosed, and designed again for the diagnosed leg.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, recorded, with_effects
from peers.mujoco_leg import simulate as simulate_mujoco
from synth.arrays import Array
from synth.design.leg_design import LegDesign, design_leg
from synth.design.target_effects import notes, target_of
from synth.design.write_design import design_json
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.files.gap_project import Tolerance
from synth.files.leg_file import write_leg
from synth.files.projects import read_leg_project
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.recordings import recordings
from synth.parts.catalogs import Catalogue
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "leg"
FRICTION = 0.15  # N m, at the knee: a tenth of what its spring does at 1 rad
NOISE = np.radians(0.1)


def as_built(design: Leg) -> Leg:
    """Links a per cent or two off what was drawn, springs and free angles too, and a knee that rubs."""
    generator = np.random.default_rng(5)

    def off(value: float, share: float) -> float:
        return value * float(np.exp(share * generator.standard_normal()))

    joints = []
    for joint in design.joints:
        link, spring = joint.link, joint.spring
        assert spring is not None
        made = Link(off(link.length, 0.003), off(link.mass, 0.01), off(link.com, 0.01), off(link.inertia, 0.02))
        angle = spring.free_angle + np.radians(0.3) * float(generator.standard_normal())
        joints.append(replace(joint, link=made, spring=Spring(off(spring.rate, 0.02), angle), effects={}))
    return replace(design, joints=tuple(joints)).with_joints(
        knee={"effects": {"coulomb_friction": {"torque": FRICTION}}}
    )


def with_parts(real: Leg, design: Leg) -> Leg:
    """The real links and friction with the springs and dampers of a design."""
    joints = [
        replace(joint, spring=chosen.spring, damper=chosen.damper)
        for joint, chosen in zip(real.joints, design.joints, strict=True)
    ]
    return replace(real, joints=tuple(joints))


def errors(design: LegDesign, motions: Sequence[Array]) -> Array:
    """(n,) deg, RMS of each joint against the wanted motion."""
    away = [m - wanted for m, wanted in zip(motions, design.wanted.motions, strict=False)]
    return np.asarray(np.degrees(np.sqrt(np.mean(np.concatenate(away) ** 2, axis=0))))


@dataclass(frozen=True)
class Loop:
    """Both designs, what was diagnosed between them, and the leg that was really built."""

    blind: LegDesign
    gap: GapResult
    knowing: LegDesign
    real: Leg

    def moves(self, design: LegDesign) -> list[Array]:
        """(m, n) rad a wanted release, of the real leg with a design's parts."""
        leg = with_parts(self.real, design.built)
        return [simulate(leg, r.rotation, r.rate, r.time, r.conditions) for r in self.blind.wanted.releases]


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Loop:
    folder = tmp_path_factory.mktemp("loop") / "leg"
    shutil.copytree(EXAMPLE, folder)
    blind = design_leg(read_leg_project(folder / "leg-design.yaml"), Catalogue.load())
    real = as_built(blind.built)
    generator = np.random.default_rng(6)
    trials = []
    for number, release in enumerate(blind.wanted.releases[:5]):
        motion = real.to_measured(simulate(real, release.rotation, release.rate, release.time))
        noisy = motion + generator.normal(0.0, NOISE, motion.shape)
        trials.append(Trial(f"{number}.csv", release.time, noisy, held_out=number > 2))
    gap = diagnose(blind.built, trials, Tolerance())
    write_leg(gap.diagnosed, folder / "robot" / "diagnosed.leg.yaml")
    text = (folder / "leg-design.yaml").read_text()
    (folder / "again.yaml").write_text(text.replace("target: robot/robot", "target: robot/diagnosed"))
    knowing = design_leg(read_leg_project(folder / "again.yaml"), Catalogue.load())
    return Loop(blind, gap, knowing, real)


def test_the_friction_is_diagnosed_from_the_built_leg(loop: Loop) -> None:
    friction = loop.gap.diagnosed.joints[1].effects
    assert loop.gap.verdict in ("effect", "tie")
    assert any("friction" in name for name in friction)
    assert loop.gap.after.value < 0.3 * loop.gap.before.value


def test_parts_chosen_for_the_diagnosed_leg_reduce_the_error(loop: Loop) -> None:
    blind, knowing = (errors(loop.blind, loop.moves(design)) for design in (loop.blind, loop.knowing))
    assert np.sqrt(np.mean(knowing**2)) < 0.85 * np.sqrt(np.mean(blind**2))
    assert knowing[1] < 0.8 * blind[1]


def test_mujoco_agrees_on_both_designs(loop: Loop) -> None:
    """The leg with either design's parts by MuJoCo, whose smoothed friction creeps where true friction holds."""
    found = []
    for design in (loop.blind, loop.knowing):
        leg = with_parts(loop.real, design.built)
        moved = [
            simulate_mujoco(leg, r.rotation, r.rate, r.time, step=2.5e-4, friction_width=0.01)
            for r in loop.blind.wanted.releases
        ]
        found.append(errors(loop.blind, moved))
        np.testing.assert_allclose(found[-1], errors(loop.blind, loop.moves(design)), atol=0.2)
    assert found[1][1] < 0.8 * found[0][1]


def test_the_error_predicted_with_friction_is_the_error_found(loop: Loop) -> None:
    promised = {n: float(np.degrees(d.errors[1])) for n, d in (("blind", loop.blind), ("knowing", loop.knowing))}
    moved = {n: errors(loop.blind, loop.moves(d))[1] for n, d in (("blind", loop.blind), ("knowing", loop.knowing))}
    assert moved["knowing"] == pytest.approx(promised["knowing"], rel=0.15)
    assert moved["blind"] > 2.0 * promised["blind"]


def test_the_design_lists_the_effects_it_carried_over(loop: Loop, tmp_path: Path) -> None:
    content = design_json(loop.knowing, [], tmp_path, {})
    (taken,) = (item for item in content["target_effects"] if item["joint"] == "knee")
    assert taken["carried_over"]
    assert "friction" in taken["effect"]
    assert taken["parameters"]["torque"]["value"] == pytest.approx(FRICTION, rel=0.2)
    assert any("friction of the knee is in every simulated leg" in warning["text"] for warning in content["warnings"])
    assert design_json(loop.blind, [], tmp_path, {})["target_effects"] == []
    assert not any(joint.effects for joint in loop.knowing.target.leg.joints)


def test_effects_of_replaced_parts_are_dropped_and_listed() -> None:
    link = Link(0.2, 0.5, 0.1, 5e-3)
    effects = {
        "coulomb_friction": {"torque": 0.05},
        "backlash": {"width": 0.01},
        "quadratic_damping": {"coefficient": 0.001},
        "hardening_spring": {"stiffening": 0.3},
        "spring_hysteresis": {"stiffness": 0.1},
        "one_sided_spring": {"loss_above": 0.5},
        "shear_thinning_damping": {"loss": 0.5, "speed": 1.0},
        "encoder_offset": {"offset": 0.02},
        "link_flexibility": {"stiffness": 50.0},
    }
    joint = Joint("knee", link, spring=Spring(2.0, 0.1), damper=Damper(0.1), effects=effects)
    leg = Leg("one", (joint,), effects={"base_compliance": {"stiffness": 1e4}})
    target = target_of(leg)
    assert set(target.real.joints[0].effects) == {"coulomb_friction", "backlash", "quadratic_damping"}
    assert target.real.joints[0].effects["coulomb_friction"] == {"torque": 0.05}
    assert target.ideal.joints[0] == replace(joint, effects={})
    assert target.real.effects == target.ideal.effects == {}
    said = {e.effect.name: e.sentence for e in target.effects}
    assert set(said) == {*effects, "base_compliance"}
    for name in ("hardening_spring", "spring_hysteresis", "one_sided_spring"):
        assert said[name].startswith(f"{name} of the knee is left out: it belongs to the spring")
    assert "belongs to the damper" in said["shear_thinning_damping"]
    assert "does not change how the leg moves" in said["encoder_offset"]
    assert "of the base is left out: parts are chosen for a leg of rigid links" in said["base_compliance"]
    assert len(notes(target.effects)) == 10


def test_a_fit_warns_of_effects_it_ignores() -> None:
    effects = {"coulomb_friction": {"torque": 0.01}, "encoder_offset": {"offset": 0.02}}
    leg = replace(with_effects(ONE, {"knee": effects}), effects={"base_compliance": {"stiffness": 1e4}})
    result = fit_leg(leg, recordings(leg, recorded(ONE, held_out=0)))
    said = [warning for warning in result.warnings if "is ignored by the fit" in warning]
    assert [warning.split(" is ignored")[0] for warning in said] == ["knee: encoder_offset", "base_compliance"]
