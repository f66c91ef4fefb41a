"""Robustness of the choice of parts against the uncertainty of the fit.

The wanted leg is known only within the uncertainty of its fit. Each draw from that uncertainty (``fit.draws``) is a leg
with another motion from the same releases. The chosen set and the next best sets are compared with every one of them.

Sets are chosen by their expected error with tolerances, so they are compared by it here too: to the square of a set's
nominal error against a drawn leg the tolerances add what they add to it against the fitted one, as independent
deviations do. Nominal errors alone would name another set in every draw wherever tolerances decide the choice, however
well the fit is known.
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

LEAST_BEST = 0.5  # of the draws: with a smaller fraction in which the chosen set is best, a warning is given


@dataclass(frozen=True)
class ChoiceRobustness:
    """``errors`` (n_set, n_draw) rad: RMS over joints and releases of each set, its parts nominal, against each draw.

    ``wanted`` : (n_draw,) rad, RMS difference of each draw's own motion from the wanted one. ``added`` : (n_set,)
    rad^2, what tolerances add to the square of a set's error.
    """

    errors: Array
    wanted: Array
    added: Array

    @property
    def best(self) -> Array:
        """(n_set,) fraction of draws in which a set is the best with its tolerances."""
        counts = np.bincount((self.errors**2 + self.added[:, None]).argmin(axis=0), minlength=len(self.errors))
        return np.asarray(counts / self.errors.shape[1])

    @property
    def warning(self) -> str | None:
        """A sentence if the chosen set is best in fewer than ``LEAST_BEST`` of the draws, else None."""
        if len(self.errors) < 2 or self.best[0] >= LEAST_BEST:
            return None
        return decisive(
            f"the choice of parts depends on the uncertainty of the fit: over {self.errors.shape[1]} legs that the "
            f"trials allow, the chosen set is the best of {len(self.errors)} in {self.best[0]:.0%}. The list of what "
            "to measure has the trials that would decide it"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``response.fit_uncertainty``."""
        low, high = np.degrees(np.quantile(self.errors[0], [0.05, 0.95]))  # 90 % interval
        return {
            "legs_drawn": self.errors.shape[1],
            "wanted_motion_moves_by": quantity(float(np.median(self.wanted)), "deg"),
            "chosen": {**quantity(float(np.median(self.errors[0])), "deg"), "interval90": [float(low), float(high)]},
            "chosen_is_best": quantity(float(self.best[0]), "1"),
            "alternatives_best": [quantity(float(share), "1") for share in self.best[1:]],
        }


def choice_robustness(
    wanted: WantedResponse, fit: FitResult, sets: Sequence[Leg], added: Sequence[float]
) -> ChoiceRobustness | None:
    """Compare sets of parts with legs drawn from the fit's uncertainty; None if the fit has no draws.

    ``added`` : rad^2, of each set, as in ``ChoiceRobustness``. A drawn leg whose simulation diverges is left out; a set
    whose own does is off by pi throughout.
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
        square += np.nan_to_num((apart**2).sum(axis=(0, 1)), nan=np.pi**2 * apart.shape[0] * apart.shape[1])
        off += ((legs - nominal[:, joints, None]) ** 2).sum(axis=(0, 1))
        count += len(nominal) * len(joints)
    return ChoiceRobustness(np.sqrt(square / count), np.sqrt(off / count), np.asarray(added, dtype=np.float64))
