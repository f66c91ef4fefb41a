"""A cause of a set in another shape: a spring stiffer on one side, kept as softer on the other; a mount that slides."""

from __future__ import annotations

import numpy as np

from diagnosis.test_sets_of_causes import made as made
from synth.diagnosis.angle_search import as_recorded, rms_over_noise
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.other_shapes import starts_in_other_shapes
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LEG = Leg("arm", (Joint("arm", Link(0.12, 0.2, 0.06, 3e-4), spring=Spring(0.3, 0.4), damper=Damper(0.004)),))
TIME = np.arange(0.0, 1.5, 0.004)
NOISE = 5e-5  # rad


def springy() -> tuple[Workbench, list[Candidate]]:
    """Releases of an arm whose spring is half as stiff again below its free angle, and whose joint turns a rotor."""
    built = LEG.with_joints(arm={"effects": {"one_sided_spring": {"loss_below": -0.5}}, "armature": 5e-4})
    rng, trials = np.random.default_rng(2), []
    for k, start in enumerate((-0.5, 0.9, 1.2)):
        angles = simulate(built, [start], [0.0], TIME)
        trials.append(Trial(f"{k}.csv", TIME, angles + NOISE * rng.standard_normal(angles.shape)))
    scene, _ = scene_of(LEG, trials, Tolerance(), 0, {"arm": NOISE})
    return scene.bench, candidates(LEG, scene.given, natural_sizes_of(LEG, scene.given))


def test_a_spring_kept_as_softer_on_the_other_side_finds_its_own_shape() -> None:
    """From every rung of the new strength, of either sign; what both shapes free keeps its value."""
    bench, every = springy()
    rotor = next(c for c in every if c.effect.name == "armature")
    softer = next(c for c in every if "loss_above" in c.shape.free)
    begun = as_recorded(bench)
    kept = EvaluatedHypothesis((softer, rotor), np.append(begun.unknowns, [0.5, 0.1, 0.2, 0.5]), begun.states)
    shapes = starts_in_other_shapes(bench, kept, every)
    (starts,) = [shape for shape in shapes if "loss_below" in shape[0].hypothesis[1].shape.free]
    lost = [float(start.unknowns[bench.n_tolerance + 1]) for start in starts]
    assert min(lost) < 0.0 < max(lost)
    assert all(start.unknowns[-2:].tolist() == [0.1, 0.2] for start in starts)
    (stuck,) = refine(bench, bench.evaluate([kept]))
    other = min(refine(bench, bench.evaluate(starts)), key=lambda fit: fit.cost)
    assert rms_over_noise(bench, stuck) > 3.0
    assert rms_over_noise(bench, other) < 1.1


def test_a_mount_that_rocks_is_tried_as_one_that_slides() -> None:
    """It has no more links; not in the shape that does both, which has."""
    bench, every = springy()
    mounts = [c for c in every if c.effect.name == "base_compliance"]
    rocks = next(c for c in mounts if "arm" in c.shape.free and not c.shape.richer)
    shift = next(c for c in every if c.effect.name == "encoder_offset")
    begun = as_recorded(bench)
    kept = bench.awake(begun.beside([rocks, shift], [np.zeros(rocks.size), np.ones(shift.size)]))
    (starts,) = starts_in_other_shapes(bench, kept, every)
    assert {start.hypothesis[1].shape.free for start in starts} == {("stiffness", "mass", "damping_ratio")}
    assert all(len(start.states[0]) == len(kept.states[0]) for start in starts)
    assert all(np.isfinite(start.cost) for start in bench.evaluate(starts))
