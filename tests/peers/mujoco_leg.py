"""The same leg in another engine: a ``Leg`` as MuJoCo's MJCF, stepped by MuJoCo's own Runge-Kutta 4.

Nothing here uses the project's equations of motion; that is the point. x is to the right, z up, and a rotation is
counter-clockwise seen with them so, which makes every hinge's axis -y. MuJoCo's features that this chain does not have
(contact, limits, implicit damping) are off.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np
from numpy.typing import NDArray

from synth.swing.leg_model import DamperCurve, Joint, Leg, Link

Array = NDArray[np.float64]
ExtraTorque = Callable[[Array, Array], Array]  # rotations (n,), rates (n,) -> torques (n,) N m

OPTION = (
    '<option gravity="0 0 {gravity!r}" integrator="RK4" timestep="{step!r}">'
    '<flag contact="disable" constraint="disable" eulerdamp="disable" warmstart="disable"/></option>'
)


def with_tip_mass(link: Link, mass: float) -> Link:
    """The link with a point mass at its end: masses added, inertia about the new centre (parallel axes)."""
    total = link.mass + mass
    com = (link.mass * link.com + mass * link.length) / total
    across = link.mass * link.com_across / total
    inertia = link.inertia + link.mass * ((link.com - com) ** 2 + (link.com_across - across) ** 2)
    inertia += mass * ((link.length - com) ** 2 + across**2)
    return replace(link, mass=total, com=com, com_across=across, inertia=inertia)


def mjcf(
    leg: Leg,
    rotation0: Sequence[float] | Array,
    locked: Sequence[int] = (),
    tip_mass: float = 0.0,
    tilt: float = 0.0,
    step: float = 1e-4,
) -> str:
    """The leg as an MJCF document; a locked joint has no hinge, its link is mounted at ``rotation0``."""
    links = [joint.link for joint in leg.joints]
    links[-1] = with_tip_mass(links[-1], tip_mass)
    body = ""
    for i in reversed(range(len(links))):
        body = _body(leg, i, links[i], float(rotation0[i]) if i in locked else None, tilt, body)
    return (
        f"<mujoco model={quoteattr(leg.name)}>"
        '<compiler angle="radian" inertiafromgeom="false" autolimits="false"/>'
        f"{OPTION.format(gravity=-leg.gravity, step=step)}<worldbody>{body}</worldbody></mujoco>"
    )


def _body(leg: Leg, i: int, link: Link, locked_at: float | None, tilt: float, child: str) -> str:
    """Link i with all that hangs from it. Only the inertia about y counts in the plane."""
    turned = (leg.tilt + tilt if i == 0 else 0.0) + (locked_at or 0.0)
    height = 0.0 if i == 0 else -leg.joints[i - 1].link.length
    hinge = _hinge(leg.joints[i]) if locked_at is None else ""
    return (
        f'<body name="link{i}" pos="0 0 {height!r}" '
        f'quat="{math.cos(turned / 2)!r} 0 {-math.sin(turned / 2)!r} 0">{hinge}'
        f'<inertial pos="{link.com_across!r} 0 {-link.com!r}" mass="{link.mass!r}" '
        f'diaginertia="{link.inertia!r} {link.inertia!r} {link.inertia!r}"/>{child}</body>'
    )


def _hinge(joint: Joint) -> str:
    """The hinge with its linear spring and damper, as MuJoCo's own."""
    hinge = (
        f'<joint name={quoteattr(joint.name)} type="hinge" axis="0 -1 0" armature="{joint.armature!r}" limited="false"'
    )
    if joint.spring is not None:
        rest = joint.sign * (joint.spring.free_angle - joint.zero)
        hinge += f' stiffness="{joint.spring.rate!r}" springref="{rest!r}"'
    if joint.damper is not None and joint.damper.rate is not None:
        hinge += f' damping="{joint.damper.rate!r}"'
    return hinge + "/>"


def simulate(
    leg: Leg,
    rotation0: Sequence[float] | Array,
    rate0: Sequence[float] | Array,
    times: Array,
    locked: Sequence[int] = (),
    tip_mass: float = 0.0,
    tilt: float = 0.0,
    step: float = 1e-4,
    extra_torque: ExtraTorque | None = None,
    friction_width: float = 0.0,
) -> Array:
    """Rotations at ``times``, from rest or motion at ``times[0]``.

    Every sample lies on a step: each interval is cut into equal steps no longer than ``step``.

    Parameters
    ----------
    rotation0, rate0 : (n,) rad and rad/s, all joints; a locked joint keeps its rotation.
    times : (m,) s, increasing.
    extra_torque : torques beside springs and dampers, evaluated at each of the four Runge-Kutta stages.
    friction_width : rad/s, over which Coulomb friction is smoothed, ``torque * rate / sqrt(rate**2 + width**2)``;
        must be given when a joint has the effect ``coulomb_friction``.

    Returns
    -------
    (m, n) rad
    """
    return simulate_states(leg, rotation0, rate0, times, locked, tip_mass, tilt, step, extra_torque, friction_width)[0]


def simulate_states(
    leg: Leg,
    rotation0: Sequence[float] | Array,
    rate0: Sequence[float] | Array,
    times: Array,
    locked: Sequence[int] = (),
    tip_mass: float = 0.0,
    tilt: float = 0.0,
    step: float = 1e-4,
    extra_torque: ExtraTorque | None = None,
    friction_width: float = 0.0,
) -> tuple[Array, Array]:
    """As ``simulate``: rotations (m, n) rad and rates (m, n) rad/s."""
    model = mujoco.MjModel.from_xml_string(mjcf(leg, rotation0, locked, tip_mass, tilt, step))
    data = mujoco.MjData(model)
    free = [i for i in range(len(leg.joints)) if i not in locked]
    rotation = np.tile(np.asarray(rotation0, dtype=float), (len(times), 1))
    rate = np.zeros_like(rotation)
    data.qpos[:], data.qvel[:] = np.asarray(rotation0)[free], np.asarray(rate0)[free]
    rate[0, free] = data.qvel
    with _passive_torque(leg, data, free, rotation[0], extra_torque, friction_width):
        for sample, interval in enumerate(np.diff(times), start=1):
            count = max(1, math.ceil(interval / step - 1e-9))
            model.opt.timestep = interval / count
            mujoco.mj_step(model, data, nstep=count)
            rotation[sample, free], rate[sample, free] = data.qpos, data.qvel
    if not np.isfinite(rotation).all() or data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
        raise FloatingPointError("MuJoCo's simulation diverged; take a smaller step")
    return rotation, rate


@contextmanager
def _passive_torque(
    leg: Leg,
    data: mujoco.MjData,
    free: list[int],
    rotation0: Array,
    extra_torque: ExtraTorque | None,
    friction_width: float,
) -> Iterator[None]:
    """What MuJoCo's joints lack, added at every stage of a step through its callback for passive forces.

    The callback takes most of a simulation's time: it works on views of ``data`` that are made once, in plain numbers.
    """
    curves = {i: joint.damper.curve for i, joint in enumerate(leg.joints) if joint.damper and joint.damper.curve}
    friction = {i: _friction(joint) for i, joint in enumerate(leg.joints) if joint.effects}
    if not curves and not friction and extra_torque is None:
        yield
        return
    if friction and friction_width <= 0:
        raise ValueError("coulomb_friction needs friction_width, the speed over which it is smoothed")

    angles, rates, passive = data.qpos, data.qvel, data.qfrc_passive
    own = [(place, curves.get(i), friction.get(i, 0.0)) for place, i in enumerate(free) if i in curves or i in friction]
    rotation, rate = rotation0.copy(), np.zeros_like(rotation0)

    def add(*_: object) -> None:
        for place, curve, largest in own:
            speed = rates.item(place)
            torque = 0.0 if curve is None else -curve_torque(curve, speed)
            if largest:
                torque -= largest * speed / math.hypot(speed, friction_width)
            passive[place] += torque
        if extra_torque is not None:
            rotation[free], rate[free] = angles, rates
            passive[:] += extra_torque(rotation, rate)[free]

    mujoco.set_mjcb_passive(add)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


def _friction(joint: Joint) -> float:
    """Coulomb torque, N m; any other effect is not modelled here."""
    if set(joint.effects) != {"coulomb_friction"}:
        raise NotImplementedError(f"effects of joint {joint.name}: {sorted(joint.effects)}")
    return joint.effects["coulomb_friction"]["torque"]


def curve_torque(curve: DamperCurve, rate: float) -> float:
    """Torque (N m) against ``rate`` (rad/s): odd, linear between points from (0, 0) on and along the last segment."""
    speed, torque = [0.0, *curve.speed], [0.0, *curve.torque]
    value = abs(rate)
    last = len(speed) - 1
    i = next((k for k in range(1, last) if value < speed[k]), last)
    slope = (torque[i] - torque[i - 1]) / (speed[i] - speed[i - 1])
    return math.copysign(torque[i - 1] + slope * (value - speed[i - 1]), rate)


def mechanical_energy(leg: Leg, rotation: Array, rate: Array, tilt: float = 0.0) -> Array:
    """(m,) J, kinetic and potential energy of an undamped leg, written out link by link from the definition."""
    absolute, spin = leg.tilt + tilt + np.cumsum(rotation, axis=1), np.cumsum(rate, axis=1)
    hinge, hinge_rate = np.zeros((len(rotation), 2)), np.zeros((len(rotation), 2))
    energy = np.zeros(len(rotation))
    for i, joint in enumerate(leg.joints):
        along = np.stack([np.sin(absolute[:, i]), -np.cos(absolute[:, i])], axis=1)
        across = np.stack([np.cos(absolute[:, i]), np.sin(absolute[:, i])], axis=1)
        centre = hinge + joint.link.com * along + joint.link.com_across * across
        turned = joint.link.com * across - joint.link.com_across * along
        velocity = hinge_rate + turned * spin[:, i : i + 1]
        energy += 0.5 * joint.link.mass * (velocity**2).sum(axis=1) + 0.5 * joint.link.inertia * spin[:, i] ** 2
        energy += joint.link.mass * leg.gravity * centre[:, 1]
        if joint.spring is not None:
            rest = joint.sign * (joint.spring.free_angle - joint.zero)
            energy += 0.5 * joint.spring.rate * (rotation[:, i] - rest) ** 2
        hinge, hinge_rate = (
            hinge + joint.link.length * along,
            hinge_rate + joint.link.length * across * spin[:, i : i + 1],
        )
    return energy
