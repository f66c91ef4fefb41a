"""What is decided before a cause is planted: the leg as designed and as built, its trials, its sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from synth.planting.model import PARAMETERS, Array, PlantedLeg, PlantedTrial

# As in ``tolerance:`` where a project says nothing.
TOLERANCE = {
    "length": 0.005,
    "mass": 0.01,
    "com": 0.01,
    "inertia": 0.02,
    "spring": 0.03,
    "damper": 0.05,
    "free_angle": math.radians(0.5),
}
WORST = 2.5  # tolerances; a part further out is sent back (the normal error is cut there)
NOISE = (0.0002, 0.001, 0.003)  # rad: a good optical encoder, a magnetic one, a camera
COUNTS = (2048, 4096, 8192, 16384)  # a turn, of encoders in use
LEAST_WIDTH = 1e-6  # of a number (rad of an angle) that counts as known exactly: no column may be nothing
LONGEST_LAG = 0.08  # s, of a channel: a camera's four frames at 50 Hz


@dataclass(frozen=True)
class Setup:
    """What is decided before the effect: design, truth within tolerance, trials, sensors.

    ``noise`` rad and ``counts`` a turn may be (n,) a joint. ``own_times`` (m,) s a trial, if not evenly sampled;
    ``widths`` (7, n) tolerances, if not the usual ones; ``keeps_sensor`` : a cause too weak for it is not made visible
    by a better one.
    """

    nominal: PlantedLeg
    true: PlantedLeg
    trials: tuple[PlantedTrial, ...]
    ranges: bool
    noise: float | Array  # rad
    counts: float | Array  # a turn
    sampling: float  # Hz
    missing: float  # share of empty cells
    settle: float  # 1/s, the fastest eigenvalue of the plain leg
    own_times: tuple[Array, ...] | None = None
    widths: Array | None = None
    keeps_sensor: bool = False
    longest_lag: float = LONGEST_LAG

    def times(self, number: int) -> Array:
        """(m,) s from its start, at which a trial is read."""
        if self.own_times is not None:
            return self.own_times[number]
        return np.arange(round(self.trials[number].duration * self.sampling) + 1) / self.sampling

    def width(self, name: str, joint: int) -> float:
        """One tolerance of a number of the leg as built, SI."""
        share = TOLERANCE[name] if self.widths is None else float(self.widths[PARAMETERS.index(name), joint])
        share = max(share, LEAST_WIDTH)
        return share if name == "free_angle" else share * max(abs(float(self.true.of(name)[joint])), 1e-12)

    @property
    def floor(self) -> float:
        """Rad RMS of what the sensors leave, all joints alike."""
        squared = np.asarray(self.noise) ** 2 + (2 * math.pi / np.asarray(self.counts)) ** 2 / 12
        return float(np.sqrt(np.mean(squared)))

    def driven(self, joint: int) -> float:
        """N m, the largest known torque at a joint in any trial; 0 where there is none."""
        return max((trial.strongest(joint) for trial in self.trials), default=0.0)


def normal_errors(rng: np.random.Generator, n: int) -> Array:
    """(n,) normal errors in tolerances, none beyond ``WORST``."""
    error = rng.standard_normal(n)
    while (np.abs(error) > WORST).any():
        error = np.where(np.abs(error) > WORST, rng.standard_normal(n), error)
    return error


def as_built(rng: np.random.Generator, leg: PlantedLeg, widths: Array | None = None) -> PlantedLeg:
    """The leg with every number off by its tolerance's normal error; ``widths`` (7, n), else the usual ones."""
    values = leg.values.copy()
    for row, name in enumerate(PARAMETERS):
        width = np.full(leg.n, TOLERANCE[name]) if widths is None else widths[row]
        error = width * normal_errors(rng, leg.n)
        values[row] = values[row] + error if name == "free_angle" else values[row] * (1 + error)
    return leg.with_values(values)
