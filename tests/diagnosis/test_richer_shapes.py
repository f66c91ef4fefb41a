"""A cause of a set in a richer shape: a mount that slides and rocks in place of one that slides."""

from __future__ import annotations

import numpy as np

from diagnosis.test_sets_of_causes import made as made
from diagnosis.test_sets_of_causes import one
from synth.diagnosis.angle_search import as_designed
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, scales
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import Scene
from synth.diagnosis.richer_shapes import in_richer_shapes


def test_what_both_shapes_free_keeps_its_value(made: Scene) -> None:
    bench, plain = made.bench, as_designed(made.bench)
    every = candidates(made.leg, made.given, scales(made.leg, made.given))
    mounts = [c for c in every if c.effect.name == "base_compliance"]
    slides = next(c for c in mounts if c.shape.free == ("stiffness", "mass", "damping_ratio"))
    mass, values = one(made, "link_mass"), np.array([0.5, 1.0, 2.0, 3.0])
    fit = bench.awake(EvaluatedHypothesis((mass, slides), np.concatenate([plain.unknowns, values]), plain.states))
    found = in_richer_shapes(bench, fit, every)
    assert len(found) == 2  # the first joint above or below the rocking point
    for start in found:
        richer = start.hypothesis[1]
        own = dict(zip(richer.shape.free, start.unknowns[bench.n_tolerance + 1 :], strict=True))
        assert richer.shape.richer
        assert start.unknowns[bench.n_tolerance] == 0.5
        assert [own[name] for name in slides.shape.free] == [1.0, 2.0, 3.0]
        assert len(start.states[0]) == 2 * len(bench.noise) + 2 * richer.links
    assert all(np.isfinite(start.cost) for start in bench.evaluate(found))
    assert in_richer_shapes(bench, found[0], every) == []
