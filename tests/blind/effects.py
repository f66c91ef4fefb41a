"""Every effect of the leg in other forms than the diagnosing program's, each with one size to be found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from blind import engine, laws
from blind.legs import Setup
from blind.model import Array, Base, Bend, Law, Truth
from blind.sensors import Sensor


class Unfit(Exception):
    """This leg, joint or trial set cannot show the effect."""


class Scale(NamedTuple):
    """How far and fast each joint goes in the given trials of the leg without the effect; (n,) each."""

    travel: Array  # rad, largest distance from rest at release
    speed: Array  # rad/s, largest
    low: Array  # rad, smallest and largest rotation
    high: Array
    rest: Array  # rad, at the end of a plain release
    slow: float  # 1/s, lowest natural frequency


@dataclass(frozen=True)
class Form:
    """One effect at one joint in one form; ``build(size)`` gives the leg and the sensors, ``tell`` its parameters."""

    name: str
    largest: float
    build: Callable[[float], tuple[Truth, Sensor]]
    tell: Callable[[float], dict[str, float | str]]
    fixed_noise: bool = False


Maker = Callable[[np.random.Generator, Setup, Scale, int], Form]


def _law(setup: Setup, name: str, largest: float, law: Callable[[float], Law], **shape: float) -> Form:
    """A form that is one law at a joint."""
    good = Sensor.good(setup.true.n)
    return Form(
        name,
        largest,
        lambda s: (Truth(setup.true, (law(s),)), good),
        lambda s: {f"p{i}": float(v) for i, v in enumerate(law(s).par)} | shape,
    )


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _torque(setup: Setup, scale: Scale, j: int) -> float:
    """N m, what the spring exerts over the joint's travel."""
    return float(setup.true.of("spring")[j] * scale.travel[j])


def coulomb(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """True sticking, or bristles."""
    most = 0.4 * _torque(setup, scale, j)
    if rng.random() < 0.5:
        return _law(setup, "stick-slip", most, lambda s: Law(laws.STICK_SLIP, j, (s, s, 1.0, 0.0)))
    deflection = _between(rng, 2e-4, 3e-3)
    micro = rng.uniform(0.0, 0.3) * setup.true.of("damper")[j]
    return _law(setup, "bristles", most, lambda s: Law(laws.BRISTLES, j, (s, s, 1.0, 0.0, deflection, micro)))


def stribeck(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Friction that falls as 1 / (1 + (w/ws)^2) or exp(-|w|/ws)."""
    most = 0.5 * _torque(setup, scale, j)
    weak, speed = rng.uniform(0.25, 0.6), rng.uniform(0.06, 0.3) * scale.speed[j]
    shape = float(rng.integers(0, 2))
    name = ("rational", "exponential")[int(shape)]
    if rng.random() < 0.5:
        law = laws.STICK_SLIP
        return _law(setup, f"stick-slip, {name}", most, lambda s: Law(law, j, (weak * s, s, speed, shape)))
    deflection = _between(rng, 2e-4, 2e-3)
    return _law(
        setup,
        f"bristles, {name}",
        most,
        lambda s: Law(laws.BRISTLES, j, (weak * s, s, speed, shape, deflection, 0.0)),
    )


def load_friction(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Plain bearing that truly sticks, or a mesh's bristles on the spring's torque."""
    if rng.random() < 0.5:
        weight = 9.81 * float(setup.true.of("mass")[j:].sum())
        most = min(0.5 * _torque(setup, scale, j) / weight, 0.25 * float(setup.true.of("length").mean()))
        return _law(setup, "bearing, sticking", most, lambda s: Law(laws.BEARING, j, (s, 0.0)))
    k, free = float(setup.true.of("spring")[j]), float(setup.true.of("free_angle")[j])
    deflection = _between(rng, 2e-4, 2e-3)
    return _law(setup, "mesh, bristles", 0.5, lambda s: Law(laws.MESH, j, (s, k, free, 0.0, deflection)))


def thinning(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Cross fluid, or a power law above a plateau."""
    b, top = float(setup.true.of("damper")[j]), float(scale.speed[j])
    if rng.random() < 0.5:
        m = rng.uniform(0.6, 1.3)
        return _law(setup, "Cross", 40.0, lambda s: Law(laws.CROSS, j, (b, top / s, m)))
    n = rng.uniform(0.25, 0.7)
    return _law(setup, "power law over plateau", 100.0, lambda s: Law(laws.PLATEAU, j, (b, top / s, n)))


def drag(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Square and cube together, or Eyring's sinh."""
    top = float(scale.speed[j])
    most = 2.0 * setup.true.outboard(j) * scale.slow + 2.0 * float(setup.true.of("damper")[j])  # torque per speed
    if rng.random() < 0.5:
        cube = rng.uniform(0.3, 1.0)
        return _law(
            setup,
            "square and cube",
            most,
            lambda s: Law(laws.DRAG, j, ((1 - cube) * s / top, cube * s / top**2)),
        )
    bend = rng.uniform(0.25, 0.5) * top
    size = bend * (math.sinh(top / bend) - top / bend)
    return _law(setup, "Eyring", most, lambda s: Law(laws.EYRING, j, (s * top / size, bend)))


def hardening(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Tanh (softening), quintic, sinh, or piecewise stiffness; sized by the torque it adds at the largest deflection."""
    k, free = float(setup.true.of("spring")[j]), float(setup.true.of("free_angle")[j])
    reach = max(abs(float(scale.low[j]) - free), abs(float(scale.high[j]) - free))
    kind = int(rng.integers(0, 4))
    if kind == 0:
        return _law(
            setup, "tanh, softening", 4.0, lambda s: Law(laws.TANH_SPRING, j, (k, free, reach / s)), reach=reach
        )
    if kind == 1:
        sign = float(rng.choice([-1.0, 1.0, 1.0]))
        most = 0.6 if sign > 0 else 0.15
        return _law(
            setup, "quintic", most, lambda s: Law(laws.QUINTIC_SPRING, j, (sign * s * k / reach**4, free)), reach=reach
        )
    if kind == 2:
        return _law(setup, "sinh", 3.0, lambda s: Law(laws.SINH_SPRING, j, (k, free, reach / s)), reach=reach)
    knee = rng.uniform(0.3, 0.65) * reach
    return _law(setup, "piecewise", 2.0, lambda s: Law(laws.PIECEWISE_SPRING, j, (s * k, free, knee)), reach=reach)


def one_sided(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A soft changeover, or one a little beside the free angle; weaker or stiffer on one side."""
    k, free = float(setup.true.of("spring")[j]), float(setup.true.of("free_angle")[j])
    low, high = float(scale.low[j]) - free, float(scale.high[j]) - free
    if low > -0.2 * (high - low) or high < 0.2 * (high - low):
        raise Unfit("the joint stays on one side of its spring")
    sign = float(rng.choice([-1.0, -1.0, 1.0]))
    most = 0.98 if sign < 0 else 1.5
    side = float(rng.choice([-1.0, 1.0]))
    # the law acts for u > 0; its mirror is the same with the whole rate changed and the law's sign turned
    if rng.random() < 0.5:
        width = math.radians(rng.uniform(0.5, 2.5))

        def soft(s: float) -> Law:
            return Law(laws.SOFT_ONE_SIDED, j, (sign * s * k * side, free, width))

        return _mirrored(setup, "soft changeover", most, soft, j, side, sign)
    shift = math.radians(rng.uniform(-1.5, 1.5))

    def sharp(s: float) -> Law:
        return Law(laws.SHIFTED_ONE_SIDED, j, (sign * s * k * side, free, shift))

    return _mirrored(setup, "sharp, beside the free angle", most, sharp, j, side, sign)


def _mirrored(
    setup: Setup, name: str, most: float, law: Callable[[float], Law], j: int, side: float, sign: float
) -> Form:
    """A change on the positive side, or (side -1) on the negative one: the whole rate changed, the other side back."""
    good = Sensor.good(setup.true.n)
    k = float(setup.true.of("spring")[j])

    def build(s: float) -> tuple[Truth, Sensor]:
        leg = setup.true if side > 0 else setup.true.changed("spring", j, k * (1 + sign * s))
        return Truth(leg, (law(s),)), good

    return Form(name, most, build, lambda s: {"rate_change": sign * s * k, "side": side, "width": law(s).par[2]})


def hysteresis(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Bouc-Wen with a rounded knee, or two Maxwell branches."""
    k, travel = float(setup.true.of("spring")[j]), float(scale.travel[j])
    if rng.random() < 0.5:
        delta, power, share = travel * rng.uniform(0.1, 0.4), rng.uniform(1.5, 3.0), rng.uniform(0.2, 0.6)
        return _law(setup, "Bouc-Wen", 0.8, lambda s: Law(laws.BOUC_WEN, j, (s * k, delta, power, share)))
    tau, ratio, second = rng.uniform(0.5, 2.5) / scale.slow, rng.uniform(4, 8), rng.uniform(0.5, 1.0)
    return _law(
        setup, "two Maxwell", 0.8, lambda s: Law(laws.TWO_MAXWELL, j, (s * k, tau, second * s * k, tau / ratio))
    )


def backlash(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A massless arm that leaves its flank, or one of small inertia between Hunt-Crossley flanks."""
    k, b, free = (float(setup.true.of(name)[j]) for name in ("spring", "damper", "free_angle"))
    good = Sensor.good(setup.true.n)
    most = min(math.radians(4.0), 0.4 * float(scale.travel[j]))
    if rng.random() < 0.6:
        name, law = "contact lost", lambda s: Law(laws.SLACK, j, (k, free, s, b))
    else:
        arm, loss = rng.uniform(0.01, 0.03) * setup.true.outboard(j), rng.uniform(0.1, 0.6) / float(scale.speed[j])
        flank = 2000.0 * k
        name, law = "arm and flanks", lambda s: Law(laws.SLACK_ARM, j, (k, free, s, b, arm, flank, loss))
    return Form(
        name,
        most,
        lambda s: (Truth(setup.true, (law(s),), bare=(j,)), good),
        lambda s: {"half_gap_deg": math.degrees(s)},
    )


def preload(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The free angle shifted."""
    good, sign = Sensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    free = float(setup.true.of("free_angle")[j])
    return Form(
        "free angle shifted",
        math.radians(18.0),
        lambda s: (Truth(setup.true.changed("free_angle", j, free + sign * s)), good),
        lambda s: {"shift_deg": math.degrees(sign * s * float(setup.true.sign[j]))},
    )


def link_mass(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Mass and inertia in proportion."""
    good, sign = Sensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
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
    """Centre of mass off, inertia off, or both as when a part of the mass sits elsewhere."""
    good, sign = Sensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    mass, com, inertia = (float(setup.true.of(name)[j]) for name in ("mass", "com", "inertia"))
    kind = ("com", "inertia", "moved part")[int(rng.choice(3, p=[0.4, 0.2, 0.4]))]
    place = rng.uniform(0.0, 0.2) if sign < 0 else rng.uniform(0.8, 1.0)
    length = float(setup.true.of("length")[j])

    def build(s: float) -> tuple[Truth, Sensor]:
        if kind == "com":
            return Truth(setup.true.changed("com", j, com * (1 + sign * s))), good
        if kind == "inertia":
            return Truth(setup.true.changed("inertia", j, inertia * (1 + (sign if s < 1 else 1.0) * s))), good
        centre = (1 - s) * com + s * place * length  # a share s of the mass gathered at one place
        spread = (1 - s) * (inertia + mass * (com - centre) ** 2) + s * mass * (place * length - centre) ** 2
        return Truth(setup.true.changed("com", j, centre).changed("inertia", j, spread)), good

    most = {"com": 0.35, "inertia": 2.0 if sign > 0 else 0.7, "moved part": 0.5}[kind]
    return Form(
        kind,
        most,
        build,
        lambda s: {
            "com_ratio": float(build(s)[0].leg.of("com")[j] / com),
            "inertia_ratio": float(build(s)[0].leg.of("inertia")[j] / inertia),
        },
    )


def _sensor(setup: Setup, name: str, most: float, change: Callable[[float], dict[str, Array]], unit: str) -> Form:
    good = Sensor.good(setup.true.n)
    return Form(
        name,
        most,
        lambda s: (Truth(setup.true), replace(good, **change(s))),
        lambda s: {unit: float(next(v for v in (np.asarray(x).sum() for x in change(s).values())))},
    )


def _one(n: int, j: int, value: float) -> Array:
    vector = np.zeros(n)
    vector[j] = value
    return vector


def encoder_offset(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The reading shifted."""
    sign, n = float(rng.choice([-1.0, 1.0])), setup.true.n
    return _sensor(setup, "shift", math.radians(12.0), lambda s: {"offset": _one(n, j, sign * s)}, "offset_rad")


def encoder_scale(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The reading scaled about 0 deg."""
    sign, n = float(rng.choice([-1.0, 1.0])), setup.true.n
    return _sensor(setup, "scaled", 0.25, lambda s: {"scale": _one(n, j, sign * s)}, "scale_error")


def quantisation(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Coarse counts, a whole number of them a turn."""
    n = setup.true.n

    def change(s: float) -> dict[str, Array]:
        return {"width": _one(n, j, 2 * math.pi / max(round(2 * math.pi / s), 1))}

    return _sensor(setup, "rounded", 2 * math.pi / 90, change, "count_rad")


def latency(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A pure delay of any length, or a first-order lag."""
    n = setup.true.n
    if n == 1:
        raise Unfit("one channel alone: late against nothing")
    if rng.random() < 0.6:
        return _sensor(setup, "delay", 0.08, lambda s: {"latency": _one(n, j, s)}, "delay_s")
    return _sensor(setup, "first-order lag", 0.06, lambda s: {"lag": _one(n, j, s)}, "lag_s")


def joint_stop(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Hunt-Crossley or rubber, on the side to which the leg swings; sized by how far it reaches into the motion."""
    inside = [t.pose[j] for t in setup.trials if j not in t.locked]
    side = 1.0 if np.mean(inside) < scale.rest[j] else -1.0
    nearest = max(side * x for x in inside)  # releases lie on the free side
    end = float(scale.high[j]) if side > 0 else -float(scale.low[j])
    room = end - max(nearest, side * float(scale.rest[j]) - 0.3 * float(scale.travel[j])) - math.radians(0.5)
    if room < math.radians(0.5):
        raise Unfit("the joint does not swing beyond where it is released")
    k, top = float(setup.true.of("spring")[j]), float(scale.speed[j])
    stiff = k * _between(rng, 5, 40)
    good = Sensor.good(setup.true.n)
    if rng.random() < 0.5:
        power, loss = rng.uniform(1.2, 1.6), rng.uniform(0.05, 0.5) / top
        rate = stiff / math.radians(2.0) ** (power - 1)
        name, shape = "Hunt-Crossley", (power, loss)
        law = laws.HUNT_CROSSLEY
    else:
        damping = float(setup.true.of("damper")[j]) * rng.uniform(0.3, 2.0)
        name, shape, law, rate = "rubber", (math.radians(rng.uniform(1.0, 4.0)), damping), laws.RUBBER_STOP, stiff
    return Form(
        name,
        room,
        lambda s: (Truth(setup.true, (Law(law, j, (rate, side * (end - s), side, *shape)),)), good),
        lambda s: {"stop_rad": side * (end - s), "side": side, "stiffness": rate},
    )


def base_compliance(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A mount that slides and rocks, or rocks with a drag for damping; sized by its compliance."""
    leg = setup.true
    whole, reach = float(leg.of("mass").sum()), float(leg.of("length").sum())
    mass, arm = whole * rng.uniform(0.5, 2.5), -reach * rng.uniform(0.5, 1.5)  # the pivot lies below the hip
    inertia, ratio = mass * arm**2, rng.uniform(0.02, 0.15)
    carried = (mass + whole) * arm**2
    good = Sensor.good(leg.n)
    both, share = rng.random() < 0.6, rng.uniform(0.3, 0.7)

    def build(s: float) -> tuple[Truth, Sensor]:
        omega = scale.slow / math.sqrt(s)
        rock = (engine.HINGE, 0.0, arm, 0.0, inertia, carried * omega**2 / (1 - share if both else 1.0))
        if both:
            push = (mass + whole) * omega**2 / share
            slide = (engine.SLIDE, 0.0, 0.0, 0.3 * mass, 0.0, push, 2 * ratio * math.sqrt(push * (mass + whole)))
            bodies: tuple[tuple[float, ...], ...] = (slide, (*rock, 2 * ratio * math.sqrt(rock[5] * carried)))
            return Truth(leg, base=Base(bodies)), good
        swing = math.radians(0.5) * omega  # speed at which the drag equals the ratio's linear damping
        law = Law(laws.DRAG, 0, (2 * ratio * carried * omega / swing, 0.0), base=True)
        return Truth(leg, (law,), base=Base(((*rock, 0.1 * ratio * carried * omega),))), good

    return Form(
        "slides and rocks" if both else "rocks, with drag",
        0.25,
        build,
        lambda s: {"natural_hz": scale.slow / math.sqrt(s) / 2 / math.pi, "mass": mass, "arm": arm},
    )


def base_tilt(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The mount turned."""
    sign, good = float(rng.choice([-1.0, 1.0])), Sensor.good(setup.true.n)
    return Form(
        "turned",
        math.radians(12.0),
        lambda s: (Truth(setup.true, tilt=sign * s), good),
        lambda s: {"tilt_deg": math.degrees(sign * s)},
    )


def link_flexibility(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Two or three hinges along the link, or a cantilever's one and a softer end."""
    leg, good = setup.true, Sensor.good(setup.true.n)
    kind = int(rng.integers(0, 3))
    shares = ((0.25, 0.75), (1 / 6, 0.5, 5 / 6), (0.15, 0.6))[kind]
    weights = ((1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 2.5))[kind]
    ratio, k = rng.uniform(0.02, 0.1), max(float(leg.of("spring")[j]), leg.outboard(j) * scale.slow**2)

    def build(s: float) -> tuple[Truth, Sensor]:
        rates = tuple(k / s * w * len(shares) for w in weights)
        dampings = tuple(2 * ratio * math.sqrt(r * leg.outboard(j)) for r in rates)
        return Truth(leg, bends=(Bend(j, shares, rates, dampings),)), good

    name = ("two hinges", "three hinges", "cantilever")[kind]
    return Form(name, 0.6, build, lambda s: {"compliance_over_spring": s, "rate": k / s})


EFFECTS: dict[str, Maker] = {
    "coulomb_friction": coulomb,
    "stribeck_friction": stribeck,
    "load_friction": load_friction,
    "shear_thinning_damping": thinning,
    "quadratic_damping": drag,
    "hardening_spring": hardening,
    "one_sided_spring": one_sided,
    "spring_hysteresis": hysteresis,
    "backlash": backlash,
    "spring_preload": preload,
    "link_mass": link_mass,
    "link_inertia": link_inertia,
    "encoder_offset": encoder_offset,
    "encoder_scale": encoder_scale,
    "encoder_quantisation": quantisation,
    "latency": latency,
    "joint_stop": joint_stop,
    "base_compliance": base_compliance,
    "base_tilt": base_tilt,
    "link_flexibility": link_flexibility,
}
AT_BASE = ("base_compliance", "base_tilt")
