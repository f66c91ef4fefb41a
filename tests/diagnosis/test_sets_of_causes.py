"""Sets of causes made from others: a first cause that imitated two is left out again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.turning_pendulum import recorded
from synth.diagnosis.angle_search import as_designed
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain import chain_diagnosis
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import Scene, scene_of
from synth.diagnosis.sets_of_causes import pairs_of, with_simpler_cause, without_one_cause


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Scene:
    """A pendulum that rubs, its recordings whole."""
    monkeypatch.setattr(chain_diagnosis, "cut_into_pieces", lambda leg, predictor, trials: tuple(trials))
    project = recorded(tmp_path, {"coulomb_friction": {"torque": 0.1}}, 1, (0.3, 0.5), 2.5, 3)
    return scene_of(project.leg, project.trials, project.tolerance, 0)[0]


def one(made: Scene, effect: str) -> Candidate:
    every = candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given))
    return next(candidate for candidate in every if candidate.effect.name == effect)


def test_each_set_that_lacks_one_cause_starts_at_the_others_values(made: Scene) -> None:
    """Those with the causes of a known fit are not made again; an added link's state goes with its cause."""
    bench, plain = made.bench, as_designed(made.bench)
    causes = one(made, "link_mass"), one(made, "base_compliance"), one(made, "coulomb_friction")
    sizes = [cause.size for cause in causes]
    own = np.arange(1.0, 1.0 + sum(sizes))
    three = bench.awake(EvaluatedHypothesis(causes, np.concatenate([plain.unknowns, own]), plain.states))
    known = replace(three, hypothesis=causes[:2])
    found = without_one_cause(bench, [three], [known])
    assert [fit.keys for fit in found] == [
        (causes[1].key, causes[2].key),
        (causes[0].key, causes[2].key),
    ]
    first, second, third = np.split(own, np.cumsum(sizes)[:-1])
    size = bench.n_tolerance
    np.testing.assert_array_equal(found[0].unknowns[size:], np.concatenate([second, third]))
    np.testing.assert_array_equal(found[1].unknowns[size:], np.concatenate([first, third]))
    assert [len(fit.states[0]) for fit in found] == [4, 2]
    assert all(np.isfinite(fit.cost) for fit in bench.evaluate(found))


def test_sets_made_of_others_have_nothing_that_was_computed_for_these(made: Scene) -> None:
    """No cost, residuals, or derivatives of another set; initial states as many as their links need."""
    bench, plain = made.bench, as_designed(made.bench)
    soft, dry = one(made, "base_compliance"), one(made, "coulomb_friction")
    falling = one(made, "stribeck_friction")
    singles = [bench.awake(plain.beside([cause], [np.ones(cause.size)])) for cause in (soft, dry)]
    evaluated = [replace(fit, frame=plain.frame) for fit in bench.evaluate(singles)]
    rich = bench.evaluate([plain.beside([falling], [np.ones(falling.size)])])
    pairs, simpler = pairs_of(bench, evaluated), with_simpler_cause(bench, rich, evaluated)
    assert [fit.keys for fit in (*pairs, *simpler)] == [(dry.key, soft.key), (dry.key,)]
    for fit in (*pairs, *simpler):
        assert (fit.residuals, fit.columns, fit.cost, fit.frame) == ((), (), np.inf, None)
        assert len(fit.states[0]) == 2 + 2 * sum(cause.links for cause in fit.hypothesis)
