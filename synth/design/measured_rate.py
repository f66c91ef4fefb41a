"""The rate of a measured spring in its joint, from the test by which it was measured.

A loose spring whose arms are pressed at a distance from the coil has another rate than in the joint, which clamps both
(``synth.spring.loose_test``). The ratio of the two is that of the wire's lengths that bend, whatever the wire: it is
known from the spring's dimensions, and the measured spring's rate changes with it.
"""

from __future__ import annotations

from synth.design.choose_springs import SpringOption
from synth.errors import Problem, UserError
from synth.files.project_options import MeasuredSpring
from synth.parts.coil_rate import active_coils


def rate_in_joint(measured: MeasuredSpring, option: SpringOption) -> float:
    """Rate (N m/rad) in the joint of all its springs, of which ``measured.rate`` was measured.

    Loose, without a stated distance: by the test that the design gives with the spring, for a bought spring whose joint
    is not drawn by its vendor's, close to the coil.
    """
    assert measured.rate is not None
    if measured.rate_held == "joint":
        return measured.rate
    return measured.rate * option.rate / (option.number * _loose_rate(option, measured.rate_distance))


def _loose_rate(option: SpringOption, distance: float | None) -> float:
    """Rate (N m/rad) of one nominal spring, loose, with pins ``distance`` m from its coil; None: as its test says."""
    row, made, test = option.row, option.design, option.test
    if test is not None:
        if distance is None:
            return test.rate
        coils, mean = (made.body_coils, made.mean_diameter) if made is not None else _coil(option)
        return test.rate_at(distance, coils, mean)
    assert row is not None
    assert row.rate is not None
    if distance is None:
        return row.rate
    coils, mean = _coil(option)
    return row.rate * coils / active_coils(coils, mean, (distance, distance))


def _coil(option: SpringOption) -> tuple[float, float]:
    """Coils and mean diameter (m) of a bought spring."""
    row = option.row
    assert row is not None
    if row.body_coils is None or row.mean_diameter is None:
        raise UserError(
            Problem(
                f"the catalogue lacks coils or diameter of {row.part}, so a rate measured at a distance from the coil "
                "cannot be converted; leave rate_distance out and measure close to the coil",
                key="measured.spring",
            )
        )
    return row.body_coils, row.mean_diameter
