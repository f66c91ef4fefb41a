"""Table 8: springs and dampers of the built leg, identified joint by joint from releases of one joint each."""

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
from synth.validation.comparison_table import ComparisonRow, ComparisonTable, listed, percent, table_cell
from synth.validation.explanations import bound_sentences, ridge_sentence
from synth.validation.open_rates import RANGES, among, family_of, family_sentence, inside_words, shown_rates
from synth.validation.thesis_data import JOINTS, LabData

USED = 4  # releases per joint that the thesis used: the first ones
WIRE_THEORY = 38.0  # N m/rad, rate of the hip's spring as calculated in the thesis
STICKING_ANGLE = np.radians(
    3.0
)  # largest angle between static equilibrium and the pose in which a sticking joint stops
HELD_PRIOR = RatePrior(spring=1e-3, damper=1e-3, free_angle=np.radians(3.0))  # sharp prior on joints identified before


@dataclass(frozen=True)
class IsolatedFit:
    """The fit of one joint, with the joints outboard of it as identified before."""

    joint: str
    fit: FitResult

    @property
    def found(self) -> JointFit:
        """The joint's own estimates."""
        return self.fit.joints[self.joint]


def table_8(data: LabData) -> ComparisonTable:
    """Spring and damper rates of the built leg, identified joint by joint and all at once."""
    published = data.rates("thesis_table_8_built")
    bounds = data.published["thesis_table_8_built"]
    lower, upper = (
        np.array([[pair[end] for pair in bounds[key]] for key in ("bounds_k", "bounds_b")]) for end in (0, 1)
    )
    found = fit_isolated_joints(data)
    together = fit_leg(
        data.built, _whole_leg_recordings(data), LegFitOptions(free_angle="per_trial", tolerance=data.tolerance)
    )
    rows = []
    for row, (symbol, unit) in enumerate((("k", "N*m/rad"), ("b", "N*m*s/rad"))):
        for j, name in enumerate(JOINTS):
            estimates = [shown_rates(fit, name)[row] for fit in (found[name].fit, together)]
            ends = f"{lower[row, j]:.4g} to {upper[row, j]:.4g}"
            rows.append(
                ComparisonRow(
                    f"{name} {symbol}", (table_cell(published[row, j], unit), ends, *(table_cell(e) for e in estimates))
                )
            )
    messages = [
        *bound_sentences(published, lower, upper, "the published pair"),
        *_bound_sentences(found, lower, upper),
        *_theory_sentences(found["hip"], float(lower[0, 0]), float(published[0, 0])),
        *_joint_sentences(published, found),
        *_open_sentences(published, found),
        _free_angle_sentence(found),
    ]
    return ComparisonTable(
        "Table 8",
        "The built robot leg: springs and dampers identified joint by joint",
        ("", "published", "its bounds", "ours, joint by joint", "ours, all releases at once"),
        tuple(rows),
        f"First the ankle (hip and knee held), then the knee with the ankle's values fixed, then the hip with both "
        f"fixed; the first {USED} releases of each joint, as in the thesis. Least squares; no bound is active. Initial "
        f"states are estimated. At the end of a release, spring and weight balance within "
        f"{np.degrees(STICKING_ANGLE):.0f} deg. {RANGES}",
        tuple(messages),
    )


def fit_isolated_joints(data: LabData) -> dict[str, IsolatedFit]:
    """Fits of ankle, knee and hip, in this order; sharp priors hold the joints identified before."""
    known, results = data.built, {}
    for joint in reversed(JOINTS):
        leg, recordings = _outboard_leg(data, joint, range(1, USED + 1))
        # The joint itself has no prior; the prior holds the joints outboard of it at their values in the leg.
        held = replace(leg, joints=tuple(known.joints[len(JOINTS) - len(leg.joints) :]))
        held = held.with_joints(**{joint: {"spring": None, "damper": None}})
        prior = HELD_PRIOR if len(leg.joints) > 1 else None
        options = LegFitOptions(
            free_angle="per_trial", prior=prior, static=_final_poses(leg, recordings), tolerance=data.tolerance
        )
        fit = fit_leg(held, recordings, options)
        results[joint] = IsolatedFit(joint, fit)
        known = _with_joint_as_found(known, joint, fit.joints[joint])
    return results


def _outboard_leg(data: LabData, joint: str, numbers: Sequence[int]) -> tuple[Leg, list[Recording]]:
    """The part of the leg from a joint outwards, and that joint's releases; held inboard links become a tilt."""
    first = JOINTS.index(joint)
    entries = [f"dog/joint_tests/{joint}_{i}.csv" for i in numbers]
    trials = []
    for trial in read_trials(entries, data.folder, data.built):
        held = np.nanmedian(data.built.to_rotation(trial.angles)[:, :first], axis=0)
        trials.append(replace(trial, angles=trial.angles[:, first:], tilt=float(held.sum())))
    leg = replace(data.built, joints=data.built.joints[first:])
    return leg, recordings(leg, trials)


def _final_poses(leg: Leg, recordings: Sequence[Recording]) -> tuple[StaticPoint, ...]:
    """The final poses of the releases as static points: spring and weight balance there, within ``STICKING_ANGLE``.

    The thesis also derives its free angles from them. Without them a very soft spring with a distant free angle fits
    the releases equally well. Each release has its own free angle, in its final pose too.
    """
    points = []
    for recording, start in zip(recordings, starts(recordings), strict=True):
        pose = leg.to_measured(start.end)
        nothing = np.zeros(len(pose))
        tilt = recording.conditions.tilt
        points.append(
            StaticPoint(
                recording.name, pose, nothing, (0,), tilt=tilt, angle_error=STICKING_ANGLE, session=recording.name
            )
        )
    return tuple(points)


def _with_joint_as_found(leg: Leg, joint: str, found: JointFit) -> Leg:
    assert found.damper_rate is not None
    parts = {
        "spring": Spring(found.spring_rate.value, found.free_angle.value),
        "damper": Damper(found.damper_rate.value),
    }
    return leg.with_joints(**{joint: parts})


def _whole_leg_recordings(data: LabData) -> list[Recording]:
    """The releases of all joints as recordings of the whole leg."""
    numbers = range(1, USED + 1)
    entries = [
        {"file": f"dog/joint_tests/{joint}_{i}.csv", "locked": list(JOINTS[:first])}
        for first, joint in enumerate(JOINTS)
        for i in numbers
    ]
    return data.trials(data.built, entries)


def _bound_sentences(found: Mapping[str, IsolatedFit], lower: Array, upper: Array) -> list[str]:
    """Sentences on bounds of the thesis that exclude our estimate, with all that fits about equally well."""
    messages = []
    for j, name in enumerate(JOINTS):
        fit = found[name].fit
        soft, several = ridge_sentence(fit, name), family_of(fit, name) is not None
        messages += [] if soft is None else [soft]
        for row, (symbol, shown) in enumerate(zip("kb", shown_rates(fit, name), strict=True)):
            low, high = lower[row, j], upper[row, j]
            ends = (shown.low, shown.high) if several else (shown.value, shown.value)
            if None in ends or (ends[0] <= high and ends[1] >= low):
                continue
            messages.append(
                f"{name}: our {symbol}, {shown.value:.3g}, lies outside the bounds of the thesis' search "
                f"({low:.3g} to {high:.3g}), which could not find it."
            )
    return messages


def _theory_sentences(hip: IsolatedFit, bound: float, published: float) -> list[str]:
    """On the theoretical rate of the hip's spring, N m/rad, if it lies below the lower ``bound`` of the search."""
    if bound <= WIRE_THEORY:
        return []
    family = family_of(hip.fit, "hip")
    text = (
        f"hip: the spring's theoretical {WIRE_THEORY:.0f} N*m/rad lies below the lower bound of the search, "
        f"{bound:.1f}, which could not find it."
    )
    if family is not None and among(family, WIRE_THEORY) and among(family, published):
        text += (
            " Each with a damper of its own, this spring and the published one fit the releases about equally well: "
            'they do not show "twice the theory".'
        )
    return [text]


def _joint_sentences(published: Array, found: Mapping[str, IsolatedFit]) -> list[str]:
    messages = []
    for j, name in enumerate(JOINTS):
        item = found[name]
        joint = item.found
        assert joint.damper_rate is not None
        rates = joint.spring_rate.value, joint.damper_rate.value
        quotients = rates[1] / rates[0], published[1, j] / published[0, j]
        messages.append(
            f"{name}: k {percent(rates[0] / published[0, j])}, b {percent(rates[1] / published[1, j])} against the "
            f"published values ({inside_words(item.fit, name, published[:, j])}); b/k {quotients[0]:.3g} s against "
            f"{quotients[1]:.3g} s. The RMS residual of our fit is {np.degrees(item.fit.rms[name]):.2f} deg."
        )
    return messages


def _open_sentences(published: Array, found: Mapping[str, IsolatedFit]) -> list[str]:
    """What fits the joints whose releases leave k and b open, and what would determine their k."""
    sentences = {name: family_sentence(found[name].fit, name, published[:, j]) for j, name in enumerate(JOINTS)}
    known = {name: text for name, text in sentences.items() if text is not None}
    if not known:
        return []
    return [
        *known.values(),
        f"No known torque acts in the final poses, so they do not tell k of {listed(list(known))}; a pose held by a "
        f"known torque, turned by far more than the {np.degrees(STICKING_ANGLE):.0f} deg within which a joint sticks, "
        "would.",
    ]


def _free_angle_sentence(found: Mapping[str, IsolatedFit]) -> str:
    spreads = [
        f"{name} {np.degrees(found[name].found.free_angle_spread.value):.1f} deg" for name in ("hip", "knee", "ankle")
    ]
    return (
        f"The free angles vary from release to release ({', '.join(spreads)}, standard deviation): the joints stick. "
        "Neither model includes dry friction or a damper torque that is not proportional to speed; both bias k and b, "
        "and the bias depends on the cost."
    )
