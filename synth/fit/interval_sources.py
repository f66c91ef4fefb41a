"""Sources of an interval: the trials, the error of the leg's law, and each parameter of the leg file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.estimation.intervals import NORMAL90, Estimate
from synth.fit.known import Known
from synth.fit.link_errors import WORDS, LinkErrors
from synth.fit.model_error import ModelError
from synth.fit.unknowns import SpringsAndDampers
from synth.units import quantity

TRIALS = "trials"
LAW = "the leg's law"
NAMED_SHARE = 0.5  # share of the variance from which a parameter of the leg file is named
RATE_UNITS = {"spring_rate": "N*m/rad", "damper_rate": "N*m*s/rad"}
MOST_NAMED = 3  # most parameters in a sentence


@dataclass(frozen=True)
class IntervalSource:
    """One estimate's variance by source.

    ``shares`` : source -> share, summing to 1: ``trials`` (their noise, and a ridge that they leave open), ``the leg's
    law`` where it is not known, or a parameter of the leg file such as ``mass of the knee's link``. ``half`` : half of
    the reported 90 % interval, relative for a rate (of a symmetric one in the logarithm), in rad for a free angle.
    ``reported`` : the estimate with its interval; ``most`` : of a rate that is not told from none, the interval's upper
    end, SI; the lower is 0.
    """

    joint: str
    quantity: str
    half: float
    reported: Estimate
    shares: Mapping[str, float]
    most: float | None = None

    @property
    def of_links(self) -> float:
        """The share due to the leg file's parameters."""
        return 1.0 - self.shares[TRIALS] - self.shares.get(LAW, 0.0)

    @property
    def sentence(self) -> str | None:
        """The dominant source in words; None if it is the trials."""
        if self.of_links < NAMED_SHARE:
            return None
        wide = f"90 % interval, {self.reported.words},"
        if self.most is not None:
            wide = f"upper limit of {self.most:.2g} {RATE_UNITS[self.quantity]}"
        ranked = sorted(((s, n) for n, s in self.shares.items() if n not in (TRIALS, LAW)), reverse=True)
        largest: list[tuple[float, str]] = []
        for item in ranked[:MOST_NAMED]:
            largest.append(item)
            if sum(share for share, _ in largest) >= 0.9 * self.of_links:  # the rest is not worth a name
                break
        kinds = {"motors" if name.endswith(("motor", "winding")) else "links" for _, name in largest}
        named = ", ".join(f"{name} ({100 * share:.0f} %)" for share, name in largest)
        return (
            f"{self.joint}: {100 * self.of_links:.0f} % of the variance in the {self.quantity.replace('_', ' ')}'s "
            f"{wide} comes from the leg file's tolerances: {named}. More trials would not reduce it; better "
            f"measured {' and '.join(sorted(kinds))} would"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry of ``interval_sources``: shares of the variance, the largest first."""
        half = quantity(self.half, "deg" if self.quantity == "free_angle" else "%")
        if self.most is not None:
            half = quantity(0.5 * self.most, RATE_UNITS[self.quantity])
        ranked = sorted(self.shares.items(), key=lambda item: -item[1])
        return {
            "joint": self.joint,
            "quantity": self.quantity,
            "half_width90": half,
            # Rounded to four decimals it would be 0.
            "shares": {name: round(share, 4) for name, share in ranked if share >= 5e-5 or name == TRIALS},
            "text": self.sentence,
        }


def sources_of(
    unknowns: SpringsAndDampers, known: Known, links: LinkErrors | None, error: ModelError | None = None
) -> tuple[IntervalSource, ...]:
    """Of every estimate that has an interval; empty if the links are known exactly.

    What the links and the law do not explain of the reported intervals is the trials'.
    """
    values, offsets = known.values, known.ends
    if links is None:
        return ()
    none = np.isneginf(offsets[0])  # a rate that is not told from none, or the free angle of such a spring
    half90 = np.where(none, np.expm1(np.where(none, np.minimum(offsets[1], 300.0), 0.0)), 0.5)
    half90[~none] *= (offsets[1] - offsets[0])[~none]
    variance = np.maximum((half90 / NORMAL90) ** 2, 1e-300)
    shares = links.considered.sensitivity**2 / variance[:, None]
    law = np.zeros(len(variance)) if error is None else np.diag(error.covariance) / variance
    names = [WORDS[what].format(joint) for joint, what in links.names]
    found = []
    for joint, kind, place in _places(unknowns):
        half, most = float(half90[place]), None
        if none[place] and kind == "free_angle":
            continue
        if none[place]:
            most = float(np.exp(values[place] + offsets[1][place]))
        elif kind != "free_angle":
            half = float(np.expm1(min(half, 20.0)))  # e^20: open in any case, but finite
        others = dict(zip(names, shares[place].tolist(), strict=True))
        if error is not None:
            others[LAW] = float(law[place])
        shared = {TRIALS: max(0.0, 1.0 - sum(others.values())), **others}
        found.append(IntervalSource(joint, kind, half, known.estimates[f"{kind} {joint}"], shared, most))
    return tuple(found)


def _places(unknowns: SpringsAndDampers) -> list[tuple[str, str, int]]:
    """Joint, quantity and index of the unknown, joint by joint."""
    found = []
    for j, name in enumerate(unknowns.leg.joint_names):
        if j in unknowns.rates:
            found.append((name, "spring_rate", unknowns.rate_at(j)))
        if j in unknowns.dampers:
            found.append((name, "damper_rate", unknowns.damper_at(j)))
        if j in unknowns.rests:
            found.append((name, "free_angle", unknowns.rest_at(j)))
    return found
