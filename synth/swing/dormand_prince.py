"""The pair of Dormand & Prince 5(4) with dense output, and its sums of accelerations.

Hairer, Norsett & Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. 1993, table II.5.2 and section II.6
(``dopri5``). Six evaluations a step; the last one is the first of the next step.

For a second-order system ``q' = w, w' = a`` the stages of q need no derivatives but those of w:
``q_s = q + h c_s w + h^2 sum_k (A A)_sk a_k`` (ibid., section II.14), the same method with half of the sums. In each of
them the second acceleration has no weight from the end of the step on, as in the tableau itself.
"""

from __future__ import annotations

from collections.abc import Sequence

Row = tuple[float, ...]

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)  # shares of the step at which the stages lie
# Row s: weights of the derivatives so far in stage s; the last row is the end of the step.
STAGES: tuple[Row, ...] = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# Of the estimated error: the step less the one of order 4.
ERROR: Row = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
# Dense output of order 4: the cubic of both ends and p^2 (1 - p)^2 times this sum.
DENSE: Row = (
    -12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
    701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
)  # fmt: skip


def of_accelerations(weights: Sequence[float]) -> Row:
    """Weights of the accelerations in a sum of rates with these weights, over h, beside those of the first rate."""
    return tuple(
        sum(weights[s] * STAGES[s][k] for s in range(k + 1, len(weights))) for k in range(max(len(weights) - 1, 0))
    )


# The same for angles.
TURNED_STAGES: tuple[Row, ...] = tuple(of_accelerations(row) for row in STAGES)
TURNED_ERROR, TURNED_DENSE = of_accelerations(ERROR), of_accelerations(DENSE)
