"""Table 8: the built leg's springs and dampers, one joint after the other from releases of that joint alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.files.project_options import RatePrior
from synth.files.static_points_file import StaticPoint
from synth.files.trial_list import read_trials
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult, JointFit
from synth.fit.recordings import Recording, recordings
from synth.fit.starts import starts
from synth.swing.leg_model import Damper, Leg, Spring
from synth.validation.comparison_table import ComparisonRow, ComparisonTable, cell, listed, percent
from synth.validation.explanations import inside, on_bounds, softened
from synth.validation.ridge_scan import along
from synth.validation.thesis_data import JOINTS, LabData

USED = 4  # of the releases a joint, the first, took part in the thesis
WIRE_THEORY = 38.0  # N m/rad, what the thesis reckoned for the hip's spring
STICKS = np.radians(3.0)  # how far from balance a joint may come to rest
HELD = RatePrior(spring=1e-3, damper=1e-3, free_angle=np.radians(3.0))  # of what is known already
HELD_AT = (15.0, 38.0, 75.8, 150.0)  # N m/rad at which the hip's spring is held to show the ridge


@dataclass(frozen=True)
class Isolated:
    """One joint's result, with the ones outward of it as found before."""

    joint: str
    fit: FitResult
    recordings: tuple[Recording, ...]

    @property
    def found(self) -> JointFit:
        """The joint's own estimates."""
        return self.fit.joints[self.joint]


def table_8(data: LabData) -> ComparisonTable:
    """Spring and damper rates of the built leg, joint by joint."""
    published = data.rates("thesis_table_8_built")
    bounds = data.published["thesis_table_8_built"]
    lower, upper = (
        np.array([[pair[end] for pair in bounds[key]] for key in ("bounds_k", "bounds_b")]) for end in (0, 1)
    )
    found = isolated(data)
    together = fit_leg(data.built, _all(data), LegFitOptions(free_angle="per_trial", tolerance=data.tolerance))
    rows = []
    for row, (symbol, unit) in enumerate((("k", "N*m/rad"), ("b", "N*m*s/rad"))):
        for j, name in enumerate(JOINTS):
            fits = (found[name].found, together.joints[name])
            estimates = [joint.spring_rate if row == 0 else joint.damper_rate for joint in fits]
            ends = f"{lower[row, j]:.4g} to {upper[row, j]:.4g}"
            rows.append(
                ComparisonRow(f"{name} {symbol}", (cell(published[row, j], unit), ends, *(cell(e) for e in estimates)))
            )
    said = [
        *on_bounds(published, lower, upper, "the published pair"),
        *_outside(found, lower, upper),
        *_by_joint(published, found),
        *_ridge(found["hip"]),
        _spread(found),
    ]
    return ComparisonTable(
        "Table 8",
        "The built robot leg: springs and dampers identified joint by joint",
        ("", "published", "its bounds", "ours, joint by joint", "ours, all releases at once"),
        tuple(rows),
        f"Ankle first (hip and knee held), then the knee with the ankle's values in, then the hip with both: the first "
        f"{USED} releases a joint, as in the thesis. Least squares without bounds that bite; initial states "
        "estimated; a release's end is a pose in which spring and weight balance within 3 deg.",
        tuple(said),
    )


def isolated(data: LabData) -> dict[str, Isolated]:
    """Ankle, knee, hip: each joint from its own releases, those found before held by sharp priors."""
    known, results = data.built, {}
    for joint in reversed(JOINTS):
        leg, recordings = _outward(data, joint, range(1, USED + 1))
        # The joint itself is sought freely; those outward of it have their values in the leg, which the prior holds.
        held = replace(leg, joints=tuple(known.joints[len(JOINTS) - len(leg.joints) :]))
        held = held.with_joints(**{joint: {"spring": None, "damper": None}})
        prior = HELD if len(leg.joints) > 1 else None
        options = LegFitOptions(
            free_angle="per_trial", prior=prior, static=_ends(leg, recordings), tolerance=data.tolerance
        )
        fit = fit_leg(held, recordings, options)
        results[joint] = Isolated(joint, fit, tuple(recordings))
        known = _with(known, joint, fit.joints[joint])
    return results


def _outward(data: LabData, joint: str, numbers: Sequence[int]) -> tuple[Leg, list[Recording]]:
    """The leg from a joint outwards, and that joint's releases as its own: what is held inward of it is a tilt."""
    first = JOINTS.index(joint)
    entries = [f"dog/joint_tests/{joint}_{i}.csv" for i in numbers]
    trials = []
    for trial in read_trials(entries, data.folder, data.built):
        held = np.nanmedian(data.built.to_rotation(trial.angles)[:, :first], axis=0)
        trials.append(replace(trial, angles=trial.angles[:, first:], tilt=float(held.sum())))
    leg = replace(data.built, joints=data.built.joints[first:])
    return leg, recordings(leg, trials)


def _ends(leg: Leg, recordings: Sequence[Recording]) -> tuple[StaticPoint, ...]:
    """The poses in which the releases end, as static points: there spring and weight balance, but for what sticks.

    The thesis takes its free angles from them. Without them a spring of hardly any rate, free far away, follows the
    releases as well.
    """
    points = []
    for recording, start in zip(recordings, starts(recordings), strict=True):
        pose = leg.to_measured(start.end)
        nothing = np.zeros(len(pose))
        tilt = recording.conditions.tilt
        points.append(StaticPoint(recording.name, pose, nothing, (0,), tilt=tilt, angle_error=STICKS))
    return tuple(points)


def _with(leg: Leg, joint: str, found: JointFit) -> Leg:
    assert found.damper_rate is not None
    parts = {
        "spring": Spring(found.spring_rate.value, found.free_angle.value),
        "damper": Damper(found.damper_rate.value),
    }
    return leg.with_joints(**{joint: parts})


def _all(data: LabData) -> list[Recording]:
    """The releases of all joints, as of the whole leg."""
    numbers = range(1, USED + 1)
    entries = [
        {"file": f"dog/joint_tests/{joint}_{i}.csv", "locked": list(JOINTS[:first])}
        for first, joint in enumerate(JOINTS)
        for i in numbers
    ]
    return data.trials(data.built, entries)


def _outside(found: Mapping[str, Isolated], lower: Array, upper: Array) -> list[str]:
    """Bounds that shut out what the data, or the spring's own theory, say."""
    said = []
    for j, name in enumerate(JOINTS):
        joint, soft = found[name].found, softened(found[name].fit, name)
        assert joint.damper_rate is not None
        if soft is not None:
            said.append(soft)
            continue
        for row, (symbol, estimate) in enumerate((("k", joint.spring_rate), ("b", joint.damper_rate))):
            if not lower[row, j] <= estimate.value <= upper[row, j]:
                said.append(
                    f"{name}: our {symbol}, {estimate.value:.3g}, lies outside what the thesis' search was allowed "
                    f"({lower[row, j]:.3g} to {upper[row, j]:.3g}): it could not have come out there."
                )
    if lower[0, 0] > WIRE_THEORY:
        said.append(
            f"hip: the spring's theoretical {WIRE_THEORY:.0f} N*m/rad lies below the search's lower bound of "
            f'{lower[0, 0]:.1f}: "twice the theory" is the bound and not the spring.'
        )
    return said


def _by_joint(published: Array, found: Mapping[str, Isolated]) -> list[str]:
    said = []
    for j, name in enumerate(JOINTS):
        item = found[name]
        joint = item.found
        assert joint.damper_rate is not None
        rates = joint.spring_rate.value, joint.damper_rate.value
        quotients = rates[1] / rates[0], published[1, j] / published[0, j]
        both = inside(joint.spring_rate, published[0, j]), inside(joint.damper_rate, published[1, j])
        words = [f"{s} {'inside' if held else 'outside'}" for s, held in zip("kb", both, strict=True)]
        where = f" ({listed(words)} our 90 % intervals)" if softened(item.fit, name) is None else ""
        said.append(
            f"{name}: k {percent(rates[0] / published[0, j])}, b {percent(rates[1] / published[1, j])} against the "
            f"published{where}; b/k {quotients[0]:.3g} s against {quotients[1]:.3g} s. Our fit leaves "
            f"{np.degrees(item.fit.rms[name]):.2f} deg."
        )
    return said


def _ridge(hip: Isolated) -> list[str]:
    """How little the residual cares for the hip's k once b may follow."""
    found = along(hip.fit, hip.recordings, "hip", HELD_AT)
    left = ", ".join(f"{np.degrees(item.rms):.2f}" for item in found)
    quotients = ", ".join(f"{item.damper_rate / item.spring_rate:.3g}" for item in found)
    return [
        f"hip: with k held at {', '.join(f'{rate:g}' for rate in HELD_AT)} N*m/rad and all else fitted again, {left} "
        f"deg are left, at b/k of {quotients} s: the releases fix b/k and hardly k, and a published k is as good as "
        "the bounds it was sought in. A static torque-angle point at the hip would fix it."
    ]


def _spread(found: Mapping[str, Isolated]) -> str:
    spreads = [
        f"{name} {np.degrees(found[name].found.free_angle_spread.value):.1f} deg" for name in ("hip", "knee", "ankle")
    ]
    return (
        f"From release to release the free angles move ({', '.join(spreads)}, standard deviation): the joints stick. "
        "Dry friction and a damper's torque that is not in proportion to speed are in neither model; what they do goes "
        "into k and b, differently for each cost."
    )
