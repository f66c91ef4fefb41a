"""Table 6: what the bought dampers and springs are, and the springs that go with those dampers."""

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
from synth.validation.comparison_table import Cell, ComparisonRow, ComparisonTable, cell, percent
from synth.validation.explanations import inside
from synth.validation.thesis_data import JOINTS, LabData

SPRINGS = {"knee": "LTR135H 10 M", "ankle": "LTR080F 10 S"}  # what the thesis bought
# The hip's spring as the thesis wound it (its Tables 6, 7): music wire 0.1875 in, outside diameter 1.63 in, 1.04 coils.
WIRE, OUTSIDE, COILS, MODULUS = 0.1875 * 0.0254, 1.63 * 0.0254, 1.04, 203.4e9


def table_6(data: LabData, slow: Sequence[Recording]) -> ComparisonTable:
    """Damper rates from drops, the springs that suit them, and what the makers say; ``slow``: the wanted motion."""
    published = data.published["thesis_table_6"]
    rates = np.array(published["b_dampers"], dtype=float)
    laws = [_law(data, joint) for joint in JOINTS]
    linear = [next(fit for fit in law.fits if fit.law.name == "linear") for law in laws]
    curves = {name: DamperCurve((1.0,), (float(b),)) for name, b in zip(JOINTS, rates, strict=True)}
    fit = fit_leg(data.dog, slow, LegFitOptions(free_angle="per_trial", curves=curves, tolerance=data.tolerance))
    makers = _makers()
    rows: list[ComparisonRow] = []
    for j, name in enumerate(JOINTS):
        found = float(linear[j].parameters["rate"]["value"])
        rows.append(
            ComparisonRow(f"{name} b, damper alone", (cell(float(rates[j]), "N*m*s/rad"), cell(found, "N*m*s/rad")))
        )
    for j, name in enumerate(JOINTS):
        given = cell(float(published["k_given_dampers"][j]), "N*m/rad")
        rows.append(ComparisonRow(f"{name} k, wanted with that damper", (given, cell(fit.joints[name].spring_rate))))
    for j, name in enumerate(JOINTS):
        cells: tuple[Cell, ...] = (cell(float(published["k_manufacturer"][j]), "N*m/rad"), cell(makers[j], "N*m/rad"))
        rows.append(ComparisonRow(f"{name} k, by its maker", cells))
    said = [_of_law(law, float(rates[j])) for j, law in enumerate(laws)]
    said += _of_springs(np.array(published["k_given_dampers"], dtype=float), fit)
    said.append(
        f"hip, by its maker: k = E d^4/(64 D N) with the outside diameter for D gives "
        f"{_bending(OUTSIDE):.1f} N*m/rad, which is the published number; the formula wants the mean diameter, with "
        f"which the same spring has {_bending(OUTSIDE - WIRE):.1f} N*m/rad."
    )
    return ComparisonTable(
        "Table 6",
        "Dampers and springs of the built robot leg",
        ("", "published", "ours"),
        tuple(rows),
        "Damper rates: a straight line through the origin fitted to whole drops of the leg with that damper alone, "
        "every drop's start estimated. Springs: least squares on the slowed-down releases with the published damper "
        "rates held. By its maker: the built-in catalogue's row; for the hand-wound hip the bending formula.",
        tuple(said),
    )


def _law(data: LabData, joint: str) -> DamperLaw:
    """All laws of one joint's damper; the other joints are locked."""
    others = [name for name in JOINTS if name != joint]
    drops = data.trials(data.dampers, [{"file": f"dog/damper_drops/{joint}_*.csv", "locked": others}], (joint,))
    return find_damper_law(data.dampers, joint, drops)


def _of_law(law: DamperLaw, published: float) -> str:
    """The linear rate beside the published one, and how little a rate says of this damper."""
    fits = {fit.law.name: fit for fit in law.fits}
    linear, power = fits["linear"], fits["power"]
    rate = float(linear.parameters["rate"]["value"])
    torque = float(power.parameters["torque_at_1_rad_per_s"]["value"])
    exponent = float(power.parameters["exponent"]["value"])
    ends = [torque * speed ** (exponent - 1) for speed in (law.speeds.low, law.speeds.high)]
    return (
        f"{law.joint}, damper: {percent(rate / published)} against the published. No one rate is this damper's: its "
        f"torque goes with speed to the power {exponent:.2f}, so that torque over speed falls from {ends[0]:.3g} to "
        f"{ends[1]:.3g} N*m*s/rad between {law.speeds.low:.2g} and {law.speeds.high:.2g} rad/s, and what comes out "
        "depends on which part of a drop is judged (the thesis: the rise time). On drops that took no part a rate is "
        f"{np.degrees(linear.rms_held_out):.2g} deg off, the power law {np.degrees(power.rms_held_out):.2g} deg."
    )


def _of_springs(published: Array, fit: FitResult) -> list[str]:
    """The springs that suit the dampers, joint by joint."""
    said = []
    for j, (name, joint) in enumerate(fit.joints.items()):
        found = joint.spring_rate
        change = f"{percent(found.value / published[j])} against the published"
        if inside(found, float(published[j])):
            said.append(f"{name}, spring wanted with that damper: {change}, which lies within our 90 % interval.")
        else:
            said.append(
                f"{name}, spring wanted with that damper: {change}, outside our 90 % interval: with b held the "
                "trials fix k by angles, the thesis' cost by rise times, decrements and frequencies."
            )
    return said


def _makers() -> list[float | None]:
    """(3) N m/rad, spring rates as their makers have them; None where the catalogue lacks the part."""
    rows = {row.part: row for row in Catalogue.load().springs if isinstance(row, TorsionSpringRow)}
    found: list[float | None] = [_bending(OUTSIDE - WIRE)]
    for name in JOINTS[1:]:
        row = rows.get(SPRINGS[name])
        found.append(row.rate if row is not None else None)
    return found


def _bending(diameter: float) -> float:
    """N m/rad, rate of the hip's spring by bending: E I / l with I = pi d^4/64 and l = pi D N (Shigley, eq. 10-50)."""
    return MODULUS * (pi * WIRE**4 / 64) / (pi * diameter * COILS)
