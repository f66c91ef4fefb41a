"""Tables of the jumping leg: the study's claims beside our results, with the reasons for their differences."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np

from synth.estimation.intervals import Estimate
from synth.jump.hopper_leg import HopperTolerances
from synth.jump.outcomes import APEX, PEAK_GEAR_TORQUE
from synth.validation.comparison_table import Cell, ComparisonRow, ComparisonTable, table_cell
from synth.validation.jump_claims import (
    BEST_LENGTHS,
    GEAR_LIMIT,
    HALF_WIDTH,
    LENGTH,
    MEASURED,
    MEASURED_TOLERANCES,
    MOST_OVER,
    PREDICTED,
    ROTOR_INERTIA,
    ROTOR_LENGTH,
    SHORT_LENGTH,
    SHORT_RATIO,
    SUITABLE,
    TOLERANCES,
    BestDesign,
    Configuration,
    calibrate_crouch,
    constant_torque_point_mass,
    deepest_crouch,
    description,
    height_spreads,
    inertia_for,
    is_the_studys,
    printed_work_share,
    rotor_diameter,
)

DEEPEST = " (deepest crouch: 22 cm is out of reach)"
MODEL_LADDER = ("point_mass", "A", "B", "D", "full")
# The text gives neither the supply (V) nor the joint damping (a multiple of the value in the laboratory's code). The
# first pair is the code's own; the others range from the motor's rated 6 V to a battery of three cells.
OPEN = ((5.7, 1.0), (6.0, 1.0), (7.4, 1.0), (7.4, 2.0), (7.4, 4.0), (9.0, 4.0), (9.0, 8.0), (11.1, 8.0))
# A leg's stop is not published either: deg of the upper link and V, from a nearly stretched leg to one that stops
# halfway, at the motor's rated voltage and at those of batteries of two and three cells. The damping is the code's.
STOP_CONFIGURATIONS = ((25.0, 6.0), (25.0, 7.4), (35.0, 6.0), (35.0, 11.1), (40.0, 7.4), (40.0, 11.1))
FOLLOWED_CONFIGURATION = (7.4, 2.0)  # the configuration whose best design is the study's; see ``_configurations_table``


@dataclass(frozen=True)
class CrouchCase:
    """A configuration with calibrated crouch, or the deepest crouch if none gives the published height."""

    given: Configuration
    reached: bool
    heights: dict[str, float]
    best: BestDesign
    inertia: float | None
    gear_torque: float  # N m, largest of one gear in the full model

    @classmethod
    def of(cls, supply: float, damping: float, stop: float | None = None) -> CrouchCase:
        """The case with the crouch that gives model D's published height, or the deepest; ``stop`` in deg."""
        open_ = Configuration(supply=supply, damping=damping * Configuration.damping)
        if stop is not None:
            open_ = replace(open_, extended=radians(stop))
        found = calibrate_crouch(open_)
        given = found or replace(open_, crouch=deepest_crouch())
        return cls(
            given,
            found is not None,
            {model: given.height(model) for model in MODEL_LADDER},
            given.best("D", SUITABLE),
            inertia_for(given),
            given.height("full", row=PEAK_GEAR_TORQUE),
        )


def jump_tables() -> tuple[ComparisonTable, ...]:
    """The tables of claims, of heights by model, and of configurations."""
    cases = [CrouchCase.of(*item) for item in OPEN]
    followed = cases[OPEN.index(FOLLOWED_CONFIGURATION)]
    stopped = [CrouchCase.of(volts, 1.0, stop) for stop, volts in STOP_CONFIGURATIONS]
    return _claims_table(followed, cases), _heights_table(followed), _configurations_table(cases), _stops_table(stopped)


ClaimRow = tuple[str, Cell, Cell, bool | None]


def _claim_rows(case: CrouchCase, full: Estimate, short: float, ours: dict[str, BestDesign]) -> tuple[ClaimRow, ...]:
    """Each claim: published, ours, and whether it holds; None where ours is calibrated to it, or chosen so.

    ``full``: clearance by the full model; ``short``: that of the short leg by D, m; ``ours``: best designs by model.
    """
    tall = case.heights
    over = tall["D"] / tall["full"]
    measured = (full.low or 0.0) <= MEASURED <= (full.high or 0.0)
    shorter, heavier = short / SHORT_LENGTH > tall["D"] / LENGTH, tall["point_mass"] > tall["A"]
    return (
        ("predicted clearance (D), 12 cm, 210:1", table_cell(PREDICTED, "cm"), table_cell(tall["D"], "cm"), None),
        ("measured clearance, mean of three", table_cell(MEASURED, "cm"), table_cell(full), measured),
        ("prediction over measurement", f"{PREDICTED / MEASURED:.2f}", f"{over:.2f} (D over full)",
         abs(over / (PREDICTED / MEASURED) - 1.0) <= HALF_WIDTH),
        ("best gear ratio (D)", "210:1", f"{ours['D'].ratio:.0f}:1", None),
        ("best leg (D)", BEST_LENGTHS, f"{100 * ours['D'].length:.0f} cm, of legs up to {100 * SUITABLE:.0f} cm", None),
        ("clearance over leg length, predicted", f"{PREDICTED / LENGTH:.2f}", f"{tall['D'] / LENGTH:.2f}", None),
        ("clearance over leg length, measured", f"{MEASURED / LENGTH:.2f}", f"{tall['full'] / LENGTH:.2f}", measured),
        ("8 cm with 150:1 jumps higher over its length than 12 cm with 210:1", "yes",
         f"{_yes(holds=shorter)}: {short / SHORT_LENGTH:.2f} against {tall['D'] / LENGTH:.2f}", shorter),
        ("a point mass jumps higher than A", "yes",
         f"{_yes(holds=heavier)}: {_cm(tall['point_mass'])} against {_cm(tall['A'])}", heavier),
        ("motor dynamics (B) bring the scale right", "yes",
         f"A is {tall['A'] / MEASURED:.2f} and B {tall['B'] / MEASURED:.2f} times the measured height",
         abs(np.log(tall["B"] / MEASURED)) < abs(np.log(tall["A"] / MEASURED))),
        ("joint damping (D) brings the trend right", "yes",
         "best gear " + ", ".join(f"{name} {best.ratio:.0f}:1" for name, best in ours.items()),
         is_the_studys(ours["D"]) and not any(is_the_studys(ours[name]) for name in "AB")),
    )  # fmt: skip


def _claims_table(case: CrouchCase, cases: list[CrouchCase]) -> ComparisonTable:
    given, tall, top = case.given, case.heights, case.given.best("D")
    full, short = (
        _clearance_interval(given, "full"),
        float(given.by_length("D", SHORT_RATIO, np.array([SHORT_LENGTH]))[0]),
    )
    ours = {model: given.best(model, SUITABLE) for model in "ABD"}
    rows = _claim_rows(case, full, short, ours)
    share = printed_work_share(given.crouch, given.leg.extended)
    ends = [case.inertia for case in cases if case.reached and case.inertia is not None]
    low, high = full.low or 0.0, full.high or 0.0
    wide = _relative_half_width(given, TOLERANCES)
    inside = "contains" if low <= MEASURED <= high else "does not contain"
    messages = (
        f"Calibration: {description(given)}. Only the crouch is calibrated to a published height (22 cm of D). Supply "
        "and joint damping are not published either; they are chosen so that D's best design is the study's.",
        f"Point mass: the printed F = T cos(theta)/l does {100 * share:.0f} % of the motors' work on the mass; with a "
        "lossless link, T dtheta = F l cos(theta) dtheta, it would do all of it. The point mass clears "
        f"{_cm(tall['point_mass'])}, less than A. With a torque that does not fall with speed it would clear "
        f"{_cm(constant_torque_point_mass(given))}, more than A: the claim follows from that assumption, or from "
        "another equation than the printed one.",
        f"Measured: full includes everything in B and in D, so it must jump lower than either. With the public "
        f"estimate of the rotor inertia, {ROTOR_INERTIA:.1e} kg*m^2, it clears {_cm(tall['full'])}; the interval "
        f"{inside} 18.3 cm. In every configuration below that gives D 22 cm, full clears 18.3 cm only with "
        f"{min(ends):.1e} to {max(ends):.1e} kg*m^2, at most {100 * max(ends) / ROTOR_INERTIA:.0f} % of the estimate. "
        "A spin-down of the bare motor, or its run from stall to free speed, would determine the inertia.",
        f"The 90 % interval is +-{100 * wide:.0f} %; to test the model it must be +-{100 * HALF_WIDTH:.0f} %. The "
        f"largest contributions, each alone: {_largest(given)}. With motor, joints and masses measured on the built "
        f"leg it would be +-{100 * _relative_half_width(given, MEASURED_TOLERANCES):.0f} %.",
        f"Best leg: D's clearance rises slowly with length, to {_cm(top.clearance)} at {100 * top.length:.0f} cm with "
        f"{top.ratio:.0f}:1, so the best length is the longest one allowed. The longest length that the study calls "
        f"suitable is {100 * SUITABLE:.0f} cm.",
    )
    return ComparisonTable(
        "Claims", "The jumping leg: claims of the study", ("", "published", "ours", "holds"),
        tuple(ComparisonRow(label, (theirs, own, _held(holds)), None if holds is None else bool(holds))
              for label, theirs, own, holds in rows),
        "Heights are clearances: the greatest height of the foot. Masses, springs, ground and motor constants are the "
        "laboratory's; gears are lossless, as in its simulation; ratios are the maker's, from 30:1 to 380:1; legs are "
        f"6 cm and longer. A measured height holds inside our 90 % interval, the ratio of two within "
        f"{100 * HALF_WIDTH:.0f} %, the scale where B is nearer to the measured height than A, the trend where D's "
        "best design is the study's and those of A and B are not. Set: ours is calibrated to it.",
        messages,
    )  # fmt: skip


def _held(holds: bool | None) -> str:  # noqa: FBT001
    """``yes``, ``no``, or ``set`` where ours is calibrated to the claim."""
    return "set" if holds is None else _yes(holds=bool(holds))


def _heights_table(case: CrouchCase) -> ComparisonTable:
    given = case.given
    total = {model: given.height(model, row=APEX) for model in MODEL_LADDER}
    rows = tuple(
        ComparisonRow(name, (table_cell(given.height(name), "cm"), table_cell(total[name], "cm")))
        for name in MODEL_LADDER
    )
    messages = (
        f"Total height includes the body's rise while the leg extends: D reaches {_cm(total['D'])} with the leg whose "
        f"clearance is {_cm(case.heights['D'])}. {_total_height_sentence(given)}",
        "B has no joint damping and D no motor dynamics; full has both, and a ground that never pulls.",
    )
    return ComparisonTable(
        "Heights", "The 12 cm leg with 210:1 by each model", ("model", "clearance", "total height"), rows,
        f"{description(given)}. Total height: the greatest rise of the centre of mass above the crouch.", messages,
    )  # fmt: skip


def _configurations_table(cases: list[CrouchCase]) -> ComparisonTable:
    rows = []
    for case in cases:
        given = case.given
        note = f"{case.best.ratio:.0f}:1, {100 * case.best.length:.0f} cm"
        cells = [table_cell(case.heights[model], "cm") for model in ("A", "B", "D", "full")]
        needed = None if case.inertia is None else f"{case.inertia:.1e} kg*m^2"
        label = f"{given.supply:g} V, {given.damping:.2g} N*m*s/rad" + ("" if case.reached else DEEPEST)
        rows.append(ComparisonRow(label, (f"{degrees(given.crouch):.1f} deg", *cells, note, needed)))
    short = [case for case in cases if not case.reached]
    messages = [
        f"{description(case.given)}: the lower links lock before D reaches 22 cm; it clears {_cm(case.heights['D'])}."
        for case in short
    ]
    complete = [case for case in cases if case.reached]
    spread = [case.heights["full"] for case in complete]
    messages.append(
        f"With D at 22 cm, full clears {_cm(min(spread))} to {_cm(max(spread))} for all supplies and dampings: the "
        "energy that the rotor takes depends only on its inertia."
    )
    right = [case for case in complete if is_the_studys(case.best)]
    messages.append(
        "D's best design lies at 180 to 240:1 and 11 to 15 cm for "
        + "; ".join(description(case.given) for case in right)
        + ": a supply of two cells, and more damping than in the laboratory's code."
    )  # fmt: skip
    return ComparisonTable(
        "Configurations", "The crouch that gives D's published 22 cm, or the deepest, and the resulting heights",
        ("supply, joint damping", "crouch", "A", "B", "D", "full", "D's best design", "rotor inertia for 18.3 cm"),
        tuple(rows),
        f"The 12 cm leg with 210:1; best design among legs up to {100 * SUITABLE:.0f} cm. The first row has the "
        "supply and damping of the laboratory's code. Full has a rotor inertia of 1.5e-8 kg*m^2, a public estimate.",
        tuple(messages),
    )  # fmt: skip


def _stops_table(cases: list[CrouchCase]) -> ComparisonTable:
    """Legs that stop before they are stretched: the foot leaves the ground while the rotors still turn slowly."""
    rows, complete = [], [case for case in cases if case.reached]
    for case in cases:
        given, needed = case.given, case.inertia
        cells = [table_cell(case.heights[model], "cm") for model in ("D", "full")]
        share = "-" if needed is None else f"{100 * needed / ROTOR_INERTIA:.0f} %"
        best = f"{case.best.ratio:.0f}:1, {100 * case.best.length:.0f} cm"
        label = f"{degrees(given.extended):.0f} deg, {given.supply:g} V" + ("" if case.reached else DEEPEST)
        torque = table_cell(case.gear_torque, "N*m")
        rows.append(ComparisonRow(label, (f"{degrees(given.crouch):.1f} deg", *cells, best, share, torque)))
    messages = _stop_sentences(complete)
    return ComparisonTable(
        "Stops", "The same where the leg stops before it is stretched",
        ("stop, supply", "crouch", "D", "full", "D's best design", "rotor inertia for 18.3 cm, of the estimate",
         "full's largest gear torque"),
        tuple(rows),
        "Stop: the upper link from straight down, 10 deg in the tables above. Joint damping as in the laboratory's "
        "code; the crouch gives D the published 22 cm where it can.",
        messages,
    )  # fmt: skip


def _stop_sentences(cases: list[CrouchCase]) -> tuple[str, ...]:
    """Why a stop explains no height: the rotors hit it, and the gear carries that blow."""
    high = max(cases, key=lambda case: case.heights["full"])
    borne = [case for case in cases if case.gear_torque <= MOST_OVER * GEAR_LIMIT]
    sentences = [
        f"The higher the stop, the less the rotors take: full clears up to {_cm(high.heights['full'])} "
        f"({degrees(high.given.extended):.0f} deg, {high.given.supply:g} V; D's best gear there is "
        f"{high.best.ratio:.0f}:1). But the rotors hit the stop at speed, and a gear carries {high.gear_torque:.1f} "
        f"N*m, {high.gear_torque / GEAR_LIMIT:.0f} times the {GEAR_LIMIT:g} N*m that its maker allows.",
    ]
    needed = [case.inertia for case in borne if case.inertia is not None]
    if needed:
        tall = max(case.heights["full"] for case in borne)
        sentences.append(
            f"Where a gear carries at most {MOST_OVER:g} times the maker's limit, full clears at most {_cm(tall)}. It "
            f"would clear 18.3 cm with a rotor of {1e3 * rotor_diameter(max(needed)):.1f} mm instead of "
            f"{1e3 * rotor_diameter(ROTOR_INERTIA):.1f} mm (solid, {1e3 * ROTOR_LENGTH:g} mm long, in a can of 10 by "
            "12 mm). So no number that the study leaves open gives the measured height, unless the rotor is that "
            "light."
        )
    return tuple(sentences)


def _total_height_sentence(given: Configuration) -> str:
    """The consequence of reading the published 22 cm as a total height."""
    other = calibrate_crouch(given, APEX)
    if other is None:
        return "As a total height the published 22 cm cannot be reached."
    clear = other.height("D")
    side = "below" if clear < MEASURED else "above"
    return (
        f"As a total height the published 22 cm would need a crouch of {degrees(other.crouch):.0f} deg, and D would "
        f"clear {_cm(clear)}, {side} the measured {_cm(MEASURED)}: the 22 cm are a clearance."
    )


def _clearance_interval(given: Configuration, model: str) -> Estimate:
    value, low, high = given.interval(model)
    return Estimate(value, "cm", low, high)


def _relative_half_width(given: Configuration, tolerances: HopperTolerances) -> float:
    """Half of the 90 % interval of the full model's clearance, over the clearance."""
    value, low, high = given.interval("full", tolerances)
    return 0.5 * (high - low) / value


def _largest(given: Configuration) -> str:
    """The three quantities whose tolerances contribute most to the interval, as text."""
    ranked = sorted(height_spreads(given, "full").items(), key=lambda item: item[1][0] - item[1][1])
    return ", ".join(f"{name} gives {100 * low:.1f} to {_cm(high)}" for name, (low, high) in ranked[:3])


def _yes(*, holds: bool) -> str:
    return "yes" if holds else "no"


def _cm(value: float) -> str:
    return f"{100 * value:.1f} cm"
