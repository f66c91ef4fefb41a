"""Tables 3, 4 and A-1: springs and dampers with which the robot moves like the rat at half speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult, Variant
from synth.fit.rate_search import Bounds
from synth.fit.recordings import Recording
from synth.motion.characteristics import Characteristics
from synth.validation.comparison_table import Cell, ComparisonRow, ComparisonTable, table_cell
from synth.validation.explanations import bound_sentences, difference_sentences, found_rates
from synth.validation.held_free_angles import fit_with_angles_of_ends, free_angle_sentences
from synth.validation.open_rates import shown_rates
from synth.validation.thesis_data import JOINTS, SEVEN, LabData
from synth.validation.thesis_method import ALL_MISTAKES, ANKLE, HIP, KNEE, NO_MISTAKES, Mistakes, Terms, ThesisMethod

TIME_SCALE = 2.0  # time scale of the thesis
START_RATES = np.array([[21.356, 1.936, 0.432], [1.5, 0.08, 0.06]])  # its HandOPTD3_IC
UPPER_RATES = np.array(
    [[35.0, 4.0, 1.0], [3.0, 0.3, 0.2]]
)  # the thesis' search box: springs N m/rad, dampers N m s/rad
LOWER_RATES = np.array([[1.0, 0.1, 0.01], [0.01, 0.001, 0.001]])  # the thesis' search box
# Releases with five times the weight at a joint: those of the muscles that move it most.
STRESSED_RELEASES = {
    HIP: ("IP_5", "GS_1", "ST_1", "BFp_1"),
    KNEE: ("IP_5", "BFp_1", "ST_1", "ST2_1"),
    ANKLE: ("IP_5", "BFp_1", "ST_1"),
}
STRESS_WEIGHT = 5.0
Features = Sequence[Sequence[Characteristics]]  # by release and joint


@dataclass(frozen=True)
class RobotTarget:
    """Results for the robot: the thesis' method (``wrong``: with its mistakes), and least squares; rates are (2, 3)."""

    recordings: tuple[Recording, ...]
    method: ThesisMethod
    wrong: ThesisMethod
    swarm: Array
    with_mistakes: Array
    fit: FitResult
    common: Variant  # one free angle for all releases


def fit_target(data: LabData, seed: int = 0) -> RobotTarget:
    """Repeat the thesis' method on the releases at half speed, and fit them by least squares."""
    slow = [recording.stretched(TIME_SCALE) for recording in data.releases()]
    weights = np.array(
        [[STRESS_WEIGHT if name in STRESSED_RELEASES[j] else 1.0 for j in (HIP, KNEE, ANKLE)] for name in SEVEN]
    )
    terms = Terms(rise=200.0, ratio=50.0, frequency=1.0, squares=30.0, weights=weights)
    methods = [ThesisMethod(data.dog, slow, terms, mistakes, TIME_SCALE) for mistakes in (NO_MISTAKES, ALL_MISTAKES)]
    bounds = Bounds(LOWER_RATES, UPPER_RATES)
    swarms = [method.search.swarm(START_RATES, bounds, seed=seed)[0] for method in methods]
    fit = fit_leg(data.dog, slow, LegFitOptions(free_angle="per_trial", seed=seed, tolerance=data.tolerance))
    common = next(variant for variant in fit.variants if variant.free_angle == "common")
    return RobotTarget(tuple(slow), methods[0], methods[1], swarms[0], swarms[1], fit, common)


def table_3(data: LabData, target: RobotTarget) -> ComparisonTable:
    """Spring and damper rates of the robot's joints."""
    published = data.rates("thesis_table_3_target")
    rows = []
    for row, (symbol, unit) in enumerate((("k", "N*m/rad"), ("b", "N*m*s/rad"))):
        for j, name in enumerate(JOINTS):
            common = target.common.spring_rate if row == 0 else target.common.damper_rate
            found = [shown_rates(target.fit, name)[row], common[name]]
            numbers = [published[row, j], target.swarm[row, j], target.with_mistakes[row, j]]
            rows.append(
                ComparisonRow(
                    f"{name} {symbol}", (*(table_cell(v, unit) for v in numbers), *(table_cell(e) for e in found))
                )
            )
    costs = [target.method.total(rates) for rates in (published, target.swarm)]
    best = found_rates(target.fit)
    messages = [
        f"The thesis' cost, without its mistakes, is {costs[0]:.0f} for the published rates and {costs[1]:.0f} for "
        "those of our swarm with the same start and bounds: "
        + ("the published search missed the minimum." if costs[1] < costs[0] else "the published rates are better."),
        *bound_sentences(target.swarm, LOWER_RATES, UPPER_RATES, "our swarm"),
        *bound_sentences(target.with_mistakes, LOWER_RATES, UPPER_RATES, "our swarm with the mistakes"),
        *difference_sentences(published, target.fit, target.method.rms(published), target.method.rms(best)),
        *free_angle_sentences(
            published,
            target.fit,
            fit_with_angles_of_ends(data.dog, target.recordings, target.fit),
            target.swarm,
            target.with_mistakes,
        ),
        *_initial_rate_sentences(target, published),
    ]
    return ComparisonTable(
        "Table 3",
        "The robot leg: spring and damper rates wanted",
        ("", "published", "swarm, ours", "swarm, ours with the mistakes", "least squares, a free angle per release",
         "least squares, one free angle"),
        tuple(rows),
        "The seven releases at half speed on the robot's links, with the thesis' start values, bounds, weights and "
        "cost, 20 particles and 100 iterations. Least squares as in Table 1.",
        tuple(messages),
    )  # fmt: skip


def _initial_rate_sentences(target: RobotTarget, published: Array) -> list[str]:
    """The effect of the doubled initial rates."""
    doubled = ThesisMethod(
        target.fit.leg, target.recordings, target.method.cost.terms, Mistakes(double_rate=True), stretched=TIME_SCALE
    )
    here, there = (np.degrees(method.rms(published)) for method in (target.method, doubled))
    return [
        f"At half speed the thesis keeps the initial velocities of the fast motion: with its springs and dampers the "
        f"RMS errors of hip, knee and ankle are then {there[0]:.2f}, {there[1]:.2f} and {there[2]:.2f} deg, with the "
        f"right initial velocities {here[0]:.2f}, {here[1]:.2f} and {here[2]:.2f} deg."
    ]


def table_4(data: LabData, target: RobotTarget) -> ComparisonTable:
    """Free angles of the robot's springs."""
    published = data.published["thesis_table_4_free_angle_deg"]
    rates = data.rates("thesis_table_3_target")
    leg = target.fit.leg
    found = [
        leg.to_measured(np.median(method.search.rests(rates[0][:, None])[:, :, 0], axis=0))
        for method in (target.method, target.wrong)
    ]
    spreads = np.std(target.method.search.rests(rates[0][:, None])[:, :, 0], axis=0, ddof=1)
    rows = tuple(
        ComparisonRow(
            name,
            (
                table_cell(float(np.radians(published[j])), "deg"),
                table_cell(float(found[0][j]), "deg"),
                table_cell(float(found[1][j]), "deg"),
                table_cell(target.fit.joints[name].free_angle),
                table_cell(target.fit.joints[name].free_angle_spread),
            ),
        )
        for j, name in enumerate(JOINTS)
    )
    messages = [
        f"{name}: {np.degrees(found[0][j]):.1f} deg from the published spring rate, "
        f"{np.degrees(found[1][j]):.1f} deg with the wrong sign of the foot's weight, {published[j]:.0f} deg "
        f"published. At the published rate it varies by {np.degrees(spreads[j]):.1f} deg (standard deviation) over "
        "releases; "
        + (
            "the difference is not larger."
            if abs(np.degrees(found[0][j]) - published[j]) <= np.degrees(spreads[j])
            else "the difference is larger and depends on which releases are averaged, and how."
        )
        for j, name in enumerate(JOINTS)
    ]
    return ComparisonTable(
        "Table 4",
        "The robot leg: free angles",
        ("", "published", "published rates, corrected", "published rates, foot's weight wrong", "least squares",
         "spread over releases, least squares"),
        rows,
        "The free angle with which spring and weight balance in the final pose of a release: median over the seven.",
        tuple(messages),
    )  # fmt: skip


def table_a1(data: LabData, target: RobotTarget) -> ComparisonTable:
    """Characteristics of each release: of the rat at half speed, and of the robot with the published rates."""
    published, rates = data.published["thesis_table_A1"], data.rates("thesis_table_3_target")
    given, reached = published["data"], published["achieved"]
    wanted = target.method.cost.data
    right, wrong = target.method.features(rates), target.wrong.features(rates)
    means = [method.mean_errors(rates)[:, ANKLE] for method in (target.method, target.wrong)]
    rows: list[ComparisonRow] = []
    for t, name in enumerate(SEVEN):
        for label, unit, keys, joint, term in (
            ("hip rise time", "s", ("hip_rise_s_HEAD", "hip_rise_s"), HIP, "rise_time"),
            ("knee frequency", "rad/s", ("knee_omega_rad_s", "knee_omega"), KNEE, "damped_frequency"),
            ("knee damping ratio", "1", ("knee_zeta", "knee_zeta"), KNEE, "damping_ratio"),
        ):
            ours = [getattr(found[t][joint], term) for found in (wanted, right, wrong)]
            cells: tuple[Cell, ...] = (
                table_cell(float(given[keys[0]][t]), unit),
                table_cell(ours[0], unit),
                table_cell(float(reached[keys[1]][t]), unit),
                table_cell(ours[1], unit),
                table_cell(ours[2], unit),
            )
            rows.append(ComparisonRow(f"{name}: {label}", cells))
        achieved = table_cell(float(reached["ankle_mean_signed_diff_rad"][t]), "deg")
        rest = (None, None, achieved, *(table_cell(float(mean[t]), "deg") for mean in means))
        rows.append(ComparisonRow(f"{name}: ankle, mean error", rest))
    return ComparisonTable(
        "Table A-1",
        "Each release: the rat at half speed, and the robot with the published rates",
        ("", "rat, published", "rat, ours", "robot, published", "robot, ours", "robot, ours with the mistakes"),
        tuple(rows),
        "Rise time from 10 to 90 % of the way to rest; damping ratio by the logarithmic decrement. The ankle's error "
        "is the signed mean, as computed in the thesis, which calls it an average difference.",
        tuple(_difference_sentences(published, (wanted, right, wrong), means)),
    )


def _difference_sentences(published: Mapping[str, Any], found: Sequence[Features], means: Sequence[Array]) -> list[str]:
    """Sentences on the median differences; ``found`` : of the recordings, of the model, of the model with mistakes."""
    given, reached = published["data"], published["achieved"]
    messages = []
    for label, joint, term, keys in (
        ("hip rise time", HIP, "rise_time", ("hip_rise_s_HEAD", "hip_rise_s")),
        ("knee frequency", KNEE, "damped_frequency", ("knee_omega_rad_s", "knee_omega")),
        ("knee damping ratio", KNEE, "damping_ratio", ("knee_zeta", "knee_zeta")),
    ):
        gaps = [_median_difference(given[keys[0]], found[0], joint, term)]
        gaps += [_median_difference(reached[keys[1]], model, joint, term) for model in found[1:]]
        words = [f"{100 * gap:.0f} %" if gap is not None else "not comparable" for gap in gaps]
        closer = gaps[1] is not None and gaps[2] is not None and gaps[2] < gaps[1]
        messages.append(
            f"{label}: our value for the recordings differs from the published one by {words[0]} (median of the seven; "
            "depends on the curve through 10 ms samples, on the rest pose and on the definition of a peak), for the "
            f"robot by {words[1]}, with the thesis' mistakes by {words[2]}"
            + (": they explain part of it." if closer else ": they do not explain it.")
        )
    ankle = np.degrees(np.mean(reached["ankle_mean_signed_diff_rad"]))
    negative = sum(value < 0 for value in reached["ankle_mean_signed_diff_rad"])
    ours = [float(np.degrees(mean.mean())) for mean in means]
    messages.append(
        f"ankle: the published errors are {ankle:+.2f} deg on average, {negative} of {len(SEVEN)} negative. Ours are "
        f"{ours[0]:+.2f} deg, {sum(means[0] < 0)} negative, with the right sign of the foot's weight, and "
        f"{ours[1]:+.2f} deg, {sum(means[1] < 0)} negative, with the thesis' mistakes."
    )
    return messages


def _median_difference(published: Sequence[float], found: Features, joint: int, term: str) -> float | None:
    """Median relative difference over the releases in which ours shows the feature; None if none does."""
    values = [(p, getattr(item[joint], term)) for p, item in zip(published, found, strict=True)]
    gaps = [abs(value / p - 1) for p, value in values if value is not None]
    return float(np.median(gaps)) if gaps else None
