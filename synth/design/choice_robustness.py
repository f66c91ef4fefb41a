"""What the fit leaves open of the wanted motion, and whether the choice of parts hangs on it.

The wanted leg is known as well as its trials tell it. Each draw of what they allow (``fit.draws``) moves otherwise from
the same releases; the chosen set and the next best are held against every one of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.response import WantedResponse
from synth.fit.fit_result import FitResult
from synth.remarks import decisive
from synth.swing.leg_model import Leg
from synth.units import quantity

HANGS = 0.5  # of the draws that the chosen set must be the best in, or the choice is said to hang on the fit


@dataclass(frozen=True)
class ChoiceRobustness:
    """``errors`` (n_set, n_draw) rad: RMS over joints and releases of each set against each wanted leg."""

    errors: Array
    wanted: Array  # (n_draw,) rad, how far each draw's own motion lies from the wanted one

    @property
    def best(self) -> Array:
        """(n_set,) share of draws in which a set is the best."""
        counts = np.bincount(self.errors.argmin(axis=0), minlength=len(self.errors))
        return np.asarray(counts / self.errors.shape[1])

    @property
    def warning(self) -> str | None:
        """A sentence where another set would be chosen as often."""
        if len(self.errors) < 2 or self.best[0] >= HANGS:
            return None
        return decisive(
            f"the choice of parts hangs on what the trials leave open: over {self.errors.shape[1]} legs that they "
            f"allow the chosen set is the best of {len(self.errors)} in {self.best[0]:.0%}; what would settle it "
            "stands under what to measure"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``response.fit_uncertainty``."""
        low, high = np.degrees(np.quantile(self.errors[0], [0.05, 0.95]))
        return {
            "legs_drawn": self.errors.shape[1],
            "wanted_motion_moves_by": quantity(float(np.median(self.wanted)), "deg"),
            "chosen": {**quantity(float(np.median(self.errors[0])), "deg"), "interval90": [float(low), float(high)]},
            "chosen_is_best": quantity(float(self.best[0]), "1"),
            "alternatives_best": [quantity(float(share), "1") for share in self.best[1:]],
        }


def told(wanted: WantedResponse, fit: FitResult, sets: Sequence[Leg]) -> ChoiceRobustness | None:
    """Hold sets of parts against the legs that the fit allows; None where it has no draws.

    A drawn leg whose motion cannot be followed is left out.
    """
    if not fit.drawn:
        return None
    free = [[j for j in range(len(fit.leg.joints)) if j not in r.conditions.locked] for r in wanted.releases]
    moved, drawn = wanted.simulate(sets), wanted.simulate(fit.drawn)
    good = np.all([np.isfinite(motion).all(axis=(0, 1)) for motion in drawn], axis=0)
    if not good.any():
        return None
    square = np.zeros((len(sets), int(good.sum())))
    off, count = np.zeros(int(good.sum())), 0
    for parts, legs, nominal, joints in zip(moved, drawn, wanted.motions, free, strict=True):
        legs = legs[:, joints][:, :, good]
        apart = parts[:, joints, :, None] - legs[:, :, None, :]
        square += np.nan_to_num((apart**2).sum(axis=(0, 1)), nan=np.pi**2 * apart.shape[0])
        off += ((legs - nominal[:, joints, None]) ** 2).sum(axis=(0, 1))
        count += len(nominal) * len(joints)
    return ChoiceRobustness(np.sqrt(square / count), np.sqrt(off / count))
