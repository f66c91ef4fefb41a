"""The release in a recording: the limb is at rest or held, is released, and swings to rest.

Motion is distinguished from rest by kinetic energy with the links' masses, so a trembling foot counts little
against a moving thigh. The release is the last transition from rest to motion, located between
samples by two-phase regression (Hinkley, *J. Am. Stat. Assoc.* 66 (1971) 736): a straight line before, to which a
parabola and a cubic are added after. External torques after that are the subject of ``foreign_torque``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask
from synth.motion.foreign_torque import drive_after
from synth.motion.hidden_turns import continues, gap_ends, turns
from synth.motion.local_fits import by_samples
from synth.motion.smoothing import Smoothed, lost_samples, odd_points, polynomial_noise, smooth
from synth.swing.leg_model import Leg
from synth.swing.mechanics import absolute, coefficients, mass_matrix

WIDTHS = (0.05, 0.08, 0.12, 0.18)  # s, supports of the local polynomials: the first with sufficiently low noise is used
MOVING_SHARE = 0.2  # of the greatest speed (root of twice the kinetic energy); less counts as rest
NOISE_FACTOR = 4.0  # times the noise's own speed; less counts as rest too
BURST = 0.3  # of the greatest speed, reached by a release at least
PAUSE = 0.06  # s; a shorter stop is ignored
LEAD = 0.12  # s before the motion, support of the straight line
LEFT_OVER = 0.3  # of the speed at the release that must remain, or the cut would remove the motion
LEAST_SAMPLES = 20  # samples: two local polynomials and the break between them
STRAY_RATIO = 1.3  # times the median of a series; a longer external torque is not believed
FADING = 0.03  # s, decay of an external torque after it is last detected
# Rise of the regression's -2 log likelihood at the ends of the release's 95 % interval (chi-squared, 1)
LIKELIHOOD_RISE = 3.84
BIAS = 1.5  # samples, early bias of the break because the motion is not a cubic: see ``released_by``
KINK = 20.0  # rise of the same without a break from which a hold is certain: p = 1e-5 of a smooth start


@dataclass(frozen=True)
class Release:
    """The result for one recording; times in s on the recording's clock.

    ``released`` : when the limb began to move from rest for the last time; None if it moves from the first
        sample, so that the recording starts at or after the release, or never moves.
    ``free_from`` : from here the leg's own springs and dampers explain the motion. ``released_by`` (or the first
        sample) if no external torque is detected, or too little motion would remain without it.
    ``driven_until`` : the end of an external torque; None if none is detected.
    ``sentence`` : all this in words.
    ``released_by`` : the late end of the 95 % interval of ``released``, after which no sample is held:
        it is after the true release in 97 % of 240 simulated ones (noise of 0.05 to 0.6 deg, 100 and 250 Hz).
    ``still_first`` : whether the recording clearly begins at rest or held, with a break where it begins to move. A
        swing that decays and grows again also has a ``released`` if its joints exchange energy.
    ``maybe_still_first`` : whether it probably does: at 95 %, which tells where others of a series clearly do.
    ``not_before`` : where no joint has a sample around the release, the last sample before that; ``released`` and
        ``released_by`` are then the first one after it. None where samples show the release.
    """

    released: float | None
    free_from: float
    driven_until: float | None
    sentence: str
    released_by: float | None = None
    still_first: bool = False
    maybe_still_first: bool = False
    not_before: float | None = None

    def in_seconds(self, unit: float) -> Release:
        """The same with times given in ``unit``, s."""

        def seconds(value: float | None) -> float | None:
            return None if value is None else value * unit

        return replace(
            self,
            released=seconds(self.released),
            free_from=self.free_from * unit,
            driven_until=seconds(self.driven_until),
            released_by=seconds(self.released_by),
            not_before=seconds(self.not_before),
        )


def find_release(
    time: Array,
    angles: Array,
    leg: Leg,
    *,
    locked: tuple[int, ...] = (),
    tip_mass: float = 0.0,
    unit: float = 1.0,
) -> Release:
    """The release of a recording that ends at rest or decaying, and the end of its driven beginning.

    Parameters
    ----------
    time : (n,) s, increasing.
    angles : (n, n_joint) rad, measured angles of ``leg``; nan where a sample is missing.
    leg : its links and joints' signs; springs and dampers are not used. Its tilt is the recording's.
    locked : indices of joints that were held all the time.
    tip_mass : kg, at the last link's end.
    unit : s, of the constants in seconds, see ``time_step``.

    Raises
    ------
    ValueError : fewer than 20 samples, or a joint with fewer than seven good ones.
    """
    if len(time) < LEAST_SAMPLES:
        raise ValueError(f"{len(time)} samples, at least {LEAST_SAMPLES} are needed to find a release")
    rotation = leg.to_rotation(angles)
    lost = lost_samples(time, rotation)
    if unit == 1.0:
        return _find_in_view(time, rotation, lost, _view(time, rotation, lost, leg, locked, tip_mass, unit))
    time, leg = time / unit, replace(leg, gravity=leg.gravity * unit**2)
    return _find_in_view(time, rotation, lost, _view(time, rotation, lost, leg, locked, tip_mass, unit)).in_seconds(
        unit
    )


def _find_in_view(time: Array, rotation: Array, lost: Mask, view: _View) -> Release:
    """The release, in the view's unit of time."""
    burst = _last_burst(time, rotation, lost, view)
    if burst is None:
        return Release(None, float(time[0]), None, "nothing moves above the noise")
    held = view.smoothed.time[burst[0]] - time[0] >= max(PAUSE, 5 * view.step)
    if not held:
        return _with_drive(None, time, rotation, lost, view)
    broken = _outside_gaps(time, rotation, view, _refine_break(time, rotation, lost, view, burst[0]))
    found = _with_drive(broken, time, rotation, lost, view)
    kink = _first_kink(time, rotation, lost, view, broken, burst[0])
    return replace(found, still_first=kink > KINK, maybe_still_first=kink > LIKELIHOOD_RISE)


def free_after(driven: Sequence[float], unit: float = 1.0) -> float:
    """Assumed duration of the external torque after the release of each recording of a series, s.

    ``driven`` : s after its release until which an external torque is detected, for each recording with one; at least
    one; ``unit`` s, of the recordings. An external torque in one recording of a series is likely in the others,
    detected or not, so the longest counts for all; one far longer than most is a false detection. Measured on 24
    random legs driven for 0.15 s (144 recordings, detected in 106): of the fits' 90 % intervals 45 % contain the truth
    when each recording is cut at its own detection, 90 % when all are cut at the longest plus its decay.
    """
    return min(max(driven), STRAY_RATIO * float(np.median(driven))) + FADING * unit


@dataclass(frozen=True)
class _View:
    """A smoothed recording and its speed (n,) kg^1/2 m/s, the root of twice the kinetic energy, with its noise."""

    leg: Leg
    locked: tuple[int, ...]
    tip_mass: float
    smoothed: Smoothed
    points: int
    speed: Array
    floor: float
    root: Array  # (n_joint, n_joint), a root of the mass matrix at the end, which makes rates comparable
    unit: float = 1.0  # s, of all times

    @property
    def step(self) -> float:
        return float(self.smoothed.time[1] - self.smoothed.time[0])

    def in_words(self, time: float) -> str:
        """A time in words, in seconds."""
        return f"{time * self.unit:.{3 if self.unit >= 1.0 else 5}f}"

    @property
    def threshold(self) -> float:
        return max(MOVING_SHARE * float(self.speed.max()), NOISE_FACTOR * self.floor)


def _view(
    time: Array, rotation: Array, lost: Mask, leg: Leg, locked: tuple[int, ...], tip_mass: float, unit: float
) -> _View:
    """The narrowest smoothing whose noise is well below the threshold of motion, or the widest."""
    coefficient = coefficients(leg, tip_mass)
    for width in WIDTHS:
        smoothed = _smooth_by_samples(time, rotation, lost, locked, width)
        step = float(smoothed.time[1] - smoothed.time[0])
        points = min(odd_points(width, step), len(smoothed.time) // 2 * 2 - 1)
        phi, omega = absolute(smoothed.angle, leg.tilt), np.cumsum(smoothed.rate, axis=1)
        between = phi[:, :, None] - phi[:, None, :]
        moving = coefficient.inertia * np.cos(between) + coefficient.inertia_across * np.sin(between)
        twice = np.einsum("tij,ti,tj->t", moving, omega, omega)
        twice += smoothed.rate**2 @ coefficient.armature
        mass = mass_matrix(coefficient, smoothed.angle[-1], leg.tilt)
        noise = smoothed.noise * polynomial_noise(points, 3, step)[1]
        noise[list(locked)] = 0.0
        floor = float(np.sqrt(np.diag(mass) @ noise**2))
        speed = np.sqrt(np.maximum(twice, 0.0))
        half = points // 2  # one-sided polynomials at the ends are several times as noisy
        speed[:half], speed[-half:] = speed[half], speed[-half - 1]
        root = np.asarray(np.linalg.cholesky(mass), dtype=np.float64)
        view = _View(leg, locked, tip_mass, smoothed, points, speed, floor, root, unit)
        if NOISE_FACTOR * floor < 0.5 * MOVING_SHARE * speed.max():
            break
    return view


def _smooth_by_samples(time: Array, rotation: Array, lost: Mask, locked: tuple[int, ...], width: float) -> Smoothed:
    smoothed = by_samples(smooth(time, rotation, lost, width), time, rotation, lost)
    for j in locked:
        smoothed.angle[:, j], smoothed.rate[:, j] = float(np.median(smoothed.angle[:, j])), 0.0
    return smoothed


def _last_burst(time: Array, rotation: Array, lost: Mask, view: _View) -> tuple[int, int] | None:
    """First and last index of the last stretch of motion that could be a release."""
    moving = np.flatnonzero(view.speed > view.threshold)
    if not len(moving):
        return None
    stops = [
        int(k)
        for k in np.flatnonzero(np.diff(moving) * view.step > PAUSE)
        if not _swings_on(time, rotation, lost, view, (int(moving[k]), int(moving[k + 1])))
    ]
    starts = moving[np.array([0, *(k + 1 for k in stops)])]
    ends = moving[np.array([*stops, len(moving) - 1])]
    greatest = float(view.speed.max())
    # Noise that exceeds the threshold for a moment is not a release.
    least = max(BURST * greatest, min(1.5 * view.threshold, greatest))
    for first, last in zip(starts[::-1], ends[::-1], strict=True):
        if view.speed[first : last + 1].max() >= least:
            return int(first), int(last)
    return None


def _swings_on(time: Array, rotation: Array, lost: Mask, view: _View, stop: tuple[int, int]) -> bool:
    """Whether a stop, from the last moving index to the next one, is the turning point of a swing, seen or hidden."""
    first, last = stop
    if turns(view.smoothed.rate[first : last + 1] @ view.root):
        return True
    hidden = gap_ends(view.smoothed.time, view.smoothed.gap, first, last)
    free = [j for j in range(rotation.shape[1]) if j not in view.locked]
    noise = view.smoothed.noise[free]
    return hidden is not None and continues(time, rotation[:, free], lost[:, free], hidden, noise)


@dataclass(frozen=True)
class _Break:
    """The beginning of motion, s: best estimate ``at``, and ``by`` the late end of the 95 % interval.

    ``kink`` : gain of a break over a smooth start at the window's first sample, in -2 log
    likelihood. ``after`` : the last sample before a gap of all joints that hides the break, else None.
    """

    at: float
    by: float
    kink: float
    after: float | None = None


def _refine_break(time: Array, rotation: Array, lost: Mask, view: _View, first: int) -> _Break:
    """The break of the two-phase regression, near the coarse start ``first``, to a fiftieth of its range."""
    step, speed = view.step, view.speed
    coarse = float(view.smoothed.time[first])
    falls = np.flatnonzero(np.diff(speed[first:]) < 0)
    peak = float(view.smoothed.time[first + int(falls[0])] if len(falls) else view.smoothed.time[-1])
    # In s: three terms describe 50 ms of a release, and 30 ms are the error of a coarse start.
    end = min(coarse + 0.05, max(peak, coarse + 3 * step))
    inside = (time >= coarse - LEAD - 1e-9) & (time <= end + 1e-9)
    earliest = max(coarse - max(0.03, 0.2 * (peak - coarse)), float(time[0]) + 2 * step)
    latest = min(coarse + 0.03, end - 2.5 * step)
    if latest <= earliest:
        return _Break(coarse, coarse + BIAS * step, 0.0)
    candidates = np.linspace(earliest, latest, 51)
    cost, smooth_start = np.zeros(len(candidates)), 0.0
    for j in range(rotation.shape[1]):
        good = inside & ~lost[:, j]
        if j in view.locked or good.sum() < 8:
            continue
        t, y = time[good], rotation[good, j]
        misfit = np.array([_two_phase_misfit(t - at, y) for at in candidates])
        # The misfit of the break counts as noise if larger, because the motion is not a cubic.
        variance = _hold_noise(t - coarse, y, float(view.smoothed.noise[j])) ** 2 + 1e-12
        variance = max(variance, float(misfit.min()) / max(1, len(t) - 5))
        cost += misfit / variance
        smooth_start += _two_phase_misfit(t - t[0], y) / variance
    best = int(np.argmin(cost))
    allowed = np.flatnonzero(cost <= cost[best] + LIKELIHOOD_RISE)
    return _Break(
        float(candidates[best]), float(candidates[allowed[-1]]) + BIAS * step, smooth_start - float(cost[best])
    )


def _outside_gaps(time: Array, rotation: Array, view: _View, found: _Break) -> _Break:
    """The break, or if its interval meets a gap of all joints, the first sample after that.

    The regression finds a break there too, from the slopes on both sides; any other moment of the gap fits as well. A
    single sample after the gap shows no hold.
    """
    free = [j for j in range(rotation.shape[1]) if j not in view.locked]
    known = time[np.isfinite(rotation[:, free]).any(axis=1)]  # an outlier still shows that the limb was seen
    wide = np.diff(known) > max(PAUSE, 5 * view.step)
    begins, ends, beyond = known[:-1][wide], known[1:][wide], np.r_[known[2:], np.inf][wide]
    for until in (ends, beyond):
        hiding = np.flatnonzero((begins < found.by) & (found.at < until))
        if len(hiding):
            end = float(ends[hiding[-1]])
            return replace(found, at=end, by=end, after=float(begins[hiding[-1]]))
    return found


def _first_kink(time: Array, rotation: Array, lost: Mask, view: _View, last: _Break, first_of_last: int) -> float:
    """``_Break.kink`` where the first motion begins after no motion for a while; 0 without such a rest."""
    first = int(np.flatnonzero(view.speed > view.threshold)[0])
    if view.smoothed.time[first] - time[0] < max(PAUSE, 5 * view.step):
        return 0.0
    begun = last if first == first_of_last else _refine_break(time, rotation, lost, view, first)
    return begun.kink


def _hold_noise(since: Array, angle: Array, noise: float) -> float:
    """The scatter about a line while held, rad, or the recording's noise where that is larger."""
    held = since < -0.03  # s, the error of a coarse start
    if held.sum() < 5:
        return noise
    line = np.stack([np.ones(int(held.sum())), since[held]], axis=1)
    residual = angle[held] - line @ np.linalg.lstsq(line, angle[held], rcond=None)[0]
    return max(noise, float(residual.std()))


def _two_phase_misfit(since: Array, angle: Array) -> float:
    """Sum of squares, rad^2, about a line to which a parabola and a cubic are added after the break."""
    after = np.maximum(since, 0.0)
    design = np.stack([np.ones(len(since)), since, after**2, after**3], axis=1)
    design /= np.abs(design).max(axis=0) + 1e-12
    residual = angle - design @ np.linalg.lstsq(design, angle, rcond=None)[0]
    return float(residual @ residual)


def _with_drive(begun: _Break | None, time: Array, rotation: Array, lost: Mask, view: _View) -> Release:
    """Search for an external torque after the release, and describe the result."""
    released, by, early = (None, None, None) if begun is None else (begun.at, begun.by, begun.after)
    start = float(time[0]) if released is None else released
    free_at = start if by is None else by
    reason = "it moves from the first sample"
    if begun is not None:
        reason = f"released at {view.in_words(begun.at)} s"
        reason += f" ({view.in_words(begun.by)} s at the latest)"
        if begun.after is not None:
            reason = f"released between {view.in_words(begun.after)} and {view.in_words(begun.at)} s (no samples)"
    after = time >= start
    free = [j for j in range(rotation.shape[1]) if j not in view.locked]
    drive = None
    width = (view.points - 1) * view.step
    if after.sum() >= 4 * view.points and min((~lost[after][:, j]).sum() for j in free) >= view.points:
        smoothed = _smooth_by_samples(time[after], rotation[after], lost[after], view.locked, width)
        points = min(odd_points(width, view.step), len(smoothed.time) // 2 * 2 - 1)
        drive = drive_after(view.leg, smoothed, points, free, view.tip_mass)
    if drive is None:
        reason += "; no external torque after that"
        return Release(released, start if by is None else by, None, reason, by, not_before=early)
    name = view.leg.joint_names[drive.joint]
    reason += f"; until {view.in_words(drive.until)} s a torque acts on the {name} that its spring and damper do not "
    reason += "produce "
    reason += f"(up to {drive.share:.0%} of its torque range)"
    grid = view.smoothed.time
    greatest = view.speed[grid >= start].max()
    if view.speed[grid >= drive.until].max() < LEFT_OVER * greatest:
        reason += (
            ", but by then the limb is almost at rest, so an external torque and another law of the leg look alike"
        )
        return Release(released, free_at, drive.until, reason, by, not_before=early)
    return Release(released, max(free_at, drive.until), drive.until, reason, by, not_before=early)
