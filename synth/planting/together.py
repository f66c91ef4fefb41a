"""Several causes in one leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.planting.forms import Unfit
from synth.planting.ground import PlantedCause
from synth.planting.model import Truth
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


def together(setup: Setup, causes: Sequence[PlantedCause]) -> tuple[Truth, PlantedSensor]:
    """All causes at once; changes of the leg and of the sensors add up."""
    truth, sensor = Truth(setup.true), PlantedSensor.good(setup.true.n)
    for cause in causes:
        t, s = cause.form.build(cause.size)
        if t.base is not None and truth.base is not None:
            raise Unfit("two mounts")
        leg = truth.leg
        if t.leg is not setup.true:
            leg = replace(leg, values=leg.values + t.leg.values - setup.true.values)
        truth = Truth(
            leg,
            truth.laws + t.laws,
            truth.base or t.base,
            truth.bends + t.bends,
            truth.tilt + t.tilt,
            truth.bare + t.bare,
            truth.rotors + t.rotors,
            (truth.drive[0] + t.drive[0], truth.drive[1] + t.drive[1], truth.drive[2] + t.drive[2]),
            max(truth.drive_joint, t.drive_joint),
        )
        sensor = PlantedSensor(
            sensor.offset + s.offset,
            sensor.scale + s.scale,
            np.maximum(sensor.width, s.width),
            sensor.latency + s.latency,
            sensor.lag + s.lag,
            sensor.talk + s.talk,
            sensor.talk_about + s.talk_about,
            s.wobble or sensor.wobble,
            sensor.drops + s.drops,
        )
    return truth, sensor
