"""Arrangements of dampers at a joint: several in parallel, one-way ones in pairs, geared or belted.

A damper that turns ``n`` times as fast as the joint resists it with ``n T(n w)``: the torque is multiplied once by the
lever and once more by the speed, so a linear damper counts ``n^2`` (the lever alone:
https://peirdamper.com/blog/how-do-you-size-a-rotary-damper). Dampers on one shaft add their torques, and one-way ones
work both ways as a pair, one per direction, the other adding its small reverse torque
(https://rotarydamper-tok-inc.com/technicalinformation-4/). Friction, backlash and inertia of gears and belts are
neglected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from synth.parts.rows import DamperRow
from synth.swing.leg_model import Damper, DamperCurve


@dataclass(frozen=True)
class Arrangement:
    """``count`` equal dampers (or pairs of one-way ones) on a shaft that turns ``ratio`` times as fast as the joint.

    ``reverse``: torque of a one-way damper in its free direction over that in the other; 0 for a two-way damper.
    """

    count: int = 1
    ratio: float = 1.0
    pair: bool = False
    reverse: float = 0.0

    @property
    def pieces(self) -> int:
        """Number of dampers to order."""
        return self.count * (2 if self.pair else 1)

    def words(self, part: str) -> str:
        """``2 x 6597K19, turning 1.5 times as fast``; only the part if it is directly on the joint."""
        if self.pair:
            number = f"{self.count} x " if self.count > 1 else ""
            text = f"{number}a pair of {part}, one each way"
        else:
            text = f"{self.count} x {part}" if self.count > 1 else part
        return text if self.ratio == 1.0 else f"{text}, turning {self.ratio:g} times as fast"

    def at_joint(self, damper: Damper) -> Damper:
        """Torque at the joint: ``count (1 + reverse) n T(n w)``."""
        factor = self.count * (1.0 + self.reverse) * self.ratio
        if damper.curve is None:
            return Damper(rate=(damper.rate or 0.0) * factor * self.ratio, part=damper.part)
        speed = tuple(value / self.ratio for value in damper.curve.speed)
        torque = tuple(value * factor for value in damper.curve.torque)
        return Damper(curve=DamperCurve(speed, torque), part=damper.part)


def arrangements(row: DamperRow | None, most: int, ratios: Sequence[float], direction: str) -> list[Arrangement]:
    """All arrangements of up to ``most`` of a damper at a joint that damps in ``direction`` (``both``, ``one``).

    A one-way damper at a joint that must be damped both ways takes a pair, which counts as two.
    """
    pair = row is not None and row.direction not in ("both", "") and direction == "both"
    reverse = 0.0
    if pair and row is not None and row.reverse_torque is not None and row.max_torque:
        reverse = row.reverse_torque / row.max_torque
    counts = range(1, most // 2 + 1) if pair else range(1, most + 1)
    return [Arrangement(count, ratio, pair, reverse) for count in counts for ratio in sorted(set(ratios))]
