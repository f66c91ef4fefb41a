"""The conditions of a case before a cause is planted: designed and built leg, trials, sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from synth.planting.model import ROWS, Array, PlantedLeg, PlantedTrial

# Defaults of the key ``tolerance:`` of a project.
DEFAULT_TOLERANCE = {
    "length": 0.005,
    "mass": 0.01,
    "com": 0.01,
    "inertia": 0.02,
    "spring": 0.03,
    "damper": 0.05,
    "free_angle": math.radians(0.5),
}
WORST_TOLERANCES = 2.5  # tolerances; the normal error is truncated here, because a worse part would be rejected
SENSOR_NOISES = (0.0002, 0.001, 0.003)  # rad: a good optical encoder, a magnetic one, a camera
ENCODER_COUNTS = (2048, 4096, 8192, 16384)  # per turn, of encoders in use
LEAST_WIDTH = 1e-6  # relative (angles: rad) tolerance of an exactly known number; zero would make its column vanish
LONGEST_LAG = 0.08  # s, of a channel: four frames of a camera at 50 Hz


@dataclass(frozen=True)
class Setup:
    """A case without its effect: nominal leg, true leg within tolerance, trials, sensors.

    ``noise`` and ``counts`` may have one value per joint (n,). ``own_times`` : sample times (m,) s of each trial if it
    is not evenly sampled. ``widths`` : (7, n) or more tolerances if not the default ones. ``keeps_sensor`` : if False,
    a better sensor is chosen for a cause that this one cannot show.
    """

    nominal: PlantedLeg
    true: PlantedLeg
    trials: tuple[PlantedTrial, ...]
    ranges: bool
    noise: float | Array  # rad
    counts: float | Array  # per turn
    sampling: float  # Hz
    missing: float  # share of empty cells
    settle: float  # 1/s, the largest eigenvalue magnitude of the leg without causes
    own_times: tuple[Array, ...] | None = None
    widths: Array | None = None
    keeps_sensor: bool = False
    longest_lag: float = LONGEST_LAG

    def times(self, number: int) -> Array:
        """Nominal sample times (m,) s of a trial, from its first sample."""
        if self.own_times is not None:
            return self.own_times[number]
        return np.arange(round(self.trials[number].duration * self.sampling) + 1) / self.sampling

    def width(self, name: str, joint: int) -> float:
        """Tolerance of one parameter of the built leg, SI, at least ``LEAST_WIDTH``."""
        share = DEFAULT_TOLERANCE[name] if self.widths is None else float(self.widths[ROWS.index(name), joint])
        share = max(share, LEAST_WIDTH)
        return share if name == "free_angle" else share * max(abs(float(self.true.of(name)[joint])), 1e-12)

    @property
    def floor(self) -> float:
        """RMS of noise and rounding over all joints, rad."""
        squared = np.asarray(self.noise) ** 2 + (2 * math.pi / np.asarray(self.counts)) ** 2 / 12
        return float(np.sqrt(np.mean(squared)))

    def driven(self, joint: int) -> float:
        """Largest known torque at a joint in any trial, N m; 0 if there is none."""
        return max((trial.strongest(joint) for trial in self.trials), default=0.0)


def normal_errors(rng: np.random.Generator, n: int) -> Array:
    """(n,) normal errors in units of the tolerance, truncated at ``WORST_TOLERANCES``."""
    error = rng.standard_normal(n)
    while (np.abs(error) > WORST_TOLERANCES).any():
        error = np.where(np.abs(error) > WORST_TOLERANCES, rng.standard_normal(n), error)
    return error


def as_built(rng: np.random.Generator, leg: PlantedLeg, widths: Array | None = None) -> PlantedLeg:
    """The leg with a random error within tolerance of every number; ``widths`` (7, n), else ``DEFAULT_TOLERANCE``."""
    values = leg.values.copy()
    for row, name in enumerate(leg.rows):
        width = np.full(leg.n, DEFAULT_TOLERANCE[name]) if widths is None else widths[row]
        error = width * normal_errors(rng, leg.n)
        values[row] = values[row] + error if name == "free_angle" else values[row] * (1 + error)
    return leg.with_values(values)
