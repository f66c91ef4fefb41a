"""Motions whose cost has many minima: a driven pendulum with dry friction that turns over or nearly does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from diagnosis.turning_pendulum import recorded
from synth.diagnosis import score as scoring
from synth.diagnosis.angle_search import AngleExplorer, as_designed, search
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain import chain_diagnosis
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import Scene, scene_of
from synth.diagnosis.restarts import has_other_minima, refit_from_design

RUBS = {"coulomb_friction": {"torque": 0.25}, "quadratic_damping": {"coefficient": 0.002}}


@pytest.fixture
def whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whole recordings, as free motions are searched; driven ones would be cut where they have many minima."""
    monkeypatch.setattr(chain_diagnosis, "cut_into_pieces", lambda leg, predictor, trials: tuple(trials))


def scene(folder: Path, *made: object) -> Scene:
    project = recorded(folder, *made)  # type: ignore[arg-type]
    return scene_of(project.leg, project.trials, project.tolerance, 0)[0]


@pytest.mark.usefixtures("whole")
def test_dry_friction_and_drag_of_a_driven_pendulum_are_found_together(tmp_path: Path) -> None:
    """Either alone leaves at least five times what both leave."""
    made = scene(tmp_path, RUBS, 2, (1.6, 2.8), 2.5, 4)
    found = search(made.bench, candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given)), CALIBRATED)
    best = min(found.several, key=lambda item: item.cost)
    assert ("coulomb_friction", "hinge") in best.keys
    assert best.ratio < 0.2 * found.singles[0].ratio


@pytest.mark.usefixtures("whole")
def test_dry_friction_is_fitted_where_no_start_of_the_screening_reaches_it(tmp_path: Path) -> None:
    """The screening's starts end in other minima; fits from elsewhere bring it to the first place, unknowns charged."""
    made = scene(tmp_path, RUBS, 9, (1.6, 2.8), 2.5, 4)
    explorer = AngleExplorer(
        made.bench, candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given)), CALIBRATED
    )
    first = min(explorer.singles(), key=lambda fit: fit.cost + CALIBRATED.per_parameter * fit.hypothesis[0].size)
    assert first.keys == (("coulomb_friction", "hinge"),)


@pytest.mark.usefixtures("whole")
def test_a_trial_that_is_a_swing_off_gets_its_state_on_growing_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The nominal leg lacks the friction, so no state follows the trials exactly; some follow them within 30 deg."""
    made = scene(tmp_path, {"coulomb_friction": {"torque": 0.1}}, 0, (1.2, 2.2), 5.0, 8)
    fit = EvaluatedHypothesis((), np.zeros(made.bench.n_tolerance), ())

    def errors() -> list[float]:
        found = scoring.score(made.bench, fit, made.given)
        return [
            float(np.degrees(np.sqrt(np.mean((p - t.measured) ** 2))))
            for (p, _), t in zip(found, made.given, strict=True)
        ]

    grown = errors()
    monkeypatch.setattr(scoring, "FAR_OFF_RATIO", np.inf)
    plain = errors()
    assert all(a <= b * (1.0 + 1e-9) for a, b in zip(grown, plain, strict=True))
    assert max(plain) > 90.0
    assert max(grown) < 40.0


@pytest.mark.usefixtures("whole")
def test_a_smooth_cost_is_not_searched_from_elsewhere(tmp_path: Path) -> None:
    """Small motions: the best causes end where they were, fitted again from the leg as designed."""
    made = scene(tmp_path, {"coulomb_friction": {"torque": 0.1}}, 1, (0.3, 0.5), 2.5, 3)
    explorer = AngleExplorer(
        made.bench, candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given)), CALIBRATED
    )
    nominal, singles = explorer.none(), explorer.singles()
    framed = [fit for fit in singles if fit.frame is not None]
    ends = refit_from_design(made.bench, framed, as_designed(made.bench))
    assert not has_other_minima(framed, ends, nominal)


@pytest.mark.slow  # like the faults of ``make rigs``
def test_a_stated_armature_that_is_not_there_and_dry_friction_are_found_in_pieces(tmp_path: Path) -> None:
    """Either alone leaves at least 20 floors; from what the one alone fits, the two together were not found."""
    project = recorded(tmp_path, {"coulomb_friction": {"torque": 0.25}}, 5, (1.6, 2.8), 2.5, 4)
    leg = project.leg.with_joints(hinge={"armature": 4.2e-2})  # it has 0.002 kg m^2
    made, _ = scene_of(leg, project.trials, project.tolerance, 0)
    found = search(made.bench, candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given)), CALIBRATED)
    both = {("coulomb_friction", "hinge"), ("armature", "hinge")}
    assert min(single.ratio for single in found.singles if single.keys[0] in both) > 20.0
    assert min(item.ratio for item in found.several if set(item.keys) == both) < 1.3
