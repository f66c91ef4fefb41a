"""The torque-speed law of a damper, from drops of the leg with only that damper.

Four laws compete, each fitted to whole trajectories with every drop's initial state estimated, and compared on
left-out drops. A drop confounds angle and speed (it is fast where gravity pulls most), so only whole trajectories with
gravity in the model identify a law; between equally good laws the simpler one is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.fit.candidate_laws import LAWS, LINEAR_LAW, POWER, TABLE, CandidateLaw, LawUnknowns, SpeedRange
from synth.fit.fit_problem import without_springs
from synth.fit.least_squares import FitStart, Solution, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.starts import first_locals
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import clipped_rms, rms_as_recorded
from synth.remarks import remarks_json
from synth.swing.chain import compiled_chain
from synth.swing.leg_model import DamperCurve, Leg
from synth.swing.mechanics import coefficients, outboard_inertia, static_torque
from synth.units import quantity, significant

SIMPLER_LAW_SHARE = 0.25  # share by which the held-out RMS of a simpler law may be worse if drops scatter by as much
NOISE_ROUNDS = 2  # the noise of a single joint only sets the linear range of Huber's function
SAMPLES = 150  # of a drop that are used: more samples of one slow motion add nothing
INTEGRATION = 1e-5  # relative tolerance: a drop is slow and smooth
SPEED_FACTORS = (2.0, 4.0, 8.0, 16.0)  # times the fastest speed of the drops: points of a table's extension


@dataclass(frozen=True)
class LawFit:
    """One fitted law: parameters, RMS (rad) on fitted and on left-out drops."""

    law: CandidateLaw
    parameters: Mapping[str, Any]
    curve: DamperCurve
    rms_fitted: float
    rms_held_out: float
    squares_held_out: tuple[float, ...] = ()  # rad^2, a drop

    def as_json(self, joint: str, *, used: bool) -> dict[str, Any]:
        """One entry under ``laws``; its curve lies in ``dampers/JOINT_LAW.csv`` beside the result."""
        return {
            "law": self.law.name,
            "formula": self.law.formula,
            "parameters": dict(self.parameters),
            "rms_fitted": quantity(self.rms_fitted, "deg"),
            "rms_held_out": quantity(self.rms_held_out, "deg"),
            "used": used,
            "curve": f"dampers/{joint}_{self.law.name}.csv",
        }


@dataclass(frozen=True)
class DamperLaw:
    """All laws of one damper, and the selected one."""

    joint: str
    fits: tuple[LawFit, ...]
    used: LawFit
    speeds: SpeedRange
    trials: tuple[tuple[str, bool], ...]  # name, held out
    how_held_out: str
    warnings: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """The joint's entry under ``damper_laws``."""
        return {
            "speed_range": [quantity(self.speeds.low, "rad/s"), quantity(self.speeds.high, "rad/s")],
            "trials": [{"file": name, "held_out": out} for name, out in self.trials],
            "how_held_out": self.how_held_out,
            "laws": [fit.as_json(self.joint, used=fit is self.used) for fit in self.fits],
            **remarks_json(self.warnings),
        }


def find_damper_law(leg: Leg, joint: str, drops: Sequence[Recording], held_out: Sequence[Recording] = ()) -> DamperLaw:
    """Fit all laws to drops of a leg whose other joints are locked, and choose by left-out drops.

    Without ``held_out`` every second drop is held out, then the others, and the errors are combined.
    """
    index, alone = leg.joint_names.index(joint), without_springs(leg)
    drops, held_out = [r.thinned(SAMPLES) for r in drops], [r.thinned(SAMPLES) for r in held_out]
    both = [*drops, *held_out]
    speeds = _speed_range(both, index)
    fits = _fit_all(alone, index, drops, held_out, speeds)
    used = _simplest_as_good(fits)
    if used.law is TABLE:
        exponent = float(next(fit for fit in fits if fit.law is POWER).parameters["exponent"]["value"])
        fits[-1] = used = replace(used, curve=_drawn_on(used.curve, exponent))
    return DamperLaw(
        joint,
        tuple(fits),
        used,
        speeds,
        tuple((r.name, False) for r in drops) + tuple((r.name, True) for r in held_out),
        _how_held_out(len(drops), len(held_out)),
        tuple(_warnings(joint, fits, used, speeds, both, index, alone)),
    )


def _fit_all(
    leg: Leg, joint: int, drops: list[Recording], held_out: list[Recording], speeds: SpeedRange
) -> list[LawFit]:
    """Every law fitted to all drops, with its error on left-out ones, in the order of ``LAWS``."""
    chain = compiled_chain(len(leg.joints))
    folds = [(drops, held_out)] if held_out else _halves(drops)
    fits: list[LawFit] = []
    scale = _first_rate(leg, [*drops, *held_out], joint)
    for law in LAWS:
        power = next((fit.curve for fit in fits if fit.law is POWER), None)
        unknowns = LawUnknowns(chain, law, joint, speeds, scale, power)
        model = TrajectoryModel(chain, leg, unknowns, INTEGRATION)
        squares: list[float] = []
        values = unknowns.start
        for fitted, scored in folds:
            values = _fit(model, fitted, joint, values).values
            squares += _score(model, scored, values, joint)
        final = _fit(model, drops, joint, values, tolerance=0.1)
        if law is LINEAR_LAW:  # the first: from too low a rate, friction converges to zero and stays there
            scale = float(np.exp(final.values[0]))
        rms = float(rms_as_recorded(drops, final.predictions)[joint])
        held = float(np.sqrt(np.mean(squares)))
        curve = unknowns.curve(final.values)
        fits.append(LawFit(law, unknowns.natural(final.values), curve, rms, held, tuple(squares)))
    return fits


def _how_held_out(fitted: int, held_out: int) -> str:
    if held_out:
        return "the trials marked held_out"
    return "every second drop in turn" if fitted > 1 else "none: a single drop is fitted and scored"


def _drawn_on(curve: DamperCurve, exponent: float) -> DamperCurve:
    """A table continued beyond its last point with the power law's exponent, not with its last slope.

    The slope at the end of the data is the least certain; the continuation should at least resemble the damper.
    """
    end, torque = curve.speed[-1], curve.torque[-1]
    speed = curve.speed + tuple(end * factor for factor in SPEED_FACTORS)
    return DamperCurve(speed, curve.torque + tuple(torque * factor**exponent for factor in SPEED_FACTORS))


def _speed_range(drops: Sequence[Recording], joint: int) -> SpeedRange:
    speed = np.concatenate([np.abs(r.smoothed.rate[:, joint]) for r in drops])
    fastest = float(speed.max())
    moving = speed[speed > 0.02 * fastest]  # at rest before the drop and after it
    # Outer 2 % left out: single noisy rates.
    return SpeedRange(float(np.quantile(moving, 0.02)), float(np.quantile(moving, 0.98)), fastest)


def _first_rate(leg: Leg, drops: Sequence[Recording], joint: int) -> float:
    """A rate from the balance of gravity and damping of the moving joint: the median of their quotient."""
    ratios = []
    for recording in drops:
        found = coefficients(leg, recording.conditions.tip)
        angle, rate = recording.smoothed.angle, recording.smoothed.rate[:, joint]
        torque = -static_torque(found, angle, leg.tilt + recording.conditions.tilt)[:, joint]
        moving = np.abs(rate) > 0.1 * np.abs(rate).max()  # slower, the quotient is mostly noise
        ratios.append(torque[moving] / rate[moving])
    ratio = float(np.median(np.concatenate(ratios)))
    # 5 1/s in the recordings' unit of time: a limb's damper.
    return ratio if ratio > 0 else float(outboard_inertia(leg)[joint]) * 5.0 / drops[0].unit


def _halves(drops: list[Recording]) -> list[tuple[list[Recording], list[Recording]]]:
    even, odd = drops[::2], drops[1::2]
    return [(even, odd), (odd, even)] if odd else [(even, even)]


def _fit(
    model: TrajectoryModel, drops: Sequence[Recording], joint: int, values: Array, tolerance: float = 1.0
) -> Solution:
    """Fit one law to drops; the noise is updated from the residual for a few rounds."""
    locals_: Sequence[Local] = first_locals(drops)
    noise = np.radians(2.0)
    for _ in range(NOISE_ROUNDS):
        weights = Weights(np.full((len(drops), model.chain.layout.n), noise), np.zeros(model.chain.layout.n))
        solution = solve(model, drops, FitStart(values, locals_), weights, max_iterations=30, tolerance=tolerance)
        if not np.isfinite(solution.cost):
            break
        values, locals_ = solution.values, solution.locals
        found = float(clipped_rms(drops, solution.predictions)[joint]) + 1e-6
        done = abs(np.log(found / noise)) < 0.05  # 5 % of noise changes no estimate noticeably
        noise = found
        if done:
            break
    return solution


def _score(model: TrajectoryModel, drops: Sequence[Recording], values: Array, joint: int) -> list[float]:
    """Mean squared error (rad^2) of each drop with the law fixed and the initial state estimated."""
    n = model.chain.layout.n
    weights = Weights(np.full((len(drops), n), np.radians(1.0)), np.zeros(n))
    solution = solve(model, drops, FitStart(values, first_locals(drops)), weights, fixed=True, tolerance=1.0)
    rms = [rms_as_recorded([r], [p])[joint] for r, p in zip(drops, solution.predictions, strict=True)]
    return [float(value) ** 2 if np.isfinite(value) else np.pi**2 for value in rms]


def _simplest_as_good(fits: Sequence[LawFit]) -> LawFit:
    """The simplest law that left-out drops do not distinguish from the best one.

    One-standard-error rule (Hastie, Tibshirani & Friedman, *The Elements of Statistical Learning*, 2nd ed., section
    7.10) on the differences drop by drop, and never more than ``SIMPLER_LAW_SHARE`` worse. ``LAWS`` goes from simple to
    rich.
    """
    best = min(fits, key=lambda fit: fit.rms_held_out)
    for fit in fits:
        difference = np.array(fit.squares_held_out) - np.array(best.squares_held_out)
        error = float(np.std(difference, ddof=1)) / np.sqrt(len(difference)) if len(difference) > 1 else 0.0
        near = fit.rms_held_out <= best.rms_held_out * (1 + SIMPLER_LAW_SHARE)
        if fit is best or (near and float(difference.mean()) <= error):
            return fit
    return best


def _warnings(
    joint: str,
    fits: Sequence[LawFit],
    used: LawFit,
    speeds: SpeedRange,
    drops: Sequence[Recording],
    index: int,
    leg: Leg,
) -> list[str]:
    slow, fast = (significant(speed * 30 / np.pi, 2) for speed in (speeds.low, speeds.high))
    messages = [
        f"{joint}: the damper was measured between {speeds.low:.3g} and {speeds.high:.3g} rad/s "
        f"({slow} to {fast} rpm); beyond that its law is extrapolated"
    ]
    if len(drops) == 1:
        messages.append(f"{joint}: the damper's law was chosen from a single drop; a second one would test it")
    # A tenth: within the scatter of drops.
    alike = [f.law.name for f in fits if f is not used and f.rms_held_out <= used.rms_held_out * 1.1]
    if alike:
        messages.append(f"{joint}: these drops do not distinguish {used.law.name} from {' or '.join(alike)}")
    ends, creeps = [], []
    for recording in drops:
        found = coefficients(leg, recording.conditions.tip)
        time, angle = recording.smoothed.time, recording.smoothed.angle
        last = max(2, len(angle) // 20)  # the last twentieth
        end, before = angle[-last:].mean(axis=0), angle[-2 * last : -last].mean(axis=0)
        ends.append(abs(static_torque(found, end, leg.tilt + recording.conditions.tilt)[index]))
        # From means, because single rates are mostly noise when the leg stands still.
        creeps.append(abs(end - before)[index] / (last * (time[1] - time[0])))
    held = float(np.median(ends))
    # 0.02 N m: a choice, less is near equilibrium; a fifth of the slowest measured speed counts as standing.
    if held > 0.02 and float(np.median(creeps)) < 0.2 * speeds.low:
        messages.append(f"{joint}: the leg stops although gravity still exerts {significant(held, 2)} N*m: it sticks")
    return messages
