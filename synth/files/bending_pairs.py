"""A link's bending rate from a CSV of torque and deflection: ``deflection [deg],torque [N*m]``.

Both are read with errors of unknown sizes. However the errors are divided, the true slope is between that of the torque
over the deflection and the inverse of that of the deflection over the torque (Frisch 1934; Gillard, REVSTAT 8 (2010)
57). The rate is their geometric mean, its interval reaches from the lower end of the one to the upper end of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import stdtrit

from synth.errors import Problem, UserError
from synth.files.csv_table import in_si, read_table

FEWEST = 3  # pairs: a slope, an intercept, and one degree of freedom for their uncertainty
STRAIGHT = 0.15  # share of the largest torque that a straight line may leave (RMS) for a linear spring


@dataclass(frozen=True)
class BendingRate:
    """``rate`` N m/rad with its 90 % interval, from ``points`` pairs; ``offset`` N m of the unloaded gauge."""

    rate: float
    interval90: tuple[float, float]
    offset: float
    points: int


def read_bending(path: Path, name: str) -> BendingRate:
    """The slope between both least squares, with a free offset; Student's t for the interval.

    Raises
    ------
    UserError : too few pairs, no spread, a slope that is not positive, or a nonlinear relation.
    """
    table = read_table(path, name)
    values, problems = in_si(table, {"deflection": "rad", "torque": "N*m"}, "is not one of these")
    problems += [
        Problem(f'column "{title}" is missing', name, 1)
        for title in ("deflection [deg]", "torque [N*m]")
        if title.split(" ")[0] not in values
    ]
    if problems:
        raise UserError(problems)
    x, y = values["deflection"], values["torque"]
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < FEWEST or np.ptp(x) == 0.0:
        raise UserError(Problem(f"{len(x)} pairs; at least {FEWEST} at different deflections are needed", name))
    away = x - x.mean()
    over = y - y.mean()
    rate = float(away @ over / (away @ away))
    left = over - rate * away
    if rate <= 0.0:
        text = f"torque falls with deflection (slope {rate:.3g} N*m/rad): one of the two has the wrong sign"
        raise UserError(Problem(text, name, key="torque"))
    if np.sqrt(np.mean(left**2)) > STRAIGHT * np.abs(y).max():
        raise UserError(Problem("the pairs lie on no straight line; leave out where the link slips or yields", name))
    deviation = float(np.sqrt(left @ left / (len(x) - 2) / (away @ away)))
    half = float(stdtrit(len(x) - 2, 0.95)) * deviation
    inverse = float(over @ over / (away @ over))  # its relative deviation is the same
    between = float(np.sqrt(rate * inverse))
    offset = float(y.mean() - between * x.mean())
    return BendingRate(between, (rate - half, inverse * (1.0 + half / rate)), offset, len(x))
