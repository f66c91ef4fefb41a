"""A range that the target states for a joint, and what a design asks of the joint beside it."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians
from typing import Any

from synth.remarks import decisive
from synth.units import quantity

LEAST_EXCESS = radians(0.05)  # beyond a range that counts: half of what is written of an angle
WIDEN = "Widen the range in the target's leg file, or want another motion."
MOTION, REST = "wanted motion", "rest pose"


@dataclass(frozen=True)
class StatedRange:
    """A range that the target states, and what the design asks of the joint; measured angles, rad.

    ``wanted``, ``built``: least and largest angle of the wanted motion, and of the built leg's without stops. ``rest``:
    of the built leg without stops.
    """

    joint: str
    stated: tuple[float, float]
    stops: tuple[float, float]
    wanted: tuple[float, float]
    built: tuple[float, float]
    rest: float

    @property
    def outside(self) -> tuple[str, ...]:
        """What of the design lies outside the range: ``wanted motion``, ``rest pose``."""
        found = {MOTION: self.wanted, REST: (self.rest, self.rest)}
        return tuple(what for what, ends in found.items() if beyond(ends, self.stated))

    @property
    def stopped(self) -> bool:
        """Whether a stop acts in the wanted or in the built leg's motion."""
        return any(beyond(ends, self.stops) for ends in (self.wanted, self.built, (self.rest, self.rest)))

    def warnings(self) -> list[str]:
        """A sentence for what lies outside."""
        low, high = (f"{degrees(angle):.4g}" for angle in self.stated)
        stated = f"{self.joint}: the target states a range of {low} to {high} deg"
        first, last = (f"{degrees(angle):.1f}" for angle in self.stops)
        stops = f"the stops at {first} and {last} deg"
        found = []
        if MOTION in self.outside:
            least, most = (f"{degrees(angle):.1f}" for angle in self.wanted)
            text = f"{stated}, and the wanted motion takes {least} to {most} deg"
            if beyond(self.wanted, self.stops):
                text += (
                    f". {stops.capitalize()} prevent it: the built leg is released from the nearest pose that they "
                    "allow, and its response and forecast have the contacts. Other parts of a joint are compared "
                    "without them"
                )
            found.append(decisive(text, WIDEN))
        if REST in self.outside:
            text = f"{stated}, and the built leg's rest pose is at {degrees(self.rest):.1f} deg"
            if beyond((self.rest, self.rest), self.stops):
                text += f": there the joint leans on one of {stops}, and it is drawn at that end of its range"
            found.append(decisive(text, WIDEN))
        return found

    def as_json(self) -> dict[str, Any]:
        """The entry ``range`` of a joint in ``design.json``."""
        pairs = {"stated": self.stated, "stops": self.stops, "wanted": self.wanted, "built": self.built}
        return {
            **{name: [quantity(angle, "deg") for angle in ends] for name, ends in pairs.items()},
            "rest": quantity(self.rest, "deg"),
            "outside": list(self.outside),
        }


def beyond(ends: tuple[float, float], limits: tuple[float, float]) -> bool:
    """Whether an end lies outside the limits."""
    return ends[0] < limits[0] - LEAST_EXCESS or ends[1] > limits[1] + LEAST_EXCESS
