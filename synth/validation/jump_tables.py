"""Tables of the jumping leg: what the study says beside what comes out here, with why they differ."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees

import numpy as np

from synth.estimation.intervals import Estimate
from synth.jump.outcomes import APEX
from synth.validation.comparison_table import ComparisonRow, ComparisonTable, cell
from synth.validation.jump_claims import (
    BEST_LENGTHS,
    HALF_WIDTH,
    LENGTH,
    MEASURED,
    PREDICTED,
    ROTOR_INERTIA,
    SHORT_LENGTH,
    SHORT_RATIO,
    SUITABLE,
    Best,
    Configuration,
    calibrated,
    deepest,
    in_words,
    inertia_for,
    printed_work_share,
    spreads,
    tireless_point_mass,
)

LADDER = ("point_mass", "A", "B", "D", "full")
# What the text leaves open: volts, and N m s/rad a joint as multiples of the laboratory's code. The first is the code's
# own; batteries of one, two and three cells and the motor's rated 6 V bound the supply.
OPEN = ((5.7, 1.0), (6.0, 1.0), (7.4, 1.0), (7.4, 2.0), (7.4, 4.0), (9.0, 4.0), (9.0, 8.0), (11.1, 8.0))
FOLLOWED = (7.4, 2.0)  # the one whose best design is the study's; see ``configurations``


@dataclass(frozen=True)
class Case:
    """A configuration whose crouch is calibrated, or at its deepest where none gives the published height."""

    given: Configuration
    reached: bool
    heights: dict[str, float]
    best: Best
    inertia: float | None

    @classmethod
    def of(cls, supply: float, damping: float) -> Case:
        """With the crouch that gives model D's published height."""
        open_ = Configuration(supply=supply, damping=damping * Configuration.damping)
        found = calibrated(open_)
        given = found or replace(open_, crouch=deepest())
        return cls(
            given,
            found is not None,
            {model: given.height(model) for model in LADDER},
            given.best("D", SUITABLE),
            inertia_for(given),
        )


def jump_tables() -> tuple[ComparisonTable, ...]:
    """Claims, heights by model, and configurations."""
    cases = [Case.of(*item) for item in OPEN]
    followed = cases[OPEN.index(FOLLOWED)]
    return _claims(followed, cases), _heights(followed), _configurations(cases)


def _claims(case: Case, cases: list[Case]) -> ComparisonTable:
    given, tall, top = case.given, case.heights, case.given.best("D")
    full, short = _interval(given, "full"), float(given.by_length("D", SHORT_RATIO, np.array([SHORT_LENGTH]))[0])
    ours = {model: given.best(model, SUITABLE) for model in "ABD"}
    rows = (
        ("predicted clearance (D), 12 cm, 210:1", cell(PREDICTED, "cm"), cell(tall["D"], "cm")),
        ("measured clearance, mean of three", cell(MEASURED, "cm"), cell(full)),
        ("prediction over measurement", f"{PREDICTED / MEASURED:.2f}", f"{tall['D'] / tall['full']:.2f} (D over full)"),
        ("best gear ratio (D)", "210:1", f"{ours['D'].ratio:.0f}:1"),
        ("best leg (D)", BEST_LENGTHS, f"{100 * ours['D'].length:.0f} cm, of legs up to {100 * SUITABLE:.0f} cm"),
        ("clearance over leg length, predicted", f"{PREDICTED / LENGTH:.2f}", f"{tall['D'] / LENGTH:.2f}"),
        ("clearance over leg length, measured", f"{MEASURED / LENGTH:.2f}", f"{tall['full'] / LENGTH:.2f}"),
        ("8 cm with 150:1 jumps higher over its length than 12 cm with 210:1", "yes",
         f"{_yes(short / SHORT_LENGTH > tall['D'] / LENGTH)}: {short / SHORT_LENGTH:.2f} against "
         f"{tall['D'] / LENGTH:.2f}"),
        ("a point mass jumps higher than A", "yes",
         f"{_yes(tall['point_mass'] > tall['A'])}: {_cm(tall['point_mass'])} against {_cm(tall['A'])}"),
        ("motor dynamics (B) bring the scale right", "yes",
         f"A is {tall['A'] / MEASURED:.1f} and B {tall['B'] / MEASURED:.1f} times the measured height"),
        ("joint damping (D) brings the trend right", "yes",
         "best gear " + ", ".join(f"{name} {best.ratio:.0f}:1" for name, best in ours.items())),
    )  # fmt: skip
    share = printed_work_share(given.crouch, given.leg.extended)
    ends = [case.inertia for case in cases if case.reached and case.inertia is not None]
    low, high = full.low or 0.0, full.high or 0.0
    wide = 0.5 * (high - low) / full.value
    inside = "holds" if low <= MEASURED <= high else "does not hold"
    said = (
        f"Calibrated: {in_words(given)}. The crouch is the one number set by a published height (22 cm of D); "
        "supply and "
        "joint damping are not published either, and stand where D's best design is the study's.",
        f"Point mass: F = T cos(theta)/l as printed puts {100 * share:.0f} % of the motors' work on the mass, for "
        "a link "
        f"that pushes without loss does T dtheta = F l cos(theta) dtheta. It clears {_cm(tall['point_mass'])}, "
        "below A. "
        f"If the torque did not fall with speed it would clear {_cm(tireless_point_mass(given))}, above A: the claim "
        "follows from that, or from another equation than the printed one.",
        f"Measured: full has all of B and all of D, so it must jump lower than either. With the rotor inertia's public "
        f"estimate of {ROTOR_INERTIA:.1e} kg*m^2 it clears {_cm(tall['full'])}; the interval {inside} 18.3 cm. In "
        "every "
        f"configuration below that gives D 22 cm, full clears 18.3 cm only with {min(ends):.1e} to {max(ends):.1e} "
        f"kg*m^2, {100 * max(ends) / ROTOR_INERTIA:.0f} % of the estimate at most. A spin-down or a "
        "stall-to-free-speed run of the bare motor would settle it.",
        f"The 90 % interval is +-{100 * wide:.0f} %, where +-{100 * HALF_WIDTH:.0f} % would test the model: alone, "
        f"{_largest(given)}. Measured on the leg that was built, these would narrow it.",
        f"Best leg: D's clearance rises slowly with length, to {_cm(top.clearance)} at {100 * top.length:.0f} cm with "
        f"{top.ratio:.0f}:1, so that the best length is the longest that is allowed; the study speaks of suitable "
        f"lengths, of which {100 * SUITABLE:.0f} cm is its longest.",
    )
    return ComparisonTable(
        "Claims", "The jumping leg: what the study says", ("", "published", "ours"),
        tuple(ComparisonRow(label, (theirs, own)) for label, theirs, own in rows),
        "Heights are clearances: the foot's greatest height. The laboratory's masses, springs, ground and motor "
        "constants; "
        "gears without loss, as in its simulation; the maker's ratios from 30:1 to 380:1, legs of 6 cm and more.",
        said,
    )  # fmt: skip


def _heights(case: Case) -> ComparisonTable:
    given = case.given
    total = {model: given.height(model, row=APEX) for model in LADDER}
    rows = tuple(ComparisonRow(name, (cell(given.height(name), "cm"), cell(total[name], "cm"))) for name in LADDER)
    said = (
        f"Total height counts the body's rise while the leg stretches: D reaches {_cm(total['D'])} by it with the "
        "leg that "
        f"clears {_cm(case.heights['D'])}. {_as_total(given)}",
        "B holds no joint damping and D no motor dynamics; full holds both, and a ground that never pulls.",
    )
    return ComparisonTable(
        "Heights", "The 12 cm leg with 210:1 by each model", ("model", "clearance", "total height"), rows,
        f"{in_words(given)}. Total height: the greatest rise of the centre of mass over the crouch.", said,
    )  # fmt: skip


def _configurations(cases: list[Case]) -> ComparisonTable:
    rows = []
    for case in cases:
        given = case.given
        note = f"{case.best.ratio:.0f}:1, {100 * case.best.length:.0f} cm"
        cells = [cell(case.heights[model], "cm") for model in ("A", "B", "D", "full")]
        needed = None if case.inertia is None else f"{case.inertia:.1e} kg*m^2"
        label = f"{given.supply:g} V, {given.damping:.2g} N*m*s/rad"
        rows.append(ComparisonRow(label, (f"{degrees(given.crouch):.1f} deg", *cells, note, needed)))
    short = [case for case in cases if not case.reached]
    said = [
        f"{in_words(case.given)}: the lower links lock before D reaches 22 cm; it clears {_cm(case.heights['D'])}."
        for case in short
    ]
    told = [case for case in cases if case.reached]
    spread = [case.heights["full"] for case in told]
    said.append(
        f"With D at 22 cm, full clears {_cm(min(spread))} to {_cm(max(spread))} whatever the supply and damping: "
        "what the "
        "rotor takes from the push hangs on its inertia alone."
    )
    right = [case for case in told if 180.0 <= case.best.ratio <= 240.0 and 0.11 <= case.best.length <= 0.15]
    said.append(
        "D's best design lies at 180 to 240:1 and 11 to 15 cm for " + "; ".join(in_words(case.given) for case in right)
        + ": a supply of two cells and more damping than the code's round number."
    )  # fmt: skip
    return ComparisonTable(
        "Configurations", "Which crouch gives D's published 22 cm, and what follows",
        ("supply, joint damping", "crouch", "A", "B", "D", "full", "D's best design", "rotor inertia for 18.3 cm"),
        tuple(rows),
        f"The 12 cm leg with 210:1; best of legs up to {100 * SUITABLE:.0f} cm. The first row has the "
        "laboratory's own volts "
        "and damping. Full with a rotor inertia of 1.5e-8 kg*m^2, a public estimate.",
        tuple(said),
    )  # fmt: skip


def _as_total(given: Configuration) -> str:
    """What would follow if the published 22 cm were a total height."""
    other = calibrated(given, APEX)
    if other is None:
        return "Read as total height, the published 22 cm could not be had."
    clear = other.height("D")
    side = "below" if clear < MEASURED else "above"
    return (
        f"Read as total height, the published 22 cm would need a crouch of {degrees(other.crouch):.0f} deg and D would "
        f"clear {_cm(clear)}, {side} the {_cm(MEASURED)} that were measured: the 22 cm are a clearance."
    )


def _interval(given: Configuration, model: str) -> Estimate:
    value, low, high = given.interval(model)
    return Estimate(value, "cm", low, high)


def _largest(given: Configuration) -> str:
    """The three quantities that leave most open."""
    ranked = sorted(spreads(given, "full").items(), key=lambda item: item[1][0] - item[1][1])
    return ", ".join(f"{name} leaves {100 * low:.1f} to {_cm(high)}" for name, (low, high) in ranked[:3])


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


def _cm(value: float) -> str:
    return f"{100 * value:.1f} cm"
