"""A link's bending rate from a CSV of torque and deflection: ``deflection [deg],torque [N*m]``.

Both are read with errors of unknown sizes. However the errors are divided, the true slope is between that of the torque
over the deflection and the inverse of that of the deflection over the torque (Frisch 1934; Gillard, REVSTAT 8 (2010)
57). The rate is their geometric mean, its interval reaches from the lower end of the one to the upper end of the other.

A link that is loaded and unloaded, in the order of the pairs, goes through a loop: its torque is lower on the way back
by what it loses. Each way then has an offset of its own, and the rate is that of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import stdtrit

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_table import in_si, read_table

FEWEST = 3  # pairs: a slope, an intercept, and one degree of freedom for their uncertainty
STRAIGHT = 0.15  # share of the largest torque that a straight line may leave (RMS) for a linear spring
# Of the RMS that one straight line leaves, what two parallel ones leave at most, one for each way: noise is halved by
# one more number in no more than a few pairs.
OF_A_LOOP = 0.5
FEWEST_A_WAY = 4  # pairs of each way of a loop: more than a line takes, so that noise makes no loop


@dataclass(frozen=True)
class BendingRate:
    """``rate`` N m/rad with its 90 % interval, from ``points`` pairs; ``offset`` N m of the unloaded gauge.

    ``loop`` : N m, by which the torque of the way back is lower at the same deflection; 0 if the pairs show no loop.
    """

    rate: float
    interval90: tuple[float, float]
    offset: float
    points: int
    loop: float = 0.0


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
    half_loop, way = _half_loop(x, y)
    y = y - half_loop * way
    away = x - x.mean()
    over = y - y.mean()
    rate = float(away @ over / (away @ away))
    left = over - rate * away
    if rate <= 0.0:
        text = f"torque falls with deflection (slope {rate:.3g} N*m/rad): one of the two has the wrong sign"
        raise UserError(Problem(text, name, key="torque"))
    if np.sqrt(np.mean(left**2)) > STRAIGHT * np.abs(y).max():
        raise UserError(Problem("the pairs lie on no straight line; leave out where the link slips or yields", name))
    taken = 2 + (half_loop > 0.0)
    deviation = float(np.sqrt(left @ left / (len(x) - taken) / (away @ away)))
    half = float(stdtrit(len(x) - taken, 0.95)) * deviation
    inverse = float(over @ over / (away @ over))  # its relative deviation is the same
    between = float(np.sqrt(rate * inverse))
    offset = float(y.mean() - between * x.mean())
    interval = rate - half, inverse * (1.0 + half / rate)
    return BendingRate(between, interval, offset, len(x), 2.0 * half_loop)


def _half_loop(deflection: Array, torque: Array) -> tuple[float, Array]:
    """Half the torque, N m, between loading and unloading, 0 without a loop, and +1 or -1 (m,) on the two ways.

    The way is that of the deflection where the torque goes the same; elsewhere noise moved one of them.
    """
    steps = np.sign(np.diff(deflection)) * (np.sign(np.diff(deflection)) == np.sign(np.diff(torque)))
    known = np.flatnonzero(steps)
    if not len(known):
        return 0.0, np.zeros(len(torque))
    last = known[np.maximum(np.searchsorted(known, np.arange(len(torque)) - 1, side="right") - 1, 0)]
    way = steps[last]
    if min(np.sum(way > 0.0), np.sum(way < 0.0)) < FEWEST_A_WAY:
        return 0.0, way
    line = np.column_stack([np.ones_like(deflection), deflection])
    both = np.column_stack([line, way])
    one, two = (np.linalg.lstsq(columns, torque, rcond=None)[0] for columns in (line, both))
    alone, apart = (float(np.sum((torque - c @ v) ** 2)) for c, v in ((line, one), (both, two)))
    found = two[2] > 0.0 and apart < OF_A_LOOP**2 * alone
    return (float(two[2]) if found else 0.0), way
