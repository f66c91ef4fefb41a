"""Steps and sweeps of a joint that a servo with a motor drives, read with noise."""

from __future__ import annotations

import numpy as np

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

MOTOR = GearedMotor(3.4, 0.0072, 50.0, 0.8, 7e-7)
ARM = Leg(
    "arm", (Joint("knee", Link(0.12, 0.3, 0.1, 6e-4), drive=Servo(1.15, supply=7.4, current_limit=1.5, motor=MOTOR)),)
)
NOISE = np.radians(0.03)
TIME = np.arange(0.0, 2.5, 0.005)


def driven(leg: Leg, trials: int = 2, seed: int = 100) -> list[Trial]:
    """Alternately steps up to 35 degrees and sums of three sinusoids of 15."""
    made = []
    for k in range(trials):
        rng = np.random.default_rng(seed + k)
        if k % 2 == 0:
            command = np.radians(35.0) * rng.uniform(-1.0, 1.0, 12)[np.minimum((TIME / 0.4).astype(int), 11)]
        else:
            waves = zip(rng.uniform(0.4, 2.2, 3), rng.uniform(0.0, 6.28, 3), strict=True)
            command = np.radians(15.0) * sum(np.sin(2.0 * np.pi * f * TIME + p) for f, p in waves)
        ones = np.ones((len(TIME), 1))
        signals = ServoSignals(TIME, command[:, None], 7.4 * ones, ones, held=(0,))
        motion = simulate(leg, command[:1], np.zeros(1), TIME, signals=signals)
        angles = leg.to_measured(motion) + NOISE * rng.standard_normal((len(TIME), 1))
        made.append(Trial(f"{k}.csv", TIME, angles, signals=signals))
    return made
