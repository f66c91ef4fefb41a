"""Realistic effects that are not in the diagnosis' library; the correct verdict on them is unknown."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from synth.planting import torque_laws
from synth.planting.forms import Form, Maker, Scale, law_form, spring_torque
from synth.planting.model import Law, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


def cable(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A cable across two joints (biarticular) that only pulls, or a spring that acts in both directions."""
    n = setup.true.n
    if n == 1:
        raise NotApplicable("one joint")
    i = min(j, n - 2)
    arm = float(rng.choice([-1.0, 1.0])) * rng.uniform(0.5, 1.0)
    pulls = float(rng.integers(0, 2))
    free = float(scale.rest[i] + arm * scale.rest[i + 1]) + rng.normal(0, 0.2) * float(scale.travel[i])
    k = float(setup.true.of("spring")[i : i + 2].mean())
    return law_form(
        setup, "pulls only" if pulls else "both ways", 2.0,
        lambda s: Law(torque_laws.CABLE, i, (s * k, 1.0, arm, free, pulls), second=i + 1),
    )  # fmt: skip


def cogging(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Cogging: a torque that repeats many times per turn."""
    count, phase = float(rng.integers(12, 40)), rng.uniform(0, 2 * math.pi)
    most = 0.5 * spring_torque(setup, scale, j)
    return law_form(setup, "sine of the angle", most, lambda s: Law(torque_laws.COGGING, j, (s, count, phase)))


def fading_damper(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A damper that warms up, and so weakens, during each trial."""
    span = float(np.mean([t.duration for t in setup.trials])) * rng.uniform(0.15, 0.4)
    b = float(setup.true.of("damper")[j])
    return law_form(setup, "warms up", 0.95, lambda s: Law(torque_laws.FADING_DAMPER, j, (b, s, span)))


def creeping_spring(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The free angle creeps back after each release."""
    span = float(np.mean([t.duration for t in setup.trials])) * rng.uniform(0.2, 0.6)
    k, sign = float(setup.true.of("spring")[j]), float(rng.choice([-1.0, 1.0]))
    return law_form(setup, "creeps", 0.4, lambda s: Law(torque_laws.CREEPING_SPRING, j, (k, sign * s, span)))


def loose_spring(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A slipping clamp: the spring rate falls during each trial."""
    span = float(np.mean([t.duration for t in setup.trials])) * rng.uniform(0.2, 0.5)
    k, free = float(setup.true.of("spring")[j]), float(setup.true.of("free_angle")[j])
    return law_form(setup, "rate falls", 0.7, lambda s: Law(torque_laws.LOOSE_SPRING, j, (k, free, s, span)))


def magnet(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A magnet near the joint: a torque that repeats a few times per turn."""
    harmonic, phase = float(rng.integers(5, 9)), rng.uniform(0, 2 * math.pi)
    most = 0.6 * spring_torque(setup, scale, j)
    return law_form(setup, "few a turn", most, lambda s: Law(torque_laws.MAGNET, j, (s, harmonic, phase)))


def rub_spot(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Friction near one angle only."""
    where = float(scale.rest[j]) + rng.uniform(-0.5, 0.5) * float(scale.travel[j])
    width = float(scale.travel[j]) * rng.uniform(0.08, 0.2)
    most = 1.0 * spring_torque(setup, scale, j)
    return law_form(setup, "rubs", most, lambda s: Law(torque_laws.RUB_SPOT, j, (s, where, width)))


def knocks(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Short torque pulses, as from a cable that tugs or a machine nearby."""
    period = rng.uniform(0.25, 0.6) * float(np.mean([t.duration for t in setup.trials]))
    width = rng.uniform(0.01, 0.04)
    phase, sign = rng.uniform(0.1, 0.9) * period, float(rng.choice([-1.0, 1.0]))
    most = 2.0 * spring_torque(setup, scale, j)
    return law_form(setup, "pulses", most, lambda s: Law(torque_laws.KNOCKS, j, (sign * s, period, phase, width)))


def dropped_samples(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The recorder loses buffers unnoticed: all channels jump ahead in time."""
    span = min(t.duration for t in setup.trials)
    when = np.sort(rng.uniform(0.1, 0.7, int(rng.integers(2, 5)))) * span
    share = rng.uniform(0.5, 1.5, len(when))
    good = PlantedSensor.good(setup.true.n)
    return Form(
        "buffers lost",
        0.06,
        lambda s: (
            Truth(setup.true),
            replace(good, drops=tuple((float(t), float(s * x)) for t, x in zip(when, share, strict=True))),
        ),
        lambda s: {"lost_s": float(s * share.sum())},
    )


def cross_talk(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Cross-talk: a share of another channel is added to a reading."""
    n = setup.true.n
    if n == 1:
        raise NotApplicable("one channel")
    other = int(rng.choice([i for i in range(n) if i != j]))
    sign, good = float(rng.choice([-1.0, 1.0])), PlantedSensor.good(n)

    def talk(s: float) -> PlantedSensor:
        matrix = np.zeros((n, n))
        matrix[j, other] = sign * s
        return replace(good, talk=matrix, talk_about=setup.true.reading(scale.rest))

    return Form("of one other", 0.4, lambda s: (Truth(setup.true), talk(s)), lambda s: {"share": sign * s})


def eccentric_encoder(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """An eccentric disc or a two-pole magnet: the error of the reading is a sine of the angle."""
    harmonic, phase = float(rng.choice([2.0, 4.0, 8.0])), rng.uniform(0, 2 * math.pi)
    good = PlantedSensor.good(setup.true.n)
    return Form(
        "sine of the angle",
        math.radians(8.0),
        lambda s: (Truth(setup.true), replace(good, wobble=(j, s, harmonic, phase))),
        lambda s: {"amplitude_deg": math.degrees(s), "harmonic": harmonic},
    )


UNLISTED_EFFECTS: dict[str, Maker] = {
    "cable_coupling": cable,
    "cogging": cogging,
    "fading_damper": fading_damper,
    "creeping_spring": creeping_spring,
    "loose_spring": loose_spring,
    "magnet": magnet,
    "rub_spot": rub_spot,
    "knocks": knocks,
    "dropped_samples": dropped_samples,
    "cross_talk": cross_talk,
    "eccentric_encoder": eccentric_encoder,
}
EFFECTS_ON_ALL_CHANNELS = ("dropped_samples",)
