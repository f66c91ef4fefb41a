"""What is known of a fit's unknowns: one measure for the table, the notes and the proposals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, Estimate
from synth.fit.least_squares import Solution
from synth.fit.link_errors import LinkErrors
from synth.fit.model_error import ModelError

MOST_LOGARITHM = 20.0  # of a factor: e^20 is open in any case, but finite
MOST_EXPONENT = 700.0  # exp(709) is the largest double


@dataclass(frozen=True)
class Known:
    """What is known of the unknowns.

    ``trials`` (p, p), covariance by the trials, static points and what the user states; ``total`` (p, p) with the
    links' and the law's errors; ``values`` (p,); ``ends`` (p,) each, of the reported intervals relative to the values;
    ``estimates`` the same by the unknowns' names; ``widths`` (4, n) of the links' parameters; ``least`` the other
    end of a ridge along which the values were moved.
    """

    trials: Array
    total: Array
    values: Array
    ends: tuple[Array, Array]
    estimates: Mapping[str, Estimate]
    widths: Array
    least: Solution | None = None

    def deviation(self, place: int) -> float:
        """Standard deviation of an unknown by the trials and what the user states."""
        return float(np.sqrt(self.trials[place, place]))

    def half_width(self, place: int) -> float:
        """The reported interval's, as a factor minus one; infinite for a rate that is not told from none."""
        return half_width(0.5 * float(self.ends[1][place] - self.ends[0][place]) / NORMAL90)

    def quotient(self, damper: int, spring: int) -> Estimate:
        """b/k in s with the 90 % interval of everything, as the rates have it."""
        value, cov = float(self.values[damper] - self.values[spring]), self.total
        variance = cov[damper, damper] + cov[spring, spring] - 2 * cov[damper, spring]
        half = NORMAL90 * float(np.sqrt(max(0.0, variance)))
        least = self.values if self.least is None else self.least.values
        moved = float(least[damper] - least[spring]) - value
        low, high = value + min(0.0, moved) - half, value + max(0.0, moved) + half
        return Estimate(float(np.exp(value)), "s", float(np.exp(low)), float(np.exp(min(high, MOST_EXPONENT))))

    @property
    def weight(self) -> float:
        """Relative standard deviation of a link's weight about a joint, from the least exact link."""
        length_mass_com = self.widths[:3]
        return float(np.sqrt((length_mass_com.max(axis=1) ** 2).sum()))


def with_links_and_law(links: LinkErrors | None, error: ModelError | None, cov: Array) -> Array:
    """The covariance (p, p) of the trials alone with the errors of the links and of the law."""
    return cov + (0.0 if links is None else links.covariance) + (0.0 if error is None else error.covariance)


def half_width(deviation: float) -> float:
    """Of the 90 % interval of a logarithm with this standard deviation, as a factor minus one."""
    return float(np.exp(min(NORMAL90 * deviation, MOST_LOGARITHM)) - 1)
