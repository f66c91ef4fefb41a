"""The beginning of free motion: after the release an external torque may still act for a while.

Each recording is tested by itself: a torque that no spring and damper of the leg produces (``motion.release``, as in
``synth import``). And all together: for free motion, all samples and only the later ones give the same rates; if the
two differ by more than their covariances allow, an external torque acts at the start (Hausman, Econometrica 46 (1978)
1251: the estimate from all samples is efficient, so the covariance of the difference is the difference of the
covariances). Where the later samples hardly determine the rates, as those of an overdamped leg, this tells nothing; but
then the first samples lie off the fit to all by more than the later ones scatter (``early_misfit``). Both tests allow
for the errors of the leg file's links, which move the two estimates, and bend the motion, differently.

A leg with another law (friction, a damper's curve, a link that bends) makes the same difference, and later samples fit
it no better until it rests. Where no start while it still moves agrees with later samples, nothing is cut: the
intervals then include the difference.

Noise that lasts makes it too: a trial's own unknowns take up most of it in the later samples (``lasting_noise``). Where
that explains the difference, a hand and noise are not told apart, and nothing is cut either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.estimation.f_distribution import square_above
from synth.estimation.intervals import spectrum
from synth.fit.diverged_fit import divergence_refused
from synth.fit.early_misfit import LaterScatter
from synth.fit.filtered_readings import likely_filter
from synth.fit.fit_options import LegFitOptions
from synth.fit.lasting_noise import taken_up
from synth.fit.later_samples import LEAST_COMPARED, ResidualFreedom, comparison_begin, recordings_from
from synth.fit.least_squares import FitStart, Solution, Stage, solve
from synth.fit.link_errors import LinkErrors, link_errors, link_widths
from synth.fit.model_error import ModelError
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.starts import first_locals
from synth.fit.still_start import release_in
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import covariance
from synth.motion.release import free_after
from synth.swing.leg_model import Leg

ACCEPTED_SHARE = 0.5  # of the recordings: external torque detected in so many is accepted without a further test
# Times are in the recordings' unit, 1 s for limbs.
# s, tried in order until the rest agrees with later samples. ``COMPARISON_START`` is not among them: the comparison fit
# agrees with itself whatever the leg's law is, and a leg with another law would be cut there.
CUTS = (0.1, 0.15, 0.2)
SIGNIFICANCE = 1e-4  # of the difference; a wrong model causes a difference too, so only a clear one counts
# s added to the first cut that agrees: a torque that has faded below the significance still biases the fit. The size is
# a choice; ``make laws`` shows the bias that is left of a hand.
FADE_TIME = 0.05
SHORT_TIME = 0.02  # s, below which whole milliseconds are too coarse in a sentence
LEAST_VARIANCE_LOST = 0.05  # share of a direction's variance that later samples must lose for the test to use it


@dataclass(frozen=True)
class DetectedDrive:
    """End of the external torque, s from each recording's first sample; None if none is detected.

    ``unit`` : s, of the recordings.
    """

    until: tuple[float | None, ...]
    unit: float = 1.0

    @property
    def ends(self) -> list[float]:
        """Those of the recordings with one."""
        return [until for until in self.until if until is not None]

    @property
    def accepted(self) -> bool:
        """Whether so many recordings show one that it is accepted."""
        return len(self.ends) >= ACCEPTED_SHARE * len(self.until) and bool(self.ends)


def detect_drive(leg: Leg, recordings: Sequence[Recording]) -> DetectedDrive:
    """Each recording by itself, except those driven by a known torque."""
    return DetectedDrive(tuple(_drive_end(leg, recording) for recording in recordings), recordings[0].unit)


def _drive_end(leg: Leg, recording: Recording) -> float | None:
    found = release_in(leg, recording)
    if found is None or found.driven_until is None or found.free_from < found.driven_until:
        return None  # none, or indistinguishable from a leg with another law
    return found.free_from if found.free_from > recording.time[0] else None


def cut_of(drive: DetectedDrive) -> float:
    """The common cut of a series, s, from the external torques detected in some of them."""
    return free_after(drive.ends, drive.unit)


@dataclass(frozen=True)
class LateFreeMotion:
    """An external torque that no single recording shows: from ``cut`` s the samples agree with later ones.

    ``probability`` : of such a difference between all samples and later ones in free motion.
    """

    cut: float
    probability: float


@dataclass(frozen=True)
class Drift:
    """The first samples and the later ones fit different legs, whatever the start: another law, or a longer torque.

    ``probability`` as of ``LateFreeMotion``; ``moved`` (p,) change of the unknowns from all samples to the later ones,
    less what noise explains. ``longest`` : s, the last start that was tried; None if the recordings are too short.
    ``likely`` as of ``start_sentence``. ``of_noise`` : the probability if noise lasts as the later samples show; None
    if that does not explain the difference either, or was not asked.
    """

    probability: float
    moved: Array
    longest: float | None
    likely: str = ""
    of_noise: float | None = None

    @property
    def error(self) -> ModelError:
        """The whole change as one standard deviation, of all unknowns together."""
        if self.of_noise is not None:
            return ModelError(
                self.moved[:, None],
                f"release: the first samples and the later ones fit one leg if the noise lasts from sample to sample "
                f"(p = {self.of_noise:.1g}; by what their residuals show of it {self.probability:.1g}), else a torque "
                "acts at first. All samples are fitted; the intervals include the difference of the rates",
            )
        either = "the leg has another law (synth gap), or a torque acts"
        why = f"The recordings are too short to try a later start: {either} at first"
        if self.longest is not None:
            why = f"No later start mends it, so {either} for longer than {_ms(self.longest)}"
        why = f"{self.likely}. Else: {why}" if self.likely else why
        return ModelError(
            self.moved[:, None],
            f"release: the first samples and the later ones do not fit one leg: p = {self.probability:.1g} for free "
            f"motion of springs and linear dampers. {why}. All samples are fitted; the intervals include the "
            "difference of the rates",
        )


def hidden_drive(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    options: LegFitOptions,
    least: float = 0.0,
) -> LateFreeMotion | Drift | None:
    """Test whether all samples and later ones fit the same leg; None if they do, or if there are too few.

    Parameters
    ----------
    stage : the fit to all samples.
    options : of that fit; the links' tolerances are allowed for.
    least : s, the shortest cut considered.
    """
    test, solution, unit = _later_fit(model, recordings, stage, options), stage.solution, recordings[0].unit
    if test is None:
        return None
    first = test.agreement(recordings, solution, 0.0)
    if first >= SIGNIFICANCE:
        return None
    tried = None
    for start in sorted({max(cut * unit, least) for cut in CUTS}):
        some = recordings_from(recordings, start)
        if some is None or start >= test.begin:
            break
        tried = start
        if test.agreement(some, replace(solution, locals=tuple(_locals(some, solution))), start) >= SIGNIFICANCE:
            longer = start + FADE_TIME * unit
            return LateFreeMotion(start if recordings_from(recordings, longer) is None else longer, first)
    return Drift(first, _unexplained_change(model, solution, test.known.solution), tried, likely_filter(recordings))


def drift_of_noise(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions, probability: float
) -> Drift | None:
    """The difference that ``hidden_drive`` found, with its ``probability``, if noise that lasts explains it; else None.

    The misfit of another law looks like such noise too.
    """
    test = _later_fit(model, recordings, stage, options)
    if test is None:
        return None
    test = test.with_noise_that_lasts()
    found = test.agreement(recordings, stage.solution, 0.0)
    if found < SIGNIFICANCE:
        return None
    moved = _unexplained_change(model, stage.solution, test.known.solution)
    return Drift(probability, moved, None, of_noise=found)


def _later_fit(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions
) -> _LaterFit | None:
    """The fit to later samples, from that to all; None if there are too few, or the motion diverges."""
    begin = comparison_begin(recordings)
    reference = recordings_from(recordings, begin, LEAST_COMPARED)
    if reference is None:
        return None
    solution, weights = stage.solution, stage.weights
    begun = FitStart(solution.values, _locals(reference, solution))
    known = refine(model, reference, begun, options.weight, weights.spread, points=weights.points)
    left = ResidualFreedom.of(reference, weights.spread)
    if not np.isfinite(known.solution.cost) or not left.enough:
        return None
    scatter = LaterScatter.of(reference, known.solution.predictions, left)
    by_freedom = _enlarged(model, reference, known, left.enlarged)
    return _LaterFit(model, reference, by_freedom, scatter, begin, options) if by_freedom is not None else None


def _enlarged(model: TrajectoryModel, samples: Sequence[Recording], stage: Stage, factor: Array) -> Stage | None:
    """The stage with ``factor`` (n,) or (n_trial, n) on the variance of its noise; None if it diverges."""
    weights = replace(stage.weights, noise=stage.weights.noise * np.sqrt(factor))
    found = solve(model, samples, FitStart.at(stage.solution), weights, tolerance=0.01)
    return Stage(found, weights) if np.isfinite(found.cost) else None


def _unexplained_change(model: TrajectoryModel, all_: Solution, later_: Solution) -> Array:
    """(p,) from the unknowns of all samples to those of the later ones, less what noise explains."""
    moved = later_.values - all_.values
    # Of the difference, as in Hausman's test.
    noise = np.diag(covariance(model, later_)) - np.diag(covariance(model, all_))
    return np.asarray(np.sign(moved) * np.sqrt(np.maximum(moved**2 - np.maximum(noise, 0.0), 0.0)))


def _locals(recordings: Sequence[Recording], solution: Solution) -> list[Local]:
    """Starts at the recordings' own first samples, with the shifts of the fit."""
    pairs = zip(first_locals(recordings), solution.locals, strict=True)
    return [replace(own, shift=found.shift) for own, found in pairs]


@dataclass(frozen=True)
class _LaterFit:
    """The fit ``known`` to ``samples``, those from ``begin`` s, and their ``scatter`` about it; ``options`` of both."""

    model: TrajectoryModel
    samples: Sequence[Recording]
    known: Stage
    scatter: LaterScatter
    begin: float
    options: LegFitOptions

    def with_noise_that_lasts(self) -> _LaterFit:
        """With what the unknowns of each trial took up of the noise; the same where its residuals are no noise."""
        known = self.known
        share = taken_up(self.model, self.samples, known)
        found = _enlarged(self.model, self.samples, known, share)
        if found is None:
            return self
        scatter = replace(self.scatter, deviation=self.scatter.deviation * np.sqrt(share))
        return replace(self, known=found, scatter=scatter)

    def agreement(self, some: Sequence[Recording], start: Solution, cut: float) -> float:
        """The probability that ``some``, the samples from ``cut`` s, and the later ones belong to one leg."""
        weights = replace(self.known.weights, centre=None)
        here = solve(self.model, some, FitStart(start.values, start.locals), weights, tolerance=0.01)
        if not np.isfinite(here.cost):
            return 1.0
        early = self.begin - cut
        first = self.scatter.agreement(some, here.predictions, early)
        rates = self._rates(here)
        if min(first, rates) < SIGNIFICANCE:  # with exact links; their errors can only make it likelier
            found = self._errors(some, Stage(here, weights), early)
            if found is not None and self._errors_later is not None:
                apart = self._errors_later.considered.sensitivity - found.considered.sensitivity
                first = self.scatter.agreement(some, here.predictions, early, found.first)
                rates = self._rates(here, apart)
        return min(first, rates if rates >= SIGNIFICANCE else max(rates, self._likelihood(here)))

    def _errors(self, samples: Sequence[Recording], stage: Stage, until: float = 0.0) -> LinkErrors | None:
        """What the links' errors do to a fit, and to its predictions before ``until`` s; None if a motion diverges."""
        widths = link_widths(self.model.leg, self.options.tolerance, samples)
        found = link_errors(self.model, samples, stage, widths, self.options.static, until=until)
        return found if found is not None and np.isfinite(found.considered.sensitivity).all() else None

    @cached_property
    def _errors_later(self) -> LinkErrors | None:
        return self._errors(self.samples, self.known)

    def _rates(self, here: Solution, apart: Array | None = None) -> float:
        """Probability of so large a difference between the two sets of rates; ``apart`` as in ``same_leg``."""
        later_fit = self.known.solution
        both = covariance(self.model, here), covariance(self.model, later_fit)
        return same_leg(here.values, both[0], later_fit.values, both[1], apart, self.scatter.freedom)

    def _likelihood(self, here: Solution) -> float:
        """The probability that the later samples fit the rates ``here`` so much worse than their own.

        Covariances are those of a linearised model, which along a ridge holds near the estimate only: the rates of all
        samples may be improbable by them there, and fit the later samples as well as their own.
        """
        later_fit = self.known.solution
        begin = FitStart(here.values, later_fit.locals)
        weights = replace(self.known.weights, centre=None)
        held = solve(self.model, self.samples, begin, weights, tolerance=0.01, fixed=True)
        if not np.isfinite(held.cost):
            return 0.0
        return square_above(len(here.values), 2.0 * (held.cost - later_fit.cost), self.scatter.freedom)


def same_leg(
    values: Array,
    cov: Array,
    later_values: Array,
    later_cov: Array,
    apart: Array | None = None,
    freedom: float = np.inf,
) -> float:
    """Probability of so large a difference between an efficient estimate (p,) and one from part of the samples.

    Directions that the part determines as well as the whole are left out. ``apart`` (p, c): by how much more the part's
    estimate moves than the whole's, per standard deviation of each parameter that both were given and is not exact.
    ``freedom`` : degrees of the residuals from which the noise of both is estimated.
    """
    root = np.linalg.cholesky(later_cov + 1e-15 * np.eye(len(values)) * np.trace(later_cov))
    whitened = np.linalg.solve(root, np.linalg.solve(root, cov).T)
    with divergence_refused():
        share, vector = spectrum(0.5 * (whitened + whitened.T))
    off = vector.T @ np.linalg.solve(root, later_values - values)
    tells = 1.0 - share > LEAST_VARIANCE_LOST
    if not tells.any():
        return 1.0
    spread = np.diag(1.0 - share[tells])
    if apart is not None:
        moved = vector[:, tells].T @ np.linalg.solve(root, apart)
        spread += moved @ moved.T
    return square_above(int(tells.sum()), float(off[tells] @ np.linalg.solve(spread, off[tells])), freedom)


def _ms(time: float) -> str:
    """A time, s, in words."""
    return f"{1e3 * time:.0f} ms" if time >= SHORT_TIME else f"{1e3 * time:.2g} ms"


def start_sentence(drive: DetectedDrive, cut: float, hidden: LateFreeMotion | None, likely: str = "") -> str:
    """The finding and the action in a sentence; ``likely`` : another on the reason that the readings show."""
    if hidden is not None:
        few = f" (an external torque is detected in {len(drive.ends)} of {len(drive.until)})" if drive.ends else ""
        reason = f"{likely}; else an external torque acts" if likely else "An external torque is taken to act"
        return (
            f"release: the first samples and the later ones do not fit one leg{few}: p = {hidden.probability:.1g} for "
            f"free motion of springs and linear dampers. {reason} at first; only samples "
            f"from {_ms(cut)} after each recording's start are fitted. To fit all: release: recorded"
        )
    reason = f" {likely}; else a hand or a muscle acts." if likely else ""
    return (
        f"release: in {len(drive.ends)} of {len(drive.until)} recordings a torque acts at first that the leg's springs "
        f"and dampers do not produce.{reason} Only samples from {_ms(cut)} after each start are fitted. To fit "
        "all: release: recorded"
    )
