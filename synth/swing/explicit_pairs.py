"""Two Runge-Kutta pairs 5(4) with dense output, and their sums of accelerations.

In both the last of six evaluations is the first of the next step, the second weight is zero, and the nodes 3 to 5
determine the rest: Dormand & Prince, J. Comp. Appl. Math. 6 (1980) 19.

``DORMAND_PRINCE`` is their pair: Hairer, Norsett & Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. 1993,
table II.5.2 and section II.6 (``dopri5``). ``DAMPED`` is for steps that stability limits, not their error: a light
outboard link with a damper decays at some hundred per second. Dormand and Prince's stability polynomial
``1 + z + ... + z^5/120 + z^6/600`` is stable for decays ``h lambda`` up to 3.3. With the nodes of ``DAMPED`` the last
coefficient is 1/1034 and the limit 4.4; the best possible is 6.3 at 1/1378. Its errors of a step are four times as
large. ``chain_integrator`` takes it where a step times the fastest decay is large: the leg of ``make bench`` then takes
a sixth fewer steps, and with dampers three times as strong a quarter fewer (``tests/swing/test_explicit_steps.py``).
With dry friction it would take more for like errors, because steps end at the turns, which the dense output places.

For a second-order system ``q' = w, w' = a`` the stages of q need no derivatives but those of w:
``q_s = q + h c_s w + h^2 sum_k (A A)_sk a_k`` (Hairer, Norsett & Wanner, section II.14), the same method with half of
the sums. In each of them the second acceleration has no weight from the end of the step on, as in the tableau itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

Row = tuple[float, ...]
Weights = tuple[Row, tuple[Row, ...], tuple[Row, ...], Row, Row, Row, Row]


@dataclass(frozen=True)
class RungeKuttaPair:
    """``nodes`` : shares of the step at which the stages lie.

    ``stages`` : row s has the weights of the derivatives so far in stage s; the last row is the end of the step.
    ``error`` : of the estimated error, the step less one of order 4. ``dense`` : of the dense output of order 4, the
    cubic of both ends and p^2 (1 - p)^2 times this sum.
    """

    nodes: Row
    stages: tuple[Row, ...]
    error: Row
    dense: Row

    @property
    def turned_stages(self) -> tuple[Row, ...]:
        """Weights of the accelerations in the stages of angles, over h, beside those of the first rate."""
        return tuple(self._of_accelerations(row) for row in self.stages)

    @property
    def turned_error(self) -> Row:
        """The same of an angle's estimated error."""
        return self._of_accelerations(self.error)

    @property
    def turned_dense(self) -> Row:
        """The same of an angle's dense output."""
        return self._of_accelerations(self.dense)

    @property
    def weights(self) -> Weights:
        """Of compiled code: nodes, stages and turned stages from the second on, the others and their turned ones."""
        stages, turned = self.stages[1:], self.turned_stages[1:]
        return self.nodes, stages, turned, self.error, self.turned_error, self.dense, self.turned_dense

    def _of_accelerations(self, weights: Sequence[float]) -> Row:
        """Weights of the accelerations in a sum of rates with these weights."""
        return tuple(
            sum(weights[s] * self.stages[s][k] for s in range(k + 1, len(weights)))
            for k in range(max(len(weights) - 1, 0))
        )


# Hairer, Norsett & Wanner, table II.5.2; the dense output as in ``dopri5``
DORMAND_PRINCE = RungeKuttaPair(
    nodes=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0),
    stages=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    ),
    error=(71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),
    dense=(
        -12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
        701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
    ),
)  # fmt: skip

# Nodes that need few steps of the bench's leg and of that with dampers 0.15 and 3 times as strong, found by search.
# Estimates of the error differ in size only: with this one a tolerance gives the errors that it gives with Dormand and
# Prince's pair. Sums of the dense output differ by multiples of the error's: this one has the least error over the
# step, as theirs has.
DAMPED = RungeKuttaPair(
    nodes=(0.0, 16 / 75, 8 / 25, 29 / 50, 17 / 25, 1.0, 1.0),
    stages=(
        (),
        (16 / 75,),
        (2 / 25, 6 / 25),
        (5597 / 25600, -2523 / 5120, 10933 / 12800),
        (1163327 / 4129600, -21369 / 28480, 978741 / 925600, 3060 / 33553),
        (-3846959 / 5402816, 468525 / 186304, -2008975 / 3632928, -3405780 / 1097447, 24920 / 8733),
        (4439 / 47328, 0.0, 100625 / 190944, -11000 / 23751, 11125 / 14688, 2911 / 34272),
    ),
    error=(
        -1667949 / 104516000, 0.0, 555983 / 5622240, -1111966 / 3496675, 555983 / 2162400, 125173 / 25228000,
        -27 / 1000,
    ),
    dense=(
        -54430621 / 58790250, 0.0, 8582498 / 4743765, 419626378 / 94410225,
        -198070657 / 29192400, -451632917 / 340578000, 2783 / 1000,
    ),
)  # fmt: skip
