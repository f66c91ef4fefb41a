"""How the free angle of an assembled joint is found where a stop keeps the joint from it."""

from __future__ import annotations

BY_TORQUES = (
    "turn the link off the stop with a spring scale, square to it at a known distance from the hinge, to two angles A "
    "and B some 15 deg apart; with the torques M and N there (scale times distance, the mean of going there from "
    "either side) the free angle is A - M (B - A)/(N - M)"
)
