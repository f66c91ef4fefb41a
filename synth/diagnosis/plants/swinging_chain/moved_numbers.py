"""Stated numbers that a fit moves far within their tolerances, and the error that they would leave as stated.

A wrong number may pass for a tolerance: two and a half of them cost no more than a cause does, one of many candidates.
What closes the gap is then in no cause, and is told here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, expm1
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.odds import LEAST_FURTHER_SHARE
from synth.diagnosis.plant import Plant, T
from synth.diagnosis.plants.swinging_chain.stated_numbers import NUMBERS_CHANGED
from synth.diagnosis.plants.swinging_chain.tolerance_words import LEAST_TOLERANCES
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.search_limits import tolerances_at_limits
from synth.diagnosis.sentences import angle_text
from synth.estimation.intervals import Estimate
from synth.remarks import at_joint
from synth.swing.leg_model import Leg
from synth.swing.tolerances import QUANTITIES, Tolerances
from synth.units import quantity, significant

QUANTITY_WORDS = {
    "length": "link length",
    "mass": "link mass",
    "com": "distance of the centre of mass",
    "inertia": "link inertia",
    "spring_rate": "spring rate",
    "damper_rate": "damper rate",
    "rest": "free angle",
    "torque_constant": "torque constant",
    "resistance": "winding resistance",
}
KEYS = {"spring_rate": "spring", "damper_rate": "damper", "rest": "free_angle"}  # under ``tolerance:``, where others
MOST_IN_SENTENCE = 2  # numbers; the remarks have all
KIND = "moved number"


@dataclass(frozen=True)
class MovedNumber:
    """A number of a joint that a fit moves by some of its tolerances.

    ``name`` : one of ``QUANTITIES``; ``change`` relative, of a free angle in rad as measured; ``count`` of tolerances,
    with its sign; ``at_limit`` : the most that the search allows. ``left`` : RMS error of the scored trials in rad with
    the fit, ``stated`` with this number alone back as it is stated.
    """

    joint: str
    name: str
    change: float
    count: float
    at_limit: bool
    left: Estimate
    stated: Estimate

    def as_json(self) -> dict[str, Any]:
        """The entry under ``moved_numbers``."""
        return {
            "joint": self.joint,
            "quantity": KEYS.get(self.name, self.name),
            "change": quantity(self.change, "deg" if self.name == "rest" else "1"),
            "tolerances": self.count,
            "at_limit": self.at_limit,
            "error": self.left.as_json(),
            "error_as_stated": self.stated.as_json(),
        }

    @property
    def words(self) -> str:
        """``torque constant 28 % above the stated one, 2.5 of your tolerances``."""
        size = abs(degrees(self.change) if self.name == "rest" else 100.0 * self.change)
        unit, sense = "°" if self.name == "rest" else " %", "above" if self.change > 0.0 else "below"
        most = ", the most that is tried" if self.at_limit else ""
        return (
            f"{QUANTITY_WORDS[self.name]} {significant(size, 2)}{unit} {sense} the stated one, "
            f"{significant(abs(self.count), 2)} of your tolerances{most}"
        )

    @property
    def tells_apart(self) -> bool:
        """Whether the errors with and without the move differ as they are written."""
        return angle_text(self.stated) != angle_text(self.left)

    @property
    def remark(self) -> str:
        """For the list of remarks; to check where the search ends there, since the true number may be further off."""
        text = self.words
        if self.tells_apart:
            text += f": with the stated one the error is {angle_text(self.stated)}, not {angle_text(self.left)}"
        if self.at_limit:
            text += ". The true one may be further off: measure it, or state a larger tolerance"
        return at_joint(self.joint, text, "check" if self.at_limit else "note", kind=KIND)


def moved_numbers(
    plant: Plant[EvaluatedHypothesis, T, Array],
    leg: Leg,
    tolerances: Tolerances,
    fit: EvaluatedHypothesis,
    errors: PredictionErrors,
) -> tuple[MovedNumber, ...]:
    """The numbers that a fit moves by ``LEAST_TOLERANCES`` or more and that matter, the most important first.

    One matters if, back as stated, it leaves a tenth of the error as designed more; at the limit of its search, more
    than the noise. A number that a cause of the fit changes too is told with the cause.
    """
    told = {
        (quantity, cause.key[1]) for cause in fit.hypothesis for _, quantity in NUMBERS_CHANGED.get(cause.key[0], ())
    }
    x = fit.unknowns[: tolerances.size]
    far = [k for k in np.flatnonzero(np.abs(x) >= LEAST_TOLERANCES).tolist() if _place(k, leg) not in told]
    if not far:
        return ()
    left, designed, noise = _rms(plant, fit), errors.figure("as_designed").value, errors.floor.value
    found = []
    for k in far:
        unknowns = fit.unknowns.copy()
        unknowns[k] = 0.0
        stated, at_limit = _rms(plant, fit.at(unknowns)), tolerances_at_limits(x[k : k + 1])
        more = float(np.sqrt(max(stated**2 - left**2, 0.0)))
        if more >= LEAST_FURTHER_SHARE * designed or (at_limit and more > noise):
            name, joint = _place(k, leg)
            shift = float(x[k] * tolerances.width.ravel()[k])
            change = leg.joints[leg.joint_names.index(joint)].sign * shift if name == "rest" else expm1(shift)
            both = Estimate(left, "deg"), Estimate(stated, "deg")
            found.append(MovedNumber(joint, name, change, float(x[k]), at_limit, *both))
    return tuple(sorted(found, key=lambda number: -number.stated.value))


def with_moved_numbers(fields: Mapping[str, Any], found: Sequence[MovedNumber]) -> dict[str, Any]:
    """The fields of a diagnosis with their remarks; where no cause is named, they stand in its sentence too."""
    told = sentence_of_numbers(found) if fields["verdict"] in ("none", "unknown") else ""
    warnings = (*fields["warnings"], *(item.remark for item in found))
    return {**fields, "sentence": fields["sentence"] + told, "warnings": warnings}


def sentence_of_numbers(found: Sequence[MovedNumber]) -> str:
    """What the errors within tolerances rest on, after a diagnosis that names no cause; empty without any number."""
    if not found:
        return ""
    each = [
        f"the {item.joint}'s {item.words}" + item.tells_apart * f" (as stated it leaves {angle_text(item.stated)})"
        for item in found
    ]
    more = f", and {len(each) - MOST_IN_SENTENCE} more" if len(each) > MOST_IN_SENTENCE else ""
    return f" This takes {'; '.join(each[:MOST_IN_SENTENCE])}{more}."


def _place(k: int, leg: Leg) -> tuple[str, str]:
    """Quantity and joint of a tolerance's unknown."""
    row, joint = divmod(k, len(leg.joints))
    return QUANTITIES[row], leg.joint_names[joint]


def _rms(plant: Plant[EvaluatedHypothesis, T, Array], fit: EvaluatedHypothesis) -> float:
    """RMS error of the scored trials, rad."""
    return plant.rms(plant.as_read(plant.predict(fit, plant.scored)))
