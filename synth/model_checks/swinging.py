"""A swinging leg's model against pendulums, oscillators, statics, energy and another engine.

The expected values are computed here from the leg's geometry, link by link, independently of the compiled equations.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
from scipy.optimize import minimize
from scipy.special import ellipk

from synth.arrays import Array, zero_crossings
from synth.model_checks.checked import ModelCheck
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, Joint, Leg
from synth.swing.mechanics import rest_pose

SWING = np.radians(30.0)  # of the pendulum: the period is 1.7 % longer than for small swings, so both forms are tested
AWAY = np.radians(10.0)  # of other releases from rest; inside most joints' travel
FINE = 1e-9  # tolerance of these simulations: a thousand times finer than a fit's
# Limits: a hundred times the engine's measured error on the built-in examples, far below any sensor's noise.
PERIOD, ANGLE, SHARE = 1e-5, np.radians(1e-3), 1e-5
PART = 0.3  # of a period: there the angle depends on stiffness, inertia and damping alike
BALANCED = 1e-9  # of the outboard weight at the outboard length: less is rounding, and its period hours
SETTLED = 1e-10  # rad, a step of Newton's method, and the descent's tolerance; a hundred-thousandth of ANGLE
SLOPE_STEP = 1e-5  # rad, for the stiffness by differences, which only sets how fast Newton's method ends
MOST_STEPS = 20  # of Newton's method; from the descent's end it takes two to four
PERIODS, SAMPLES = 4.2, 4000  # simulated periods, and samples over them


def swinging_checks(leg: Leg) -> tuple[list[ModelCheck], list[str]]:
    """All checks of a leg except the other engine's. Effects are left out; they have their own tests."""
    left_out = []
    names = sorted({name for joint in leg.joints for name in joint.effects} | set(leg.effects))
    if names:
        left_out.append(f"the file's effects ({', '.join(names)}) are left out of these checks")
    driven = [joint.name for joint in leg.joints if joint.drive is not None]
    if driven:
        left_out.append(
            f"the drive{'s' if len(driven) > 1 else ''} of {', '.join(driven)}: motor, servo and control steps are "
            "left out of these checks; of a drive only the rotor's inertia takes part"
        )
    plain = without_effects(leg)
    checks = []
    if leg.gravity > 0:
        for j, joint in enumerate(plain.joints):
            if _balanced(plain, j):
                left_out.append(
                    f"pendulum at the {joint.name}: what it carries is balanced, so gravity does not swing it"
                )
            else:
                checks.append(pendulum(plain, j))
    else:
        left_out.append("pendulums: the leg has no gravity")
    for j, joint in enumerate(plain.joints):
        if joint.spring is None or joint.spring.rate <= 0:
            left_out.append(f"oscillator at the {joint.name}: it has no spring")
        else:
            checks.append(oscillator(plain, j))
    try:
        rest_pose(plain)
    except ArithmeticError as error:
        return checks, [*left_out, f"equilibrium and energy: {error}"]
    pose = rest_pose(plain)
    loose = [joint.name for j, joint in enumerate(plain.joints) if _indifferent(plain, j, pose)]
    left_out += [f"equilibrium at the {name}: neither weight nor spring turns it; each angle is one" for name in loose]
    if len(loose) < len(plain.joints):
        checks += [check for check in rest(plain) if check.where not in loose]
    if potential(plain, pose + AWAY) - potential(plain, pose) <= BALANCED * _weight(plain):
        away = float(np.degrees(AWAY))
        left_out.append(f"energy: {away:.0f} deg away from equilibrium the leg has no more of it than there")
        return checks, left_out
    return [*checks, *energy_kept(plain)], left_out


def _indifferent(leg: Leg, j: int, pose: Array) -> bool:
    """Whether joint j is in equilibrium at each angle, the others at ``pose`` (n,) rad: a test of it would be empty."""
    turn = AWAY * np.eye(len(pose))[j]
    moved = [potential(leg, pose + way * turn) - potential(leg, pose) for way in (1.0, -1.0)]
    return max(map(abs, moved)) <= BALANCED * _weight(leg)


def _weight(leg: Leg) -> float:
    """Weight times length of the whole leg and its springs' rates, N m: the size of its energies in J."""
    rates = sum(joint.spring.rate for joint in leg.joints if joint.spring is not None)
    return leg.gravity * sum(j.link.mass for j in leg.joints) * sum(j.link.length for j in leg.joints) + rates


def without_effects(leg: Leg) -> Leg:
    """The leg with links, springs, dampers and armatures only; a drive's rotor is part of its joint's armature."""
    return replace(leg, effects={}, joints=tuple(_plain(joint) for joint in leg.joints))


def _plain(joint: Joint) -> Joint:
    # A winding's lag, without its drive, takes nothing from the inertia.
    return replace(joint, effects={}, drive=None, armature=max(joint.armature, joint.with_rotor))


def outboard(leg: Leg, j: int, pose: Array) -> tuple[float, float, float]:
    """Inertia about joint j (kg m^2), weight moment (N m) and its angle from straight down, of everything outboard.

    With all other joints locked at ``pose`` (n,) rad and joint j at 0: parallel axes from each link's position.
    """
    place, absolute = np.zeros(2), 0.0
    inertia, moment = leg.joints[j].armature, np.zeros(2)
    for i in range(j, len(leg.joints)):
        absolute += 0.0 if i == j else float(pose[i])
        along = np.array([np.sin(absolute), -np.cos(absolute)])
        link = leg.joints[i].link
        centre = place + link.com * along + link.com_across * np.array([np.cos(absolute), np.sin(absolute)])
        inertia += link.inertia + link.mass * float(centre @ centre)
        moment += link.mass * leg.gravity * centre
        place = place + link.length * along
    return inertia, float(np.hypot(*moment)), float(np.arctan2(moment[0], -moment[1]))


def _balanced(leg: Leg, j: int) -> bool:
    """Whether joint j carries its links at their common centre of mass, all other joints at their rest."""
    pose = np.array([joint.rest for joint in leg.joints])
    carried = [joint.link for joint in leg.joints[j:]]
    weight = leg.gravity * sum(link.mass for link in carried)
    return outboard(leg, j, pose)[1] <= BALANCED * weight * sum(link.length for link in carried)


def pendulum(leg: Leg, j: int) -> ModelCheck:
    """Joint j swinging alone without spring and damper: ``T = 4 sqrt(I / m g r) K(sin^2(A / 2))``."""
    bare = replace(leg, joints=tuple(replace(joint, spring=None, damper=None) for joint in leg.joints))
    pose = np.array([joint.rest for joint in leg.joints])
    inertia, moment, hangs = outboard(leg, j, pose)
    base = leg.tilt + float(pose[:j].sum())
    expected = 4.0 * sqrt(inertia / moment) * float(ellipk(np.sin(SWING / 2) ** 2))
    middle = -base - hangs
    pose[j] = middle + SWING
    times = np.linspace(0.0, PERIODS * expected, SAMPLES)
    locked = Conditions(locked=tuple(i for i in range(len(leg.joints)) if i != j))
    motion = simulate(bare, pose, np.zeros(len(pose)), times, locked, tolerance=FINE)[:, j] - middle
    source = "compound pendulum of finite swing, Goldstein, Classical Mechanics, 3rd ed., section 3.2 with K(k)"
    return ModelCheck("period as a pendulum", leg.joints[j].name, expected, period(times, motion), PERIOD * expected,
                      "s", source)  # fmt: skip


def period(times: Array, motion: Array) -> float:
    """Mean period, s, from zero crossings of an oscillation about 0; nan without two full swings.

    Each crossing is the root of the cubic through the four samples about it, or the middle of the samples at zero.
    """
    passed = zero_crossings(motion)
    passed = passed[(passed[:, 0] > 0) & (passed[:, 1] < len(times) - 1)]
    if len(passed) < 3:
        return float("nan")
    crossings = []
    for k, after in passed:
        if after > k + 1:
            crossings.append(0.5 * (times[k + 1] + times[after - 1]))
            continue
        # Inverse interpolation at 0 through four samples (Lagrange).
        x, t = motion[k - 1 : k + 3], times[k - 1 : k + 3]
        crossings.append(sum(t[a] * np.prod([-x[b] / (x[a] - x[b]) for b in range(4) if b != a]) for a in range(4)))
    return float(2.0 * (crossings[-1] - crossings[0]) / (len(crossings) - 1))


def oscillator(leg: Leg, j: int) -> ModelCheck:
    """Joint j alone with its spring, and its damper if linear, without gravity: the damped oscillator.

    The angle after a fraction of its undamped period, released from ``AWAY`` at rest.
    """
    joint = leg.joints[j]
    assert joint.spring is not None
    rate = joint.damper.rate if joint.damper is not None and joint.damper.rate is not None else 0.0
    bare = replace(leg, gravity=0.0).with_joints(**{joint.name: {"damper": Damper(rate)}})
    pose = np.array([each.rest for each in leg.joints])
    inertia, _, _ = outboard(leg, j, pose)
    natural, ratio = sqrt(joint.spring.rate / inertia), rate / (2.0 * sqrt(joint.spring.rate * inertia))
    at = PART * 2 * pi / natural
    pose[j] += AWAY
    locked = Conditions(locked=tuple(i for i in range(len(leg.joints)) if i != j))
    times = np.linspace(0.0, at, 200)
    found = simulate(bare, pose, np.zeros(len(pose)), times, locked, tolerance=FINE)[-1, j] - joint.rest
    source = "damped oscillator, Inman, Engineering Vibration, 4th ed., section 1.3"
    expected = AWAY * damped(natural, ratio, at)
    return ModelCheck(
        "angle after 0.3 periods as an oscillator", joint.name, expected, float(found), ANGLE, "deg", source
    )


def damped(natural: float, ratio: float, time: float) -> float:
    """Free motion from 1 at rest of an oscillator with this natural frequency (rad/s) and damping ratio."""
    root = np.sqrt(complex(ratio**2 - 1.0))
    slow, fast = natural * (-ratio + root), natural * (-ratio - root)
    if abs(slow - fast) < 1e-9 * natural:
        return float(np.exp(-natural * time) * (1 + natural * time))
    return float(((slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast)).real)


def potential(leg: Leg, rotation: Array) -> float:
    """Gravity and spring energy of a pose (n,) rad, J, link by link."""
    place, absolute, total = np.zeros(2), leg.tilt, 0.0
    for joint, angle in zip(leg.joints, rotation, strict=True):
        absolute += float(angle)
        along = np.array([np.sin(absolute), -np.cos(absolute)])
        height = float((place + joint.link.com * along)[1]) + joint.link.com_across * np.sin(absolute)
        total += joint.link.mass * leg.gravity * height
        place = place + joint.link.length * along
        if joint.spring is not None:
            total += 0.5 * joint.spring.rate * (float(angle) - joint.rest) ** 2
    return total


def kinetic(leg: Leg, rotation: Array, rate: Array) -> float:
    """Kinetic energy of one state, J, link by link."""
    absolute, spin, velocity, total = leg.tilt, 0.0, np.zeros(2), 0.0
    for joint, angle, turning in zip(leg.joints, rotation, rate, strict=True):
        absolute, spin = absolute + float(angle), spin + float(turning)
        across = spin * np.array([np.cos(absolute), np.sin(absolute)])
        inward = spin * np.array([-np.sin(absolute), np.cos(absolute)])
        centre = velocity + joint.link.com * across + joint.link.com_across * inward
        total += 0.5 * joint.link.mass * float(centre @ centre) + 0.5 * joint.link.inertia * spin**2
        total += 0.5 * joint.armature * float(turning) ** 2
        velocity = velocity + joint.link.length * across
    return total


def turning(leg: Leg, rotation: Array) -> Array:
    """(n,) N m, slope of ``potential`` at a pose (n,) rad: outboard weights at their levers, and springs."""
    place, absolute, joints, centres = 0.0, leg.tilt, [], []
    for joint, angle in zip(leg.joints, rotation, strict=True):
        absolute += float(angle)
        joints.append(place)
        centres.append(place + joint.link.com * np.sin(absolute) + joint.link.com_across * np.cos(absolute))
        place += joint.link.length * np.sin(absolute)
    weights = leg.gravity * np.array([joint.link.mass for joint in leg.joints])
    rates = np.array([joint.spring.rate if joint.spring is not None else 0.0 for joint in leg.joints])
    levers = [weights[j:] @ (np.array(centres[j:]) - joints[j]) for j in range(len(joints))]
    return np.asarray(levers + rates * (rotation - np.array([joint.rest for joint in leg.joints])))


def least_energy(leg: Leg, start: Array) -> Array:
    """(n,) rad, the pose of least ``potential`` near a start (n,) rad, to rounding at each joint.

    A light last link hardly shows in the energy of the whole leg: each angle is scaled by the root of the stiffness at
    its joint, and where the energy's rounding ends the descent, Newton's method goes on with its slope.
    """
    loads = [outboard(leg, j, start)[1] + (joint.spring.rate if joint.spring else 0.0)
             for j, joint in enumerate(leg.joints)]  # fmt: skip
    root = np.sqrt(np.maximum(loads, BALANCED * max(loads)))

    def energy(scaled: Array) -> float:
        return potential(leg, scaled / root)

    def slope(scaled: Array) -> Array:
        return turning(leg, scaled / root) / root

    found = minimize(energy, start * root, jac=slope, method="BFGS", options={"gtol": SETTLED * float(root.min())})
    pose = np.asarray(found.x) / root
    nudge = SLOPE_STEP * np.eye(len(pose))
    for _ in range(MOST_STEPS):
        stiffness = [(turning(leg, pose + each) - turning(leg, pose - each)) / (2.0 * SLOPE_STEP) for each in nudge]
        scaled = np.array(stiffness) / np.outer(root, root)
        step = np.linalg.lstsq(scaled, turning(leg, pose) / root)[0] / root
        pose = pose - step
        if np.abs(step).max() < SETTLED:
            break
    return np.asarray(pose)


def rest(leg: Leg) -> list[ModelCheck]:
    """At the minimum of potential energy, without dampers, the leg stays at rest for a second."""
    least = least_energy(leg, rest_pose(leg) + AWAY / 2)
    motion = simulate(_undamped(leg), least, np.zeros(len(least)), np.linspace(0.0, 1.0, 201), tolerance=FINE)
    source = "least potential energy of gravity and springs, by BFGS and Newton; the model's angle at the largest "
    source += "difference"
    checks = []
    for j, joint in enumerate(leg.joints):
        expected = float(leg.to_measured(least)[j])
        found = float(leg.to_measured(motion[int(np.argmax(np.abs(motion[:, j] - least[j])))])[j])
        checks.append(ModelCheck("angle at equilibrium", joint.name, expected, found, ANGLE, "deg", source))
    return checks


def _undamped(leg: Leg) -> Leg:
    return leg.with_joints(**{joint.name: {"damper": None} for joint in leg.joints})


def _slowest(leg: Leg, pose: Array) -> float:
    """The lowest natural frequency of a joint about the pose, all others locked, rad/s; 0 if one has no stiffness."""
    found = []
    for j, joint in enumerate(leg.joints):
        inertia, moment, _ = outboard(leg, j, pose)
        found.append(sqrt(((joint.spring.rate if joint.spring is not None else 0.0) + moment) / inertia))
    return min(found)


def energy_kept(leg: Leg) -> list[ModelCheck]:
    """Without dampers energy is constant; with linear ones it falls by the integral of ``sum b dq^2``.

    The leg has more energy ``AWAY`` from its equilibrium than there.
    """
    pose = rest_pose(leg)
    start = pose + AWAY
    slowest = _slowest(leg, pose)
    times = np.linspace(0.0, min(2.0, 3 * 2 * pi / slowest) if slowest > 0.0 else 2.0, 4001)
    released = potential(leg, start) - potential(leg, pose)
    n, checks = len(pose), []
    motion = simulate(_undamped(leg), start, np.zeros(n), times, tolerance=FINE, rates=True)
    end = potential(leg, motion[-1, :n]) + kinetic(leg, motion[-1, :n], motion[-1, n:])
    kept = 1.0 + (end - potential(leg, start)) / released
    name = "energy without dampers, relative to the energy released"
    checks.append(ModelCheck(name, "leg", 1.0, kept, SHARE, "1", "conservation of energy"))
    rates = np.array([joint.damper.rate if joint.damper and joint.damper.rate else 0.0 for joint in leg.joints])
    if not rates.any():
        return checks
    linear = leg.with_joints(
        **{j.name: {"damper": Damper(float(rate))} for j, rate in zip(leg.joints, rates, strict=True)}
    )
    motion = simulate(linear, start, np.zeros(n), times, tolerance=FINE, rates=True)
    power = motion[:, n:] ** 2 @ rates
    step = times[1] - times[0]
    lost = float(step / 3 * (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-2:2].sum()))  # Simpson
    end = potential(leg, motion[-1, :n]) + kinetic(leg, motion[-1, :n], motion[-1, n:])
    taken = (potential(leg, start) - end) / released
    name = "energy lost in the dampers, relative to the energy released"
    checks.append(ModelCheck(name, "leg", lost / released, taken, 10 * SHARE, "1", "the work of b dq/dt"))
    return checks
