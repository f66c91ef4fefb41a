"""Runge-Kutta 5(4) pair of the explicit step, with dense output: six evaluations, stable to -4.86 on the real axis.

A damper on a light foot makes one mode of a leg fast. It dies at once, but from then on stability limits the step, with
Dormand & Prince's pair to 3.31 time constants of that mode. The pair here is of their family of pairs (J. Comp. Appl.
Math. 6, 1980, 19-26: b2 = 0, stages of order 3 from the third one on, sum_i b_i a_ij = b_j (1 - c_j), last stage first
stage of the next step), which the nodes c3, c4, c5 determine; 3/10, 4/5, 8/9 give theirs. These nodes were chosen by a
search over the family: the longest interval of stability with coefficients below 2 (tests/swing/test_stable_pair.py
checks orders, interval, and the steps that it saves).

For a second-order system ``q' = w, w' = a`` the stages of q need no derivatives but those of w:
``q_s = q + h c_s w + h^2 sum_k (A A)_sk a_k``, the same method with half of the sums.
"""

from __future__ import annotations

from collections.abc import Sequence

Row = tuple[float, ...]

NODES = (0.0, 17 / 75, 17 / 50, 7 / 10, 19 / 20, 1.0, 1.0)
# Row s: weights of the derivatives so far in stage s; the last row is the end of the step.
STAGES: tuple[Row, ...] = (
    (),
    (17 / 75,),
    (17 / 200, 51 / 200),
    (4417 / 11560, -2793 / 2312, 441 / 289),
    (545851 / 1942080, -8379 / 18496, 321043 / 499392, 5795 / 12096),
    (5579947 / 8686762, -103425 / 65314, 2615525 / 1992077, 583 / 791, -14256 / 130967),
    (491 / 4522, 0.0, 437500 / 923967, 110 / 567, 480 / 1159, -113 / 594),
)
# The only combination of the seven derivatives that is zero to fourth order. Its scale is free: see ``SCALE``.
_DEFECT = (394 / 9367, 0.0, -1723750 / 8931681, 394 / 783, -44128 / 33611, -113 / 2871, 1.0)
# Of the estimated error. With it three links and a pendulum, lightly and heavily damped, err about as much at a
# tolerance as with Dormand & Prince's pair.
SCALE = 1 / 45
ERROR: Row = tuple(SCALE * value for value in _DEFECT)
# Dense output of order 4, continuous with its derivative: the cubic of both ends and p^2 (1 - p)^2 times this sum; the
# multiple of ``_DEFECT`` in it makes the terms of fifth order least on average, as in Dormand & Prince's own (Hairer,
# Norsett & Wanner, Solving ODEs I, section II.6).
DENSE: Row = (-1970 / 2261, 0.0, 700000 / 307989, -220 / 189, -6480 / 1159, 565 / 198, 5 / 2)


def of_accelerations(weights: Sequence[float]) -> Row:
    """Weights of the accelerations in a sum of rates with these weights, over h, beside those of the first rate."""
    return tuple(
        sum(weights[s] * STAGES[s][k] for s in range(k + 1, len(weights))) for k in range(max(len(weights) - 1, 0))
    )


# The same for angles.
TURNED_STAGES: tuple[Row, ...] = tuple(of_accelerations(row) for row in STAGES)
TURNED_ERROR, TURNED_DENSE = of_accelerations(ERROR), of_accelerations(DENSE)
