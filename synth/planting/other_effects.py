"""Effects of parameters, sensors, stops, the mount and bending links."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from synth.planting import bodies, torque_laws
from synth.planting.forms import Form, Scale, log_uniform, spring_rate_of, spring_torque
from synth.planting.model import Array, Base, Bend, Law, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


def preload(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A shifted free angle."""
    good, sign = PlantedSensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    spring_rate_of(setup, j)
    free = float(setup.true.of("free_angle")[j])
    return Form(
        "free angle shifted",
        math.radians(18.0),
        lambda s: (Truth(setup.true.changed("free_angle", j, free + sign * s)), good),
        lambda s: {"shift_deg": math.degrees(sign * s * float(setup.true.sign[j]))},
    )


def link_mass(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another link mass, with its inertia in proportion."""
    good, sign = PlantedSensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    mass, inertia = float(setup.true.of("mass")[j]), float(setup.true.of("inertia")[j])
    return Form(
        "in proportion",
        0.4 if sign < 0 else 0.8,
        lambda s: (
            Truth(setup.true.changed("mass", j, mass * (1 + sign * s)).changed("inertia", j, inertia * (1 + sign * s))),
            good,
        ),
        lambda s: {"ratio": 1 + sign * s},
    )


def link_inertia(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another centre of mass, along the link or beside it, another inertia, or a share of the mass elsewhere."""
    good, sign = PlantedSensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    mass, com, inertia = (float(setup.true.of(name)[j]) for name in ("mass", "com", "inertia"))
    kind = ("com", "inertia", "moved part", "beside")[int(rng.choice(4, p=[0.35, 0.2, 0.3, 0.15]))]
    place = rng.uniform(0.0, 0.2) if sign < 0 else rng.uniform(0.8, 1.0)
    length = float(setup.true.of("length")[j])

    def build(s: float) -> tuple[Truth, PlantedSensor]:
        if kind == "com":
            return Truth(setup.true.changed("com", j, com * (1 + sign * s))), good
        if kind == "beside":
            return Truth(setup.true.moved_across(j, sign * s * length)), good
        if kind == "inertia":
            return Truth(setup.true.changed("inertia", j, inertia * (1 + (sign if s < 1 else 1.0) * s))), good
        centre = (1 - s) * com + s * place * length  # a share s of the mass is at ``place``
        spread = (1 - s) * (inertia + mass * (com - centre) ** 2) + s * mass * (place * length - centre) ** 2
        return Truth(setup.true.changed("com", j, centre).changed("inertia", j, spread)), good

    most = {"com": 0.35, "inertia": 2.0 if sign > 0 else 0.7, "moved part": 0.5, "beside": 0.25}[kind]
    return Form(
        kind,
        most,
        build,
        lambda s: {
            "com_ratio": float(build(s)[0].leg.of("com")[j] / com),
            "inertia_ratio": float(build(s)[0].leg.of("inertia")[j] / inertia),
            "across_over_com": sign * s * length / com if kind == "beside" else 0.0,
        },
    )


def _sensor_form(setup: Setup, name: str, most: float, change: Callable[[float], dict[str, Array]], unit: str) -> Form:
    good = PlantedSensor.good(setup.true.n)
    return Form(
        name,
        most,
        lambda s: (Truth(setup.true), replace(good, **change(s))),  # type: ignore[arg-type]
        lambda s: {unit: float(next(v for v in (np.asarray(x).sum() for x in change(s).values())))},
    )


def _vector_at(n: int, j: int, value: float) -> Array:
    vector = np.zeros(n)
    vector[j] = value
    return vector


def encoder_offset(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """An offset of the reading, which the joint's servo may control."""
    sign, n = float(rng.choice([-1.0, 1.0])), setup.true.n
    form = _sensor_form(
        setup, "shift", math.radians(12.0), lambda s: {"offset": _vector_at(n, j, sign * s)}, "offset_rad"
    )
    return _perhaps_controlled(rng, setup, j, form)


def encoder_scale(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A scale error of the reading about 0 deg, which the joint's servo may control."""
    sign, n = float(rng.choice([-1.0, 1.0])), setup.true.n
    form = _sensor_form(setup, "scaled", 0.25, lambda s: {"scale": _vector_at(n, j, sign * s)}, "scale_error")
    return _perhaps_controlled(rng, setup, j, form)


def _perhaps_controlled(rng: np.random.Generator, setup: Setup, j: int, form: Form) -> Form:
    """The form, or, of a joint with a servo in one of two cases, the same with a servo that controls this reading."""
    servo = any(each.joint == j and each.gain > 0.0 for each in setup.true.servos)
    if not servo or rng.random() < 0.5:
        return form

    def build(size: float) -> tuple[Truth, PlantedSensor]:
        truth, sensor = form.build(size)
        scale, offset = float(sensor.scale[j]), float(sensor.offset[j])
        seen = (
            (j, "seen_scale", scale),
            (j, "seen_offset", float(setup.true.sign[j]) * (scale * float(setup.true.zero[j]) + offset)),
        )
        return replace(truth, servo_errors=(*truth.servo_errors, *seen)), sensor

    return replace(form, name=f"{form.name}, controlled", build=build)


def quantisation(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Coarse counts, an integer number per turn."""
    n = setup.true.n

    def change(s: float) -> dict[str, Array]:
        return {"width": _vector_at(n, j, 2 * math.pi / max(round(2 * math.pi / s), 1))}

    return _sensor_form(setup, "rounded", 2 * math.pi / 90, change, "count_rad")


def latency(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A pure delay, or a first-order lag."""
    n = setup.true.n
    if n == 1:
        raise NotApplicable("a single channel has no other to be late against")
    if rng.random() < 0.6:  # delays are the more frequent of the two
        return _sensor_form(setup, "delay", setup.longest_lag, lambda s: {"latency": _vector_at(n, j, s)}, "delay_s")
    return _sensor_form(
        setup, "first-order lag", 0.75 * setup.longest_lag, lambda s: {"lag": _vector_at(n, j, s)}, "lag_s"
    )


def joint_stop(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A Hunt-Crossley or rubber stop on the side to which the leg swings; the size is how far it limits the motion."""
    inside = [t.pose[j] for t in setup.trials if j not in t.locked]
    side = 1.0 if np.mean(inside) < scale.rest[j] else -1.0
    nearest = max(side * x for x in inside)  # all releases are on the free side
    end = float(scale.high[j]) if side > 0 else -float(scale.low[j])
    # The stop acts in at most 30 % of the travel; half a degree clear of every release.
    room = end - max(nearest, side * float(scale.rest[j]) - 0.3 * float(scale.travel[j])) - math.radians(0.5)
    if room < math.radians(0.5):
        raise NotApplicable("the joint does not swing beyond its release")
    k, top = float(setup.true.of("spring")[j]), float(scale.speed[j])
    k = k if k > 0.0 else spring_torque(setup, scale, j) / float(scale.travel[j])
    stiff = k * log_uniform(rng, 5, 40)
    good = PlantedSensor.good(setup.true.n)
    if rng.random() < 0.5:
        power, loss = rng.uniform(1.2, 1.6), rng.uniform(0.05, 0.5) / top
        rate = stiff / math.radians(2.0) ** (power - 1)
        name, shape = "Hunt-Crossley", (power, loss)
        law = torque_laws.HUNT_CROSSLEY
    else:
        damping = float(setup.true.of("damper")[j]) * rng.uniform(0.3, 2.0)
        name, shape, law, rate = (
            "rubber",
            (math.radians(rng.uniform(1.0, 4.0)), damping),
            torque_laws.RUBBER_STOP,
            stiff,
        )
    return Form(
        name,
        room,
        lambda s: (Truth(setup.true, (Law(law, j, (rate, side * (end - s), side, *shape)),)), good),
        lambda s: {"stop_rad": side * (end - s), "side": side, "stiffness": rate},
    )


def base_compliance(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A mount that slides and rocks, or one that rocks with quadratic damping; the size is its compliance."""
    leg = setup.true
    whole, reach = float(leg.of("mass").sum()), float(leg.of("length").sum())
    mass, arm = whole * rng.uniform(0.5, 2.5), -reach * rng.uniform(0.5, 1.5)  # the pivot is below the hip
    inertia, ratio = mass * arm**2, rng.uniform(0.02, 0.15)
    carried = (mass + whole) * arm**2
    good = PlantedSensor.good(leg.n)
    both, share = rng.random() < 0.6, rng.uniform(0.3, 0.7)

    def build(s: float) -> tuple[Truth, PlantedSensor]:
        omega = scale.slow / math.sqrt(s)
        rock = (bodies.HINGE, 0.0, arm, 0.0, inertia, carried * omega**2 / (1 - share if both else 1.0))
        if both:
            push = (mass + whole) * omega**2 / share
            slide = (bodies.SLIDE, 0.0, 0.0, 0.3 * mass, 0.0, push, 2 * ratio * math.sqrt(push * (mass + whole)))
            parts: tuple[tuple[float, ...], ...] = (slide, (*rock, 2 * ratio * math.sqrt(rock[5] * carried)))
            return Truth(leg, base=Base(parts)), good
        swing = math.radians(0.5) * omega  # speed at which the drag equals the ratio's linear damping
        law = Law(torque_laws.DRAG, 0, (2 * ratio * carried * omega / swing, 0.0), base=True)
        return Truth(leg, (law,), base=Base(((*rock, 0.1 * ratio * carried * omega),))), good

    return Form(
        "slides and rocks" if both else "rocks, with drag",
        0.25,
        build,
        lambda s: {"natural_hz": scale.slow / math.sqrt(s) / 2 / math.pi, "mass": mass, "arm": arm},
    )


def base_tilt(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A tilted mount."""
    sign, good = float(rng.choice([-1.0, 1.0])), PlantedSensor.good(setup.true.n)
    return Form(
        "turned",
        math.radians(12.0),
        lambda s: (Truth(setup.true, tilt=sign * s), good),
        lambda s: {"tilt_deg": math.degrees(sign * s)},
    )


def link_flexibility(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A bending link: two or three hinges along it, or the hinge of a cantilever and a softer end."""
    leg, good = setup.true, PlantedSensor.good(setup.true.n)
    kind = int(rng.integers(0, 3))
    shares = ((0.25, 0.75), (1 / 6, 0.5, 5 / 6), (0.15, 0.6))[kind]
    weights = ((1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 2.5))[kind]
    ratio, k = rng.uniform(0.02, 0.1), max(float(leg.of("spring")[j]), leg.outboard(j) * scale.slow**2)

    def build(s: float) -> tuple[Truth, PlantedSensor]:
        rates = tuple(k / s * w * len(shares) for w in weights)
        dampings = tuple(2 * ratio * math.sqrt(r * leg.outboard(j)) for r in rates)
        return Truth(leg, bends=(Bend(j, shares, rates, dampings),)), good

    name = ("two hinges", "three hinges", "cantilever")[kind]
    return Form(name, 0.6, build, lambda s: {"compliance_over_spring": s, "rate": k / s})
