"""A jumping leg's model against free fall, a pogo stick, statics, energy, its planar form and another engine.

The drops are without motors. The expected values of the pogo and the crouch are closed forms; the energy is computed
independently of the compiled equations.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, pi, sqrt

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, Motor, segments
from synth.jump.jump_layout import LANES
from synth.jump.jump_models import MODELS, lane, layout_of
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.mujoco_model import HOW_TO_INSTALL, Drop, mujoco_jump, require_mujoco, resolved_step
from synth.jump.planar_jump import planar_jump
from synth.model_checks.checked import ModelCheck

MOTOR_ROWS = ("linear_torque", "torque_slope", "linear_current", "current_slope")
DROP = 0.05  # m, of a leg on its foot
POGO_DROP = 0.02  # m: fast enough to lift off again, slow enough for a light contact
# Limits, each a few times what was measured on the lab's leg with all three ways of bending (tests/hopper).
BALLISTIC = 1e-6  # m of fall
DEEPEST, TOUCH = 5e-3, 1e-2  # shares of the pogo's depth and contact time: the links are stiff, not rigid
BALANCE = 2e-3  # g, of the hips' acceleration at rest
KEPT = 1e-4  # of the energy that the drop releases
FORMS, HIGH = 1e-4, 0.2  # m of clearance: the planar form, and MuJoCo; of jumps over HIGH in proportion
MOST_HALVINGS = 3  # of MuJoCo's step: a crouch of 45 deg needs them
FOLLOWED = 5e-4  # m of height through a drop, MuJoCo
STIFF, WEAK_GROUND = 1e4, 200.0  # N m/rad of joints that do not fold, N/m of a ground that yields by centimetres


def jumping_checks(leg: HopperLeg, motors: list[Motor], contact: Contact) -> tuple[list[ModelCheck], list[str]]:
    """All checks at one length of the upper links; jumps use the motor that jumps highest."""
    motor = _strongest(leg, motors, contact)
    checks = [free_fall(leg, motor, contact), *pogo(leg, motor), crouch(leg, motor, contact), energy_kept(leg, motor)]
    checks += [upright(leg, motor, contact, name) for name in ("A", "full")]
    try:
        require_mujoco()
    except UserError:
        return checks, [HOW_TO_INSTALL]
    return [*checks, *four_bar_drop(leg, motor, contact), same_jump(leg, motor, contact)], []


def _strongest(leg: HopperLeg, motors: list[Motor], contact: Contact) -> Motor:
    found = simulate([(leg, motor) for motor in motors], contact, MODELS["A"])
    return motors[int(np.argmax([outcome.clearance for outcome in found]))]


def unpowered(leg: HopperLeg, motor: Motor, contact: Contact, above: float = 0.0) -> Array:
    """A lane of model A without motors, the foot ``above`` m over the ground."""
    layout = layout_of(leg)
    z = lane(leg, motor, contact, MODELS["A"])
    for name in MOTOR_ROWS:
        z[layout.row(name)] = 0.0
    z[layout.row("height")] += above
    return z


def free_fall(leg: HopperLeg, motor: Motor, contact: Contact) -> ModelCheck:
    """In flight the centre of mass falls by g t^2/2, whatever the links and springs do."""
    layout = layout_of(leg)
    lane_above = unpowered(leg, motor, contact, 0.3)
    # 6e-6 m off with the sweep's tolerance, 4e-9 m with this one: of a deep crouch, whose links turn fast.
    trace = compiled_jump(leg.bending).trace(lane_above, tolerance=1e-7, duration=0.15, fall=99.0)
    time, com = trace[:, 0], trace[:, 1 + layout.row("com")]
    fallen, expected = float(com[0] - com[-1]), 0.5 * leg.gravity * float(time[-1]) ** 2
    what = f"fall of the centre of mass in {time[-1] - time[0]:.5g} s"  # to the end of the integrator's last step
    return ModelCheck(what, "leg", expected, fallen, BALLISTIC, "m", "g t^2/2")


def pogo(leg: HopperLeg, motor: Motor) -> list[ModelCheck]:
    """With stiff joints the leg is a mass on the ground's spring: depth and contact time.

    Landing at speed v, ``x(t) = (v/w) sin wt - (g/w^2)(1 - cos wt)`` in contact, ``w = sqrt(k/m)``.
    """
    g, angle = leg.gravity, leg.start
    b = leg.lower_angle(angle)
    stiff = replace(leg, bending="none", flexures=Flexures(STIFF, 0.0, angle, angle + b, 2 * b), crouch=angle,
                    crouch_lower=None)  # fmt: skip
    z = unpowered(stiff, motor, Contact(stiffness=WEAK_GROUND, damping=0.0))
    layout = layout_of(stiff)
    z[layout.row("height")] = stiff.height(angle) + POGO_DROP
    w, v = sqrt(WEAK_GROUND / stiff.total_mass(motor)), sqrt(2 * g * POGO_DROP)
    held = 2 * (pi - atan2(v / w, g / w**2)) / w
    duration = sqrt(2 * POGO_DROP / g) + 1.3 * held
    trace = compiled_jump("none").trace(z, tolerance=1e-7, duration=duration, fall=99.0)
    time, foot = trace[:, 0], trace[:, 1 + layout.row("foot")]
    depth = g / w**2 + sqrt((g / w**2) ** 2 + (v / w) ** 2)
    down, up = _crossing(time, foot, -1), _crossing(time, foot, +1)
    source = "a mass landing on a spring"
    return [
        ModelCheck("pogo: compression of the ground", "foot", depth, float(-foot.min()), DEEPEST * depth, "m", source),
        ModelCheck("pogo: contact time", "foot", held, up - down, TOUCH * held, "s", source),
    ]


def _crossing(time: Array, height: Array, way: int) -> float:
    """When the height first crosses 0 downwards (-1) or, after that, upwards (+1), s; nan if it does not."""
    below = height < 0.0
    at = np.flatnonzero(below[1:] != below[:-1])
    wanted = at[:1] if way < 0 else at[1:2]
    if not len(wanted):
        return float("nan")
    k = int(wanted[0])
    return float(time[k] - height[k] * (time[k + 1] - time[k]) / (height[k + 1] - height[k]))


def crouch(leg: HopperLeg, motor: Motor, contact: Contact) -> ModelCheck:
    """With motor torque ``m g leverage / 2``, massless rigid links and no flexures the leg stays at rest."""
    light = replace(leg, bending="none", laminate=replace(leg.laminate, mass_per_length=1e-9),
                    flexures=Flexures(0.0, 0.0), foot_mass=0.0)  # fmt: skip
    layout = layout_of(light)
    z = unpowered(light, motor, contact)
    z[layout.row("linear_torque")] = light.total_mass(motor) * light.gravity * light.leverage(light.start) / 2
    workspace = np.repeat(z[:, None], LANES, axis=1)
    workspace[layout.row("alive")] = 1.0
    compiled_jump("none").right_hand_side(workspace)
    found = float(workspace[layout.row("derivative") + 1 + layout.n, 0])
    return ModelCheck("hip acceleration in the crouch under static torque", "hips", 0.0, found,
                      BALANCE * leg.gravity, "m/s^2", "virtual work: m g dy = 2 T da")  # fmt: skip


def energy_kept(leg: HopperLeg, motor: Motor) -> ModelCheck:
    """A drop on a lossless ground with rebound: springs, bending and ground return all energy."""
    free = replace(leg, flexures=replace(leg.flexures, damping=0.0), stop_dissipation=0.0)
    contact = Contact(damping=0.0)
    trace = compiled_jump(leg.bending).trace(unpowered(free, motor, contact, DROP), tolerance=1e-8, duration=0.16,
                                             fall=99.0)  # fmt: skip
    energy = energy_of(free, motor, trace, contact)
    released = free.total_mass(motor) * free.gravity * DROP
    return ModelCheck("energy after a four-bar's drop and rebound, relative to the energy released", "leg", 1.0,
                      1.0 + float(np.ptp(energy)) / released, KEPT, "1", "conservation of energy")  # fmt: skip


def energy_of(leg: HopperLeg, motor: Motor, trace: Array, contact: Contact) -> Array:
    """Kinetic, gravity, spring, stop and ground energy (n_time,) of the whole leg, J, piece by piece."""
    layout = layout_of(leg)
    lengths, masses, knee = segments(leg)
    z = trace[:, 1:]
    y, v = z[:, layout.row("height")], z[:, layout.row("speed")]
    phi = z[:, layout.block("angle")].copy()
    spin = np.column_stack([z[:, layout.block("rate")], np.zeros(len(z))])
    reach = leg.hip_spacing / 2 + np.sin(phi[:, :-1]) @ np.array(lengths[:-1])
    phi[:, -1] = -np.arcsin(reach / lengths[-1])
    spin[:, -1] = -(np.cos(phi[:, :-1]) * spin[:, :-1]) @ lengths[:-1] / (lengths[-1] * np.cos(phi[:, -1]))
    total = (leg.structure_mass + 2 * motor.mass) * (0.5 * v**2 + leg.gravity * y)
    px, py, vx, vy = np.full(len(z), leg.hip_spacing / 2), y.copy(), np.zeros(len(z)), v.copy()
    for i, (length, mass) in enumerate(zip(lengths, masses, strict=True)):
        s, c, w = np.sin(phi[:, i]), np.cos(phi[:, i]), spin[:, i]
        centre = (vx + 0.5 * length * c * w) ** 2 + (vy + 0.5 * length * s * w) ** 2
        total = total + 2 * (0.5 * mass * centre + 0.5 * mass * length**2 / 12 * w**2)
        total = total + 2 * mass * leg.gravity * (py - 0.5 * length * c)
        px, py, vx, vy = px + length * s, py - length * c, vx + length * c * w, vy + length * s * w
    foot, foot_v = py, vy
    total = total + leg.foot_mass * (0.5 * foot_v**2 + leg.gravity * foot)
    joints = leg.flexures
    total = total + joints.rate * (phi[:, 0] - joints.hip_rest) ** 2
    total = total + joints.rate * (phi[:, knee - 1] - phi[:, knee] - joints.knee_rest) ** 2
    total = total + 0.5 * joints.rate * (-2 * phi[:, -1] - joints.foot_rest) ** 2
    for i in range(len(lengths) - 1):
        if i != knee - 1:
            rate = leg.laminate.beam_rate(leg.length if i < knee else leg.lower_length)
            total = total + rate * (phi[:, i + 1] - phi[:, i]) ** 2
    total = total + leg.stop_rate * np.maximum(0.0, leg.extended - phi[:, 0]) ** 2
    return np.asarray(total + 0.5 * contact.stiffness * np.minimum(0.0, z[:, layout.row("foot")]) ** 2)


def upright(leg: HopperLeg, motor: Motor, contact: Contact, name: str) -> ModelCheck:
    """The jump by the planar form (multipliers for all constraints) against one side with its loop eliminated."""
    model = MODELS[name]
    found = simulate([(leg, motor)], contact, model, tolerance=1e-6)[0].clearance
    expected = planar_jump(leg, motor, contact, model, tolerance=1e-6).outcome.clearance
    name = f"clearance by model {name}, beside the planar form"
    source = "the planar form, whose equations have Lagrange multipliers"
    return ModelCheck(name, "foot", expected, found, _alike(expected), "m", source)


def four_bar_drop(leg: HopperLeg, motor: Motor, contact: Contact) -> list[ModelCheck]:
    """A leg that falls, lands and rebounds: height of hips and foot throughout, compared with MuJoCo."""
    layout, model = layout_of(leg), MODELS["D"]
    theirs = mujoco_jump(leg, motor, contact, model, drop=Drop(DROP, 0.2), step=2.5e-5)
    z = lane(leg, motor, contact, model)
    for name in MOTOR_ROWS:
        z[layout.row(name)] = 0.0
    z[layout.row("height")] = leg.height(leg.start) + DROP
    trace = compiled_jump(leg.bending).trace(z, tolerance=1e-7, duration=0.2, fall=99.0)
    times = np.linspace(0.0, min(trace[-1, 0], theirs.trace[-1, 0]), 200)
    checks = []
    for where, row, column in (("hips", "height", 1), ("foot", "foot", 3)):
        ours = np.interp(times, trace[:, 0], trace[:, 1 + layout.row(row)])
        other = np.interp(times, theirs.trace[:, 0], theirs.trace[:, column])
        worst = int(np.argmax(np.abs(ours - other)))
        name, source = (
            "height in a drop of the four-bar, at the largest difference",
            "MuJoCo with its own loop constraint",
        )
        checks.append(ModelCheck(name, where, float(other[worst]), float(ours[worst]), FOLLOWED, "m", source))
    return checks


def same_jump(leg: HopperLeg, motor: Motor, contact: Contact) -> ModelCheck:
    """Model A's jump compared with MuJoCo's on the same ground, in steps with which MuJoCo agrees with itself."""
    found = simulate([(leg, motor)], contact, MODELS["A"], tolerance=1e-6)[0].clearance
    step = resolved_step(leg, motor)
    expected = mujoco_jump(leg, motor, contact, MODELS["A"], step=step).outcome.clearance
    for _ in range(MOST_HALVINGS):
        coarser, step = expected, 0.5 * step
        expected = mujoco_jump(leg, motor, contact, MODELS["A"], step=step).outcome.clearance
        if abs(expected - coarser) < 0.5 * _alike(expected):
            break
    return ModelCheck(
        "clearance by model A, beside MuJoCo", "foot", expected, found, _alike(expected), "m",
        "MuJoCo on the same ground",
    )  # fmt: skip


def _alike(clearance: float) -> float:
    """Allowed difference of two clearances, m: on a moon a takeoff speed's rounding is multiplied."""
    return FORMS * max(1.0, clearance / HIGH)


def length_checked(leg: HopperLeg, lengths: tuple[float, ...]) -> HopperLeg:
    """The leg of middle length among those that can crouch.

    Raises
    ------
    UserError : none can.
    """
    able = [length for length in lengths if not leg.with_length(length).problems()]
    if not able:
        raise UserError("no length allows the crouch, so there is no leg to check")
    return leg.with_length(able[len(able) // 2])
