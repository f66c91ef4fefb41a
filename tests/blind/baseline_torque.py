"""A baseline without simulation: the torque that the nominal leg lacks, regressed on what each effect would add; BIC.

The missing torque in windows (weak form, no second derivative) is a sum of columns: springs' and dampers' rates, which
every model has, and one effect's. Effects that bend the model's structure (a moving base, a bending link) have no
column and coarse counts no torque: this method cannot name them. A column's inner parameters are those from which the
diagnosis, too, starts; the best of several counts, and each counts as an unknown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from blind.views import Key, View
from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_where import missing_torque
from synth.files.gap_project import GapProject
from synth.fit.recordings import recordings
from synth.swing.effects.torque_along_motion import AlongMotion, torque_along
from synth.swing.leg_model import Leg

OVERLAP = 4  # windows that share their samples
SAMPLES = 1500  # of a trial that columns are computed at
TINY = 1e-3


@dataclass(frozen=True)
class _Model:
    key: Key
    columns: Array  # (rows, k)
    unknowns: int


def bic(project: GapProject) -> View:
    """Weights of all single effects and of none, exp(-BIC / 2) (Schwarz, Ann. Stat. 6 (1978) 461; Raftery 1995)."""
    leg = project.leg
    made = recordings(leg, project.trials, ())
    given = [angle_trial(r, held_out=False) for r, t in zip(made, project.trials, strict=True) if not t.held_out]
    lacking = [missing_torque(leg, trial).torque for trial in given]
    target = _stacked(lacking)
    known = np.isfinite(target)
    always = _rates(leg, given, lacking)
    weight = _weights(target, always, known, len(leg.joints))

    def value(columns: Array, unknowns: int) -> float:
        matrix, y = (columns * weight[:, None])[known], (target * weight)[known]
        size = np.linalg.norm(matrix, axis=0)
        matrix = matrix[:, size > 0.0] / size[size > 0.0]
        left = y - matrix @ np.linalg.lstsq(matrix, y, rcond=1e-10)[0]
        count = len(y) / OVERLAP
        return float(count * math.log(float(left @ left) / len(y)) + unknowns * math.log(count))

    nothing = value(always, always.shape[1])
    best: dict[Key, float] = {}
    for model in _models(project, given, lacking):
        found = value(np.hstack([always, model.columns]), always.shape[1] + model.unknowns)
        best[model.key] = min(best.get(model.key, math.inf), found)
    least = min(nothing, *best.values())
    weights = {key: math.exp(-0.5 * (v - least)) for key, v in best.items()}
    none = math.exp(-0.5 * (nothing - least))
    total = none + sum(weights.values())
    ranked = sorted(weights, key=lambda key: best[key])
    verdict = "none" if nothing <= least else "effect"
    return View(
        verdict,
        tuple((key, weights[key] / total) for key in ranked),
        () if verdict == "none" else tuple(ranked[:2]),
        none=none / total,
    )


def _stacked(torques: Sequence[Array]) -> Array:
    """(rows,) joint by joint, trials one after the other."""
    return np.concatenate(torques).T.ravel()


def _difference(leg: Leg, trials: Sequence[AngleTrial], lacking: Sequence[Array]) -> Array:
    """(rows,) change of the missing torque relative to ``lacking``."""
    changed = [missing_torque(leg, trial).torque for trial in trials]
    return np.nan_to_num(_stacked([b - a for a, b in zip(lacking, changed, strict=True)]))


def _pushed(leg: Leg, trials: Sequence[AngleTrial], lacking: Sequence[Array], torques: Sequence[Array]) -> Array:
    """(rows,) of a torque (n_time, n) a trial, on its smoothed times, averaged over the windows."""
    moved = []
    for trial, torque in zip(trials, torques, strict=True):
        recording = trial.recording
        before = recording.known_torque
        time = recording.smoothed.time
        if before is not None:
            torque = torque + np.stack([np.interp(time, before[0], t) for t in before[1].T], axis=1)
        moved.append(replace(trial, recording=replace(recording, known_torque=(time, torque))))
    return -_difference(leg, moved, lacking)


def _rates(leg: Leg, trials: Sequence[AngleTrial], lacking: Sequence[Array]) -> Array:
    """(rows, 2 n) of the springs' and dampers' rates."""
    columns = []
    for j in range(len(leg.joints)):
        for kind in ("spring", "damper"):
            torques = []
            for trial in trials:
                smoothed = trial.recording.smoothed
                torque = np.zeros_like(smoothed.angle)
                moving = smoothed.angle - leg.rest if kind == "spring" else smoothed.rate
                torque[:, j] = -moving[:, j]
                torques.append(torque)
            columns.append(_pushed(leg, trials, lacking, torques))
    return np.stack(columns, axis=1)


def _weights(target: Array, always: Array, known: Array, n: int) -> Array:
    """(rows,) one over the RMS of each joint's torque that rates alone leave."""
    rows = np.arange(len(target)).reshape(n, -1)
    weight = np.zeros(len(target))
    for part in rows:
        here = part[known[part]]
        if len(here):
            left = target[here] - always[here] @ np.linalg.lstsq(always[here], target[here], rcond=1e-10)[0]
            weight[part] = 1.0 / max(float(np.sqrt(np.mean(left**2))), 1e-15)
    return weight


# Wrong springs and dampers: this baseline frees each joint's rates anyway, so as causes they would count twice.
ALWAYS_THERE = ("spring_rate", "viscous_damping", "armature")


def _models(project: GapProject, trials: Sequence[AngleTrial], lacking: Sequence[Array]) -> Iterator[_Model]:
    leg = project.leg
    for candidate in candidates(leg, trials, natural_sizes_of(leg, trials)):
        way = candidate.effect.way
        if candidate.effect.name in ALWAYS_THERE:
            continue
        if way == "torque":
            for start in candidate.starts():
                torques = [_along(candidate, start, leg, trial) for trial in trials]
                yield _Model(candidate.key, _pushed(leg, trials, lacking, torques)[:, None], candidate.size)
        elif way == "leg":
            columns = [_difference(other, trials, lacking) / TINY for other in _changed(leg, candidate)]
            yield _Model(candidate.key, np.stack(columns, axis=1), len(columns))
        elif way == "reading" and candidate.shape.free != ("lag",):
            seen = [_as_read(leg, candidate, trial) for trial in trials]
            yield _Model(candidate.key, _difference(leg, seen, lacking)[:, None] / TINY, 1)


def _along(candidate: Candidate, start: Array, leg: Leg, trial: AngleTrial) -> Array:
    """(n_time, n) N m, the effect's torque along the recorded motion at a starting point of its parameters."""
    smoothed, j = trial.recording.smoothed, candidate.joint
    every = max(1, len(smoothed.time) // SAMPLES)
    time, angle, rate = smoothed.time[::every], smoothed.angle[::every, j], smoothed.rate[::every, j]
    joint = leg.joints[j]
    spring = joint.spring.rate if joint.spring else 0.0
    damper = (joint.damper.rate or 0.0) if joint.damper else 0.0
    weight = leg.gravity * (sum(other.link.mass for other in leg.joints[j:]) + trial.recording.conditions.tip_mass)
    motion = AlongMotion(time, angle, rate, angle - joint.rest, spring, damper, damper * rate, weight)
    found = torque_along(candidate.effect, motion, candidate.in_rotation(start[:, None])[:, 0])
    torque = np.zeros_like(smoothed.angle)
    torque[:, j] = np.interp(smoothed.time, time, found)
    return torque


def _changed(leg: Leg, candidate: Candidate) -> list[Leg]:
    """The leg with each of the effect's numbers changed by a thousandth (of itself, or of a radian)."""
    name, j = candidate.effect.name, candidate.joint
    joint = leg.joints[j]
    link, spring = joint.link, joint.spring
    if name == "base_tilt":
        return [replace(leg, tilt=leg.tilt + TINY)]
    more = 1.0 + TINY
    if name == "link_mass":
        links = [replace(link, mass=link.mass * more, inertia=link.inertia * more)]
    elif name == "link_inertia":
        links = [replace(link, com=link.com * more), replace(link, inertia=link.inertia * more)]
    elif name == "spring_preload" and spring is not None:
        moved = replace(joint, spring=replace(spring, free_angle=spring.free_angle + TINY))
        return [replace(leg, joints=(*leg.joints[:j], moved, *leg.joints[j + 1 :]))]
    else:
        raise ValueError(f"{name} changes the leg in a way that this baseline does not know")
    return [replace(leg, joints=(*leg.joints[:j], replace(joint, link=x), *leg.joints[j + 1 :])) for x in links]


def _as_read(leg: Leg, candidate: Candidate, trial: AngleTrial) -> AngleTrial:
    """The trial as read with an encoder error of a thousandth (of a radian, of a second)."""
    smoothed, j, name = trial.recording.smoothed, candidate.joint, candidate.effect.name
    angle, rate = smoothed.angle.copy(), smoothed.rate.copy()
    if name == "encoder_offset":
        angle[:, j] += TINY
    elif name == "encoder_scale":
        angle[:, j] += TINY * (angle[:, j] + leg.joints[j].sign * leg.joints[j].zero)
        rate[:, j] *= 1.0 + TINY
    elif name == "latency":
        angle[:, j] += TINY * rate[:, j]
        rate[:, j] += TINY * np.gradient(rate[:, j], smoothed.time)
    else:
        raise ValueError(f"{name} changes the reading in a way that this baseline does not know")
    return replace(trial, recording=replace(trial.recording, smoothed=replace(smoothed, angle=angle, rate=rate)))
