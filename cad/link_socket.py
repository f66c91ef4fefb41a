"""The socket of a link's tube and the screw through it: plain arithmetic, no solids."""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.fittings import PrintDimensions
from synth.cad.hardware import Nut, Screw, long_screw, nuts

LEAST_SOCKET_SCREW = 3.0  # mm, nominal: a choice, its socket of 2.5 mm takes a common key
SPOT = 0.3  # mm, width of a flat on a socket beside head and nut
THINNEST = float(PrintDimensions.thinnest)  # mm of print under a flat
MOST_GROWN = 3.0  # mm; flats of an M3 screw ask for less than 2 on the thinnest tube
GROWN = 0.1  # mm, step of a socket that grows, of which its screw may become the next longer one


@dataclass(frozen=True)
class SocketScrew:
    """The screw through a link's socket with its nut; flats for both are ``flat`` mm from the tube's axis."""

    screw: Screw
    nut: Nut
    length: float
    flat: float

    @property
    def spot(self) -> float:
        """Radius (mm) of the flats: round head and nut."""
        return max(self.screw.head_diameter, self.nut.across_flats / math.cos(math.pi / 6)) / 2 + SPOT


def socket_screw(outer: float) -> SocketScrew | None:
    """For a socket of outer radius ``outer`` mm; None if no screw is sold that long."""
    size = LEAST_SOCKET_SCREW
    while True:
        found = long_screw(size, 2 * outer - 2 * SPOT)
        if found is None:
            return None
        screw, _ = found
        nut = nuts()[screw.size]
        spot = max(screw.head_diameter, nut.across_flats / math.cos(math.pi / 6)) / 2 + SPOT
        if spot >= outer:
            return None
        flat = math.sqrt(outer**2 - spot**2)
        fits = long_screw(screw.size, 2 * flat)
        if fits is not None and fits[0].size == screw.size:
            return SocketScrew(screw, nut, fits[1], flat)
        size = screw.size + 0.5


def socket_radius(link_width: float, fit: float, wall: float) -> float:
    """Outer radius (mm) of a socket: a wall round the tube, which the flats for head and nut do not cut too thin.

    On a thin tube they reach far round it: of a wall of 1.6 mm round 8 mm an M3 screw would leave 0.4 mm.
    """
    inside = link_width / 2 + fit
    outer = inside + wall
    while True:
        found = socket_screw(outer)
        if found is None and socket_screw(outer + MOST_GROWN) is None:
            return inside + wall  # too wide for any screw, which the fittings' checks refuse
        if found is not None and found.flat - inside >= min(THINNEST, wall):
            return outer
        outer += GROWN
