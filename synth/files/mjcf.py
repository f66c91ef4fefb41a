"""A leg as MJCF for MuJoCo: springs, dampers with their curve as MuJoCo's cubic, dry friction, inertias.

MuJoCo's joint damping may be a polynomial, ``-(a v + b v|v| + c v^3)`` (XML reference, joint/damping); a torque-speed
curve goes in as the cubic that fits it best over the speeds that matter, and the error of that is written beside it.
Effects other than dry friction, which MuJoCo's joints do not have, are named in a comment.
"""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from synth.model.curves import torque_at
from synth.model.leg import Array, DamperCurve, Joint, Leg


def cubic_damping(curve: DamperCurve, fastest: float) -> tuple[Array, float]:
    """Coefficients (3,) of ``a v + b v|v| + c v^3`` and the largest error as a share of the largest torque.

    Least squares over 0 to ``fastest`` rad/s; the result damps at every speed in it (checked, else a straight line).
    """
    speed = np.linspace(0.0, fastest, 200)[1:]
    torque = torque_at(curve, speed)
    design = np.column_stack([speed, speed**2, speed**3])
    found = np.linalg.lstsq(design, torque, rcond=None)[0]
    if np.any(design @ found <= 0):
        found = np.array([float(speed @ torque / (speed @ speed)), 0.0, 0.0])
    return np.asarray(found), float(np.abs(design @ found - torque).max() / torque.max())


def mjcf_text(leg: Leg, fastest: Array) -> str:
    """The leg as an MJCF document; ``fastest`` (n,) rad/s is how far each damper's curve must be followed.

    Links hang along -z of their body, joints turn about -y so that a positive angle is counter-clockwise seen with x to
    the right and z up. Inertias other than about the joint axis are those of a rod of the same length.
    """
    lines = [
        f"<mujoco model={quoteattr(leg.name)}>",
        "  <!-- written by synth; joint angles are rotations q = sign * (measured - zero) -->",
        *([f"  <!-- not in this model: {', '.join(sorted(leg.effects))} of the base -->"] if leg.effects else []),
        '  <compiler angle="radian" autolimits="true"/>',
        f'  <option gravity="0 0 {-leg.gravity:.10g}" integrator="RK4" timestep="0.0005"/>',
        "  <worldbody>",
        f'    <body name="base" euler="0 {-leg.tilt:.10g} 0">',
    ]
    indent = "      "
    for index, joint in enumerate(leg.joints):
        height = 0.0 if index == 0 else leg.joints[index - 1].link.length
        lines += [indent + line for line in _body(joint, height, float(fastest[index]))]
        indent += "  "
    for _ in leg.joints:
        indent = indent[:-2]
        lines.append(f"{indent}</body>")
    lines += ["    </body>", "  </worldbody>", "</mujoco>", ""]
    return "\n".join(lines)


def _body(joint: Joint, height: float, fastest: float) -> list[str]:
    link = joint.link
    attributes = ['axis="0 -1 0"']
    note = ""
    if joint.spring is not None:
        rest = joint.sign * (joint.spring.free_angle - joint.zero)
        attributes.append(f'stiffness="{joint.spring.rate:.10g}" springref="{rest:.10g}"')
    if joint.damper is not None and joint.damper.rate is not None:
        attributes.append(f'damping="{joint.damper.rate:.10g}"')
    elif joint.damper is not None and joint.damper.curve is not None:
        cubic, error = cubic_damping(joint.damper.curve, fastest)
        attributes.append('damping="{:.10g} {:.10g} {:.10g}"'.format(*cubic))
        note = f"  <!-- damper's curve as a cubic up to {fastest:.3g} rad/s, at most {error:.0%} of its torque off -->"
    friction = joint.effects.get("coulomb_friction")
    if friction is not None:
        attributes.append(f'frictionloss="{friction["torque"]:.10g}"')
    lost = sorted(set(joint.effects) - {"coulomb_friction"})
    if lost:
        note += f"  <!-- not in this model: {', '.join(lost)} -->"
    if joint.range is not None:
        ends = sorted(joint.sign * (angle - joint.zero) for angle in joint.range)
        attributes.append(f'range="{ends[0]:.10g} {ends[1]:.10g}"')
    across = max(link.mass * link.length**2 / 12, link.inertia)
    along = max(1e-3 * link.inertia, abs(across - link.inertia) + 1e-3 * link.inertia)
    name = quoteattr(joint.name)
    return [
        f'<body name={name} pos="0 0 {-height:.10g}">{note}',
        f"  <joint name={name} {' '.join(attributes)}/>",
        f'  <inertial pos="0 0 {-link.com:.10g}" mass="{link.mass:.10g}" '
        f'diaginertia="{across:.10g} {link.inertia:.10g} {along:.10g}"/>',
        f'  <geom type="capsule" fromto="0 0 0 0 0 {-link.length:.10g}" size="0.008" contype="0" conaffinity="0"/>',
    ]


def write_mjcf(leg: Leg, fastest: Array, path: Path) -> None:
    """Write ``mjcf_text``."""
    path.write_text(mjcf_text(leg, fastest), encoding="utf-8")
