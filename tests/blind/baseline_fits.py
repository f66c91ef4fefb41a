"""Two baselines that fit trajectories with all parameters of the leg free, a common first approach.

They use the program's own engine; what is compared is the method. Free means twenty times the tolerances wide: a mass
may be off by half, a spring or damper by more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from blind.views import Key, View
from synth.diagnosis.angle_search import as_designed, fit_nominal, rms_over_noise
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.score import score
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import GapProject
from synth.fit.recordings import recordings
from synth.fit.sensor_noise import estimate_sensor
from synth.swing.tolerances import QUANTITIES, Tolerances

FREE = 20.0  # times the tolerances
INTEGRATION = 1e-5
KEPT = 12  # candidates that get a second step
NAMES = {  # effect that an all-parameter fit indicates by its most changed parameter: (larger, smaller)
    "length": ("link_inertia", "link_inertia"),
    "mass": ("link_mass", "link_mass"),
    "com": ("link_inertia", "link_inertia"),
    "inertia": ("link_inertia", "link_inertia"),
    "spring_rate": ("hardening_spring", "one_sided_spring"),
    "damper_rate": ("coulomb_friction", "shear_thinning_damping"),
    "rest": ("spring_preload", "spring_preload"),
}


@dataclass(frozen=True)
class Freed:
    """The best fit with all parameters free; ``held``: the scored trials."""

    bench: Workbench
    fit: EvaluatedHypothesis
    given: tuple[AngleTrial, ...]
    held: tuple[AngleTrial, ...]

    def after(self, fit: EvaluatedHypothesis) -> float:
        """RMS error on held-out trials, deg."""
        found = score(self.bench, fit, self.held)
        means = []
        for trial, (prediction, _) in zip(self.held, found, strict=True):
            away = np.where(trial.counts, prediction - trial.measured, 0.0)
            count = trial.counts.sum(axis=0)
            means.append(np.sum(away**2, axis=0)[count > 0] / count[count > 0])
        return math.degrees(math.sqrt(float(np.concatenate(means).mean())))


def free_fit(project: GapProject) -> Freed:
    """Fit all numbers of the leg and the initial states to the given trials."""
    made = recordings(project.leg, project.trials, ())
    trials = [angle_trial(r, held_out=t.held_out) for r, t in zip(made, project.trials, strict=True)]
    given = tuple(trial for trial in trials if not trial.held_out)
    held = tuple(trial for trial in trials if trial.held_out)
    wide = Tolerances(FREE * Tolerances.of(project.leg, project.tolerance).width)
    noise = estimate_sensor([trial.recording for trial in given]).noise
    bench = Workbench(Predictor(project.leg, wide, INTEGRATION), given, noise, math.inf)
    return Freed(bench, fit_nominal(bench, as_designed(bench)), given, held)


def least_residual(freed: Freed, project: GapProject) -> View:
    """Each candidate effect added to the free fit; the one with the smallest residual names the cause."""
    bench, base = freed.bench, freed.fit
    starts = [
        EvaluatedHypothesis((c,), np.concatenate([base.unknowns, c.starts()[0]]), base.states)
        for c in candidates(project.leg, freed.given, natural_sizes_of(project.leg, freed.given))
    ]
    best: dict[Key, tuple[float, EvaluatedHypothesis]] = {}
    fits = sorted(bench.solve(starts, base.frame, 1), key=lambda fit: fit.cost)
    for fit in [*bench.solve(fits[:KEPT], base.frame, 1), *fits[KEPT:]]:
        left = rms_over_noise(bench, fit) if np.isfinite(fit.cost) else math.inf
        if fit.keys[0] not in best or left < best[fit.keys[0]][0]:
            best[fit.keys[0]] = left, fit
    order = sorted(best, key=lambda key: best[key][0])
    return _named([(key, math.nan) for key in order], freed.after(best[order[0]][1]))


def largest_change(freed: Freed, project: GapProject) -> View:
    """The parameter that the free fit moves by most tolerances names the effect, see ``NAMES``."""
    names = project.leg.joint_names
    change = FREE * freed.fit.unknowns.reshape(len(QUANTITIES), len(names))
    order: list[Key] = []
    for index in np.argsort(-np.abs(change), axis=None):
        q, j = np.unravel_index(index, change.shape)
        if QUANTITIES[q] not in NAMES:  # a motor's number: these legs have none, and their widths are zero
            continue
        key = (NAMES[QUANTITIES[q]][0 if change[q, j] > 0 else 1], names[j])
        if key not in order:
            order.append(key)
    return _named([(key, math.nan) for key in order], freed.after(freed.fit))


def _named(ranked: list[tuple[Key, float]], after: float) -> View:
    """A method that always names a cause; for two causes its first two count."""
    return View("effect", tuple(ranked), tuple(key for key, _ in ranked[:2]), after=after)
