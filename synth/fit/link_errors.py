"""The effect of errors in the leg file's links and motors on the estimates.

The spring and damper rates that explain a swing are proportional to the links' inertia, so no rate is known better
than the links. Where a motor's torque tells the scale of the rates, none is known better than its constant and its
winding's resistance. The change of the estimates with each parameter follows from the sensitivities of the trajectories
(``estimation.consider``): one simulation with a few more lanes per trial, without refits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.consider import Considered
from synth.files.static_points_file import StaticPoint
from synth.files.tolerance import Tolerance
from synth.fit.following import follow_changes
from synth.fit.least_squares import Stage
from synth.fit.recordings import Recording, joints_by_current
from synth.fit.static_points import Balance, balances, spread_at
from synth.fit.trajectories import Index, Local, TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.lane_layout import LANES
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg
from synth.swing.tolerances import LINK_QUANTITIES, QUANTITIES, Tolerances

STEP = 1e-4  # of a logarithm; the integration's error at 1e-7 is a thousandth of the change
# Times the fit's limit of steps: a motion near it, as of a stiff leg driven by a hand, may need more with moved links.
STEPS_FACTOR = 4
WORDS = {
    **{name: f"{name} of the {{}}'s link" for name in LINK_QUANTITIES},
    "com": "centre of mass of the {}'s link",
    "torque_constant": "torque constant of the {}'s motor",
    "resistance": "resistance of the {}'s winding",
}


@dataclass(frozen=True)
class LinkErrors:
    """Uncertain parameters of links and motors, and their effect on the common unknowns.

    ``names`` : (joint, quantity) of each considered parameter, quantity a key of ``WORDS``. ``deviation`` (c,)
    of its logarithm. ``first`` : (k, n, c) rad a trial, change of the prediction of its first k samples per deviation
    of each parameter, the estimates and the trial's initial state following.
    """

    names: tuple[tuple[str, str], ...]
    deviation: Array
    considered: Considered
    first: tuple[Array, ...] = ()

    @property
    def covariance(self) -> Array:
        """(p, p) covariance of the common unknowns due to the links' errors."""
        return self.considered.covariance


def link_errors(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    widths: Array,
    static: Sequence[StaticPoint] = (),
    *,
    until: float = 0.0,
) -> LinkErrors | None:
    """The sensitivity of the estimates to links and motors; None if all are exact, or the motion diverges.

    Parameters
    ----------
    widths : (9, n) standard deviation of the logarithm of each of ``QUANTITIES``, see ``link_widths``.
    static : the static points of the fit, which depend on the same links' weight.
    until : s, end of the first samples, whose predictions' errors are wanted too.
    """
    open_ = np.flatnonzero(widths.ravel() > 0.0)
    solution = stage.solution
    if not len(open_) or not np.isfinite(solution.cost):
        return None
    deviation, legs = widths.ravel()[open_], _moved_legs(model.leg, open_, joints_by_current(recordings))

    def change(t: int) -> Array:
        return _prediction_changes(model, recordings[t], legs, solution.values, solution.locals[t]) * deviation

    spread = stage.weights.points
    beside = gradient_by_links(model, solution.values, widths, static, spread) if static else None
    found = follow_changes(model, recordings, stage, change, lambda recording: recording.time < until, beside)
    names = [(name, quantity) for quantity in QUANTITIES for name in model.leg.joint_names]
    return LinkErrors(tuple(names[k] for k in open_), deviation, found.considered, found.left)


def gradient_by_links(
    model: TrajectoryModel, values: Array, widths: Array, static: Sequence[StaticPoint], spread: Array | None = None
) -> Array:
    """(p, c) change of the static points' gradient per deviation of each uncertain parameter, the unknowns held.

    ``spread`` (n,) rad of the points' free angles, as in ``Weights.points``.
    """
    open_ = np.flatnonzero(widths.ravel() > 0.0)
    return _of_points(model, values, open_, static, spread) * widths.ravel()[open_]


def moved_leg(leg: Leg, widths: Array, deviations: Array, recordings: Sequence[Recording]) -> Leg:
    """The leg with each uncertain parameter moved by these ``deviations`` (c,), in the order of ``link_errors``."""
    moved = np.zeros(widths.size)
    open_ = np.flatnonzero(widths.ravel() > 0.0)
    moved[open_] = deviations * widths.ravel()[open_]
    return Tolerances(np.ones(widths.shape), tuple(joints_by_current(recordings))).leg(leg, moved)


def link_widths(leg: Leg, tolerance: Tolerance | None, recordings: Sequence[Recording]) -> Array:
    """(9, n) standard deviations of the logarithms for a project's tolerances; zero if all is exact.

    Those of springs, dampers and free angles, which a fit estimates, are zero too.
    """
    if tolerance is None:
        return np.zeros((len(QUANTITIES), len(leg.joints)))
    found = tolerance.widths(leg, joints_by_current(recordings))
    found[[k for k, name in enumerate(QUANTITIES) if name not in WORDS]] = 0.0
    return found


def _moved_legs(leg: Leg, numbers: Index, by_current: Sequence[int]) -> list[tuple[LegLanes, int]]:
    """Groups of lanes that step together: the nominal leg first, then each parameter moved by ``STEP``."""
    groups, unit = [], Tolerances(np.ones((len(QUANTITIES), len(leg.joints))), tuple(by_current))
    for first in range(0, len(numbers), LANES - 1):
        some = numbers[first : first + LANES - 1]
        x = np.zeros((unit.size, len(some) + 1))
        x[some, 1 + np.arange(len(some))] = STEP
        legs = LegLanes.of(leg, x.shape[1])
        unit.apply(legs, x)
        groups.append((legs, x.shape[1]))
    return groups


def _prediction_changes(
    model: TrajectoryModel, recording: Recording, legs: Sequence[tuple[LegLanes, int]], values: Array, local: Local
) -> Array:
    """(m, n, c) rad, change of one trial's prediction per unit of each parameter's logarithm."""
    layout, found = model.chain.layout, []
    for group, count in legs:
        lanes = model.chain.lanes(group, recording.conditions)
        repeated = np.repeat(values[:, None], count, axis=1)
        state = np.repeat(np.concatenate([local.rotation, local.rate])[:, None], count, axis=1)
        out = model.run_lanes(recording, lanes, repeated, state, local.shift[:, None], STEPS_FACTOR * model.max_steps)
        found.append((out[:, :, 1:] - out[:, :, :1]) / STEP)
    assert layout.n == len(local.rotation)
    return np.concatenate(found, axis=2)


def _of_points(
    model: TrajectoryModel, values: Array, numbers: Index, static: Sequence[StaticPoint], spread: Array | None
) -> Array:
    """(p, c) change of the static points' gradient per unit of each parameter's logarithm."""
    unknowns = model.unknowns
    assert isinstance(unknowns, SpringsAndDampers)

    def gradient(points: tuple[Balance, ...]) -> Array:
        measured = replace(unknowns, balances=points).measured(values, spread)
        assert measured is not None
        return measured[1]

    return _by_links(model.leg, numbers, static, gradient)


def residuals_by_links(
    leg: Leg,
    widths: Array,
    static: Sequence[StaticPoint],
    log_rate: Array,
    rest: Array,
    spread: Array | None = None,
) -> Array:
    """(m, c) change of the static points' residuals per deviation of each uncertain parameter, the unknowns held.

    ``widths`` as in ``link_errors``; ``log_rate`` and ``rest`` (n,) of the springs; ``spread`` as in
    ``gradient_by_links``.
    """
    open_ = np.flatnonzero(widths.ravel() > 0.0)

    def residuals(points: tuple[Balance, ...]) -> Array:
        return np.array([p.residual(log_rate[p.joint], rest[p.joint], spread_at(spread, p.joint)) for p in points])

    return _by_links(leg, open_, static, residuals) * widths.ravel()[open_]


def _by_links(
    leg: Leg, numbers: Index, static: Sequence[StaticPoint], value: Callable[[tuple[Balance, ...]], Array]
) -> Array:
    """(m, c) change of a ``value`` (m,) of the static points' balances per unit of each parameter's logarithm."""
    unit = Tolerances(np.ones((len(QUANTITIES), len(leg.joints))))
    columns = []
    for number in numbers:
        ends = []
        for step in (STEP, -STEP):
            x = np.zeros(unit.size)
            x[number] = step
            ends.append(value(balances(unit.leg(leg, x), static)))
        columns.append((ends[0] - ends[1]) / (2 * STEP))
    return np.stack(columns, axis=1)
