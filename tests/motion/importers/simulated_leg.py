"""A leg whose angles are known, as points in a picture: the truth that importers are held against.

The points are written out from the definition of the file format, one link after another, and not by the project's
own mechanics.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fit.simulated_legs import LINKS, NAMES, robot
from synth.swing.leg_model import Leg

Array = NDArray[np.float64]
RATE = 200.0  # Hz
COUNT = 300
PARTS = ("hip", "knee", "ankle", "toe")
RANGES = ((60, 150), (60, 175), (80, 179))  # deg


def leg() -> Leg:
    """The robot with ranges."""
    spans = {n: {"range": (math.radians(a), math.radians(b))} for n, (a, b) in zip(NAMES, RANGES, strict=True)}
    return robot().with_joints(**spans)


def angles() -> tuple[Array, Array]:
    """Clock (n,) s and measured angles (n, 3) deg: held for 0.5 s, then decaying swings at three rates."""
    time = np.arange(COUNT) / RATE
    since = np.maximum(time - 0.5, 0.0)
    columns = []
    for rest, away, decay, turn in ((105, 20, 5.0, 8.0), (110, -35, 4.0, 16.0), (140, 22, 6.0, 24.0)):
        damped = np.exp(-decay * since) * (np.cos(turn * since) + decay / turn * np.sin(turn * since))
        columns.append(rest + away * damped)
    return time, np.stack(columns, axis=1)


def points(measured: Array, tilt: float = 0.0) -> Array:
    """(n, 4, 2) m: hip, knee, ankle, toe, x to the right and z up, of measured angles (n, 3) deg."""
    hip, knee, ankle = np.radians(measured).T
    thigh = math.radians(tilt) + hip - math.pi / 2  # hip: zero 90 deg, sign +1
    shank = thigh + knee - math.pi  # knee: zero 180 deg, sign +1
    foot = shank - (ankle - math.pi)  # ankle: zero 180 deg, sign -1
    places = [np.zeros((len(hip), 2))]
    for link, turn in zip(LINKS, (thigh, shank, foot), strict=True):
        places.append(places[-1] + link.length * np.stack([np.sin(turn), -np.cos(turn)], axis=1))
    return np.stack(places, axis=1)


def pixels(places: Array, scale: float = 1000.0, corner: tuple[float, float] = (640.0, 120.0)) -> Array:
    """Points in a picture: x to the right, y downward, in pixels."""
    return np.stack([corner[0] + scale * places[..., 0], corner[1] - scale * places[..., 1]], axis=-1)
