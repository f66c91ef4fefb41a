"""Table 6: rates of the bought dampers and springs, and spring rates that suit those dampers."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from synth.arrays import Array
from synth.fit.damper_laws import DamperLaw, find_damper_law
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import Recording
from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow
from synth.swing.leg_model import DamperCurve
from synth.validation.comparison_table import Cell, ComparisonRow, ComparisonTable, percent, table_cell
from synth.validation.open_rates import within_interval
from synth.validation.thesis_data import JOINTS, LabData

SPRINGS = {"knee": "LTR135H 10 M", "ankle": "LTR080F 10 S"}  # parts that the thesis bought
# The hip's spring as the thesis wound it (its Tables 6, 7): music wire 0.1875 in, outside diameter 1.63 in, 1.04 coils.
WIRE, OUTSIDE, COILS, MODULUS = 0.1875 * 0.0254, 1.63 * 0.0254, 1.04, 203.4e9


def table_6(data: LabData, slow: Sequence[Recording]) -> ComparisonTable:
    """Damper rates from drops, spring rates that suit them, and the makers' rates; ``slow`` : the wanted motion."""
    published = data.published["thesis_table_6"]
    rates = np.array(published["b_dampers"], dtype=float)
    laws = [_damper_law(data, joint) for joint in JOINTS]
    linear = [next(fit for fit in law.fits if fit.law.name == "linear") for law in laws]
    curves = {name: DamperCurve((1.0,), (float(b),)) for name, b in zip(JOINTS, rates, strict=True)}
    fit = fit_leg(data.dog, slow, LegFitOptions(free_angle="per_trial", curves=curves, tolerance=data.tolerance))
    makers = _makers_rates()
    rows: list[ComparisonRow] = []
    for j, name in enumerate(JOINTS):
        found = float(linear[j].parameters["rate"]["value"])
        rows.append(
            ComparisonRow(
                f"{name} b, damper alone", (table_cell(float(rates[j]), "N*m*s/rad"), table_cell(found, "N*m*s/rad"))
            )
        )
    for j, name in enumerate(JOINTS):
        given = table_cell(float(published["k_given_dampers"][j]), "N*m/rad")
        rows.append(
            ComparisonRow(f"{name} k, wanted with that damper", (given, table_cell(fit.joints[name].spring_rate)))
        )
    for j, name in enumerate(JOINTS):
        cells: tuple[Cell, ...] = (
            table_cell(float(published["k_manufacturer"][j]), "N*m/rad"),
            table_cell(makers[j], "N*m/rad"),
        )
        rows.append(ComparisonRow(f"{name} k, by its maker", cells))
    messages = [_law_sentence(law, float(rates[j])) for j, law in enumerate(laws)]
    messages += _spring_sentences(np.array(published["k_given_dampers"], dtype=float), fit)
    messages.append(
        f"hip, by its maker: k = E d^4/(64 D N) with the outside diameter as D gives {_hip_rate(OUTSIDE):.1f} N*m/rad, "
        f"the published number. The formula needs the mean diameter, which gives {_hip_rate(OUTSIDE - WIRE):.1f} "
        "N*m/rad for the same spring."
    )
    return ComparisonTable(
        "Table 6",
        "Dampers and springs of the built robot leg",
        ("", "published", "ours"),
        tuple(rows),
        "Damper rates: a linear law fitted to whole drops of the leg with only that damper; the initial state of every "
        "drop is estimated. Springs: least squares on the releases at half speed with the published damper rates "
        "fixed. By its maker: the row of the built-in catalogue; for the hand-wound hip spring the bending formula.",
        tuple(messages),
    )


def _damper_law(data: LabData, joint: str) -> DamperLaw:
    """All laws of one joint's damper, fitted to drops in which the other joints are locked."""
    others = [name for name in JOINTS if name != joint]
    drops = data.trials(data.dampers, [{"file": f"dog/damper_drops/{joint}_*.csv", "locked": others}], (joint,))
    return find_damper_law(data.dampers, joint, drops)


def _law_sentence(law: DamperLaw, published: float) -> str:
    """A sentence on the linear rate against the published one, and on how poorly a linear law describes the damper."""
    fits = {fit.law.name: fit for fit in law.fits}
    linear, power = fits["linear"], fits["power"]
    rate = float(linear.parameters["rate"]["value"])
    torque = float(power.parameters["torque_at_1_rad_per_s"]["value"])
    exponent = float(power.parameters["exponent"]["value"])
    ends = [torque * speed ** (exponent - 1) for speed in (law.speeds.low, law.speeds.high)]
    return (
        f"{law.joint}, damper: {percent(rate / published)} against the published rate. The damper is not linear: its "
        f"torque is proportional to speed to the power {exponent:.2f}, so torque over speed falls from {ends[0]:.3g} "
        f"to {ends[1]:.3g} N*m*s/rad between {law.speeds.low:.2g} and {law.speeds.high:.2g} rad/s. A fitted rate "
        "depends on the part of a drop that is compared (the thesis: the rise time). On held-out drops the RMS error "
        f"of a linear law is {np.degrees(linear.rms_held_out):.2g} deg, of the power law "
        f"{np.degrees(power.rms_held_out):.2g} deg."
    )


def _spring_sentences(published: Array, fit: FitResult) -> list[str]:
    """Sentences on the spring rates that suit the dampers, one per joint."""
    messages = []
    for j, (name, joint) in enumerate(fit.joints.items()):
        found = joint.spring_rate
        change = f"{percent(found.value / published[j])} against the published rate"
        if within_interval(found, float(published[j])):
            messages.append(f"{name}, spring wanted with that damper: {change}, which lies within our 90 % interval.")
        else:
            messages.append(
                f"{name}, spring wanted with that damper: {change}, which lies outside our 90 % interval. With b "
                "fixed, our fit determines k from angles, the thesis' cost from rise times, decrements and frequencies."
            )
    return messages


def _makers_rates() -> list[float | None]:
    """Spring rates (3,) N m/rad by their makers; None if the catalogue does not contain the part."""
    rows = {row.part: row for row in Catalogue.load().springs if isinstance(row, TorsionSpringRow)}
    found: list[float | None] = [_hip_rate(OUTSIDE - WIRE)]
    for name in JOINTS[1:]:
        row = rows.get(SPRINGS[name])
        found.append(row.rate if row is not None else None)
    return found


def _hip_rate(diameter: float) -> float:
    """Rate of the hip's spring, N m/rad, for ``diameter`` D, m: E I / l, I = pi d^4/64, l = pi D N (Shigley, 10-50)."""
    return MODULUS * (pi * WIRE**4 / 64) / (pi * diameter * COILS)
