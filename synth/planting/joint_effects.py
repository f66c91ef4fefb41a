"""Effects at a joint: friction, dampers and springs, in forms that the diagnosing program does not use."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from synth.planting import torque_laws
from synth.planting.forms import Form, Scale, law_form, log_uniform, spring_rate_of, spring_torque
from synth.planting.model import Law, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


def coulomb(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Dry friction: a rigid constraint while sticking, or LuGre bristles."""
    most = 0.4 * spring_torque(setup, scale, j)
    if rng.random() < 0.5:
        return law_form(setup, "stick-slip", most, lambda s: Law(torque_laws.STICK_SLIP, j, (s, s, 1.0, 0.0)))
    deflection = log_uniform(rng, 2e-4, 3e-3)
    micro = rng.uniform(0.0, 0.3) * setup.true.of("damper")[j]
    return law_form(
        setup, "bristles", most, lambda s: Law(torque_laws.BRISTLES, j, (s, s, 1.0, 0.0, deflection, micro))
    )


def stribeck(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Friction that falls as 1 / (1 + (w/ws)^2) or exp(-|w|/ws)."""
    most = 0.5 * spring_torque(setup, scale, j)
    weak, speed = rng.uniform(0.25, 0.6), rng.uniform(0.06, 0.3) * scale.speed[j]
    shape = float(rng.integers(0, 2))
    name = ("rational", "exponential")[int(shape)]
    if rng.random() < 0.5:
        law = torque_laws.STICK_SLIP
        return law_form(setup, f"stick-slip, {name}", most, lambda s: Law(law, j, (weak * s, s, speed, shape)))
    deflection = log_uniform(rng, 2e-4, 2e-3)
    return law_form(
        setup,
        f"bristles, {name}",
        most,
        lambda s: Law(torque_laws.BRISTLES, j, (weak * s, s, speed, shape, deflection, 0.0)),
    )


def load_friction(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A plain bearing that sticks rigidly, or a gear mesh with bristle friction on the spring's torque."""
    if rng.random() < 0.5:
        weight = setup.true.gravity * float(setup.true.of("mass")[j:].sum())
        # A journal's radius: at most a quarter of a link's length.
        most = 0.25 * float(setup.true.of("length").mean())
        most = min(0.5 * spring_torque(setup, scale, j) / weight, most) if weight > 0.0 else most
        return law_form(setup, "bearing, sticking", most, lambda s: Law(torque_laws.BEARING, j, (s, 0.0)))
    k, free = spring_rate_of(setup, j), float(setup.true.of("free_angle")[j])
    deflection = log_uniform(rng, 2e-4, 2e-3)
    return law_form(
        setup, "mesh, bristles", 0.5, lambda s: Law(torque_laws.GEAR_MESH, j, (s, k, free, 0.0, deflection))
    )


def thinning(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A shear-thinning damper: Cross fluid, or a power law above a plateau."""
    b, top = float(setup.true.of("damper")[j]), float(scale.speed[j])
    if b <= 0.0:
        raise NotApplicable("the joint has no damper")
    if rng.random() < 0.5:
        m = rng.uniform(0.6, 1.3)
        return law_form(setup, "Cross", 40.0, lambda s: Law(torque_laws.CROSS, j, (b, top / s, m)))
    n = rng.uniform(0.25, 0.7)
    return law_form(setup, "power law over plateau", 100.0, lambda s: Law(torque_laws.PLATEAU, j, (b, top / s, n)))


def drag(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Drag: a quadratic and a cubic term, or Eyring's sinh."""
    top = float(scale.speed[j])
    most = 2.0 * setup.true.outboard(j) * scale.slow + 2.0 * float(setup.true.of("damper")[j])  # torque per speed
    if rng.random() < 0.5:
        cube = rng.uniform(0.3, 1.0)
        return law_form(
            setup,
            "square and cube",
            most,
            lambda s: Law(torque_laws.DRAG, j, ((1 - cube) * s / top, cube * s / top**2)),
        )
    bend = rng.uniform(0.25, 0.5) * top
    size = bend * (math.sinh(top / bend) - top / bend)
    return law_form(setup, "Eyring", most, lambda s: Law(torque_laws.EYRING, j, (s * top / size, bend)))


def hardening(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A tanh (softening), quintic, sinh or piecewise spring; the size is its relative torque at the largest travel."""
    k, free = spring_rate_of(setup, j), float(setup.true.of("free_angle")[j])
    reach = max(abs(float(scale.low[j]) - free), abs(float(scale.high[j]) - free))
    kind = int(rng.integers(0, 4))
    if kind == 0:
        return law_form(
            setup, "tanh, softening", 4.0, lambda s: Law(torque_laws.TANH_SPRING, j, (k, free, reach / s)), reach=reach
        )
    if kind == 1:
        sign = float(rng.choice([-1.0, 1.0, 1.0]))
        most = 0.6 if sign > 0 else 0.15
        return law_form(
            setup,
            "quintic",
            most,
            lambda s: Law(torque_laws.QUINTIC_SPRING, j, (sign * s * k / reach**4, free)),
            reach=reach,
        )
    if kind == 2:
        return law_form(
            setup, "sinh", 3.0, lambda s: Law(torque_laws.SINH_SPRING, j, (k, free, reach / s)), reach=reach
        )
    knee = rng.uniform(0.3, 0.65) * reach
    return law_form(
        setup, "piecewise", 2.0, lambda s: Law(torque_laws.PIECEWISE_SPRING, j, (s * k, free, knee)), reach=reach
    )


def one_sided(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A spring that is weaker or stiffer on one side, with a smooth changeover or one beside the free angle."""
    k, free = spring_rate_of(setup, j), float(setup.true.of("free_angle")[j])
    low, high = float(scale.low[j]) - free, float(scale.high[j]) - free
    if low > -0.2 * (high - low) or high < 0.2 * (high - low):  # a fifth of the motion on either side, to see both
        raise NotApplicable("the joint stays on one side of its spring")
    sign = float(rng.choice([-1.0, -1.0, 1.0]))
    most = 0.98 if sign < 0 else 1.5
    side = float(rng.choice([-1.0, 1.0]))
    # The law acts for u > 0. For the other side change the rate on both sides and apply the law with opposite sign.
    if rng.random() < 0.5:
        width = math.radians(rng.uniform(0.5, 2.5))

        def soft(s: float) -> Law:
            return Law(torque_laws.SOFT_ONE_SIDED, j, (sign * s * k * side, free, width))

        return _form_on_one_side(setup, "soft changeover", most, soft, j, side, sign)
    shift = math.radians(rng.uniform(-1.5, 1.5))

    def sharp(s: float) -> Law:
        return Law(torque_laws.SHIFTED_ONE_SIDED, j, (sign * s * k * side, free, shift))

    return _form_on_one_side(setup, "sharp, beside the free angle", most, sharp, j, side, sign)


def _form_on_one_side(
    setup: Setup, name: str, most: float, law: Callable[[float], Law], j: int, side: float, sign: float
) -> Form:
    """A form that changes the rate on the positive side (``side`` 1) or on the negative one (-1)."""
    good = PlantedSensor.good(setup.true.n)
    k = float(setup.true.of("spring")[j])

    def build(s: float) -> tuple[Truth, PlantedSensor]:
        leg = setup.true if side > 0 else setup.true.changed("spring", j, k * (1 + sign * s))
        return Truth(leg, (law(s),)), good

    return Form(name, most, build, lambda s: {"rate_change": sign * s * k, "side": side, "width": law(s).par[2]})


def hysteresis(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A hysteretic spring: Bouc-Wen with a rounded knee, or two Maxwell branches."""
    k, travel = spring_rate_of(setup, j), float(scale.travel[j])
    if rng.random() < 0.5:
        delta, power, share = travel * rng.uniform(0.1, 0.4), rng.uniform(1.5, 3.0), rng.uniform(0.2, 0.6)
        return law_form(setup, "Bouc-Wen", 0.8, lambda s: Law(torque_laws.BOUC_WEN, j, (s * k, delta, power, share)))
    tau, ratio, second = rng.uniform(0.5, 2.5) / scale.slow, rng.uniform(4, 8), rng.uniform(0.5, 1.0)
    return law_form(
        setup, "two Maxwell", 0.8, lambda s: Law(torque_laws.TWO_MAXWELL, j, (s * k, tau, second * s * k, tau / ratio))
    )


def backlash(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Backlash: a massless arm that loses contact, or an arm of small inertia between Hunt-Crossley flanks."""
    k, b, free = (float(setup.true.of(name)[j]) for name in ("spring", "damper", "free_angle"))
    if min(k, b) <= 0.0 or any(joint == j for joint, _ in setup.true.curves):
        raise NotApplicable("backlash needs a spring and a linear damper behind it")
    good = PlantedSensor.good(setup.true.n)
    # 4 deg: the play of a worn gear; and within the motion.
    most = min(math.radians(4.0), 0.4 * float(scale.travel[j]))
    if rng.random() < 0.6:
        name = "contact lost"

        def law(s: float) -> Law:
            return Law(torque_laws.SLACK, j, (k, free, s, b))

    else:
        arm, loss = rng.uniform(0.01, 0.03) * setup.true.outboard(j), rng.uniform(0.1, 0.6) / float(scale.speed[j])
        flank = 2000.0 * k
        name = "arm and flanks"

        def law(s: float) -> Law:
            return Law(torque_laws.SLACK_ARM, j, (k, free, s, b, arm, flank, loss))

    return Form(
        name,
        most,
        lambda s: (Truth(setup.true, (law(s),), bare=(j,)), good),
        lambda s: {"half_gap_deg": math.degrees(s)},
    )
