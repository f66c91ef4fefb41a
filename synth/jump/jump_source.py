"""Source text of the compiled jump: one side of the symmetric five-bar, sixteen lanes in parallel.

Equations of motion. One side with half the body: hips' height y, pieces i = 0 .. n-1 from hip to foot at angles
phi_i from straight down (outward positive), masses and lengths folded into A_ij and G_i as for any chain
(``synth.swing.mechanics``). Lagrange's equations of the second kind:

    m y'' + sum_i G_i (sin phi_i phi_i'' + cos phi_i phi_i'^2)                       = N/2 - m g
    G_i sin phi_i y'' + sum_j A_ij (cos(phi_i - phi_j) phi_j'' + sin(phi_i - phi_j) phi_j'^2)
                                               = -g G_i sin phi_i + N/2 l_i sin phi_i + Q_i

with the closure h + sum_i l_i sin phi_i = 0, h half the hips' distance, by which the last piece is eliminated:
phi_n'' = sum_i r_i phi_i'' + gamma, r_i = -l_i cos phi_i / (l_n cos phi_n), gamma = sum l_i sin phi_i phi_i'^2 / (l_n
cos phi_n). Q_i: flexures k (deflection) and b (rate), link bending k_beam (phi_{i+1} - phi_i), the stop, the motor.

Motor and gear are ``synth.drives.motor_law``, the ground that of ``synth.jump.jump_models``. The gear's torque T acts
on phi_0 alone, so the accelerations are linear in it, phi_0'' = alpha + d T, and rotor inertia with a lossy gear is one
scalar equation.
"""

from __future__ import annotations

import re
from pathlib import Path

from synth.compiling.elimination import factorise, substitute
from synth.jump.jump_layout import LANES, JumpLayout

# 1/s: a maker's line brakes a joint so fast at most by the explicit part of a step, which bears it at 8e-5 s (2.5/3e4),
# as bending links do. By the implicit part alone rigid legs that jump 8 cm were 1.5 mm wrong, and are 0.5 mm wrong now.
EXPLICIT_DECAY = 3e4

HEADER = '''"""Written by synth.jump.jump_source."""
from math import sqrt

from synth.compiling.compiled import compiled
from synth.compiling.trigonometry import sine_cosine
from synth.drives.motor_law import (
    after_friction, current_change, direction, direction_slope, steady_line, transmitted_share, transmitted_slope,
)


@compiled('void(float64[:, ::1])', fastmath=True, error_model='numpy', nogil=True)
def right_hand_side(Z):
    F = Z.reshape(-1)
    for l in range({lanes}):
{body}
'''
_PLACE = re.compile(r"Z\[(\d+), l\]")
_SYNTH = Path(__file__).resolve().parent.parent
INLINED = (_SYNTH / "compiling" / "trigonometry.py", _SYNTH / "drives" / "motor_law.py")  # a change of one recompiles


def right_hand_side(layout: JumpLayout) -> str:
    """Source of ``right_hand_side(Z)``, which fills the rows ``derivative`` and those after it up to ``bend``."""
    lines = [*_kinematics(layout), *_contact(layout), *_forces(layout), *_reduced_system(layout), *_motor(layout)]
    lines += _outputs(layout)
    # One dimension with offsets known when compiled: only so does LLVM see that the rows do not overlap.
    body = "\n".join(f"        {_PLACE.sub(_flat, line)}" for line in lines)
    return HEADER.format(lanes=LANES, body=body)


def _flat(place: re.Match[str]) -> str:
    return f"F[{int(place[1]) * LANES} + l]"


def _kinematics(layout: JumpLayout) -> list[str]:
    """Angles, rates, sines and cosines; the last piece's from the closure."""
    n, last = layout.n, layout.n - 1

    def z(block: str, index: int = 0) -> str:
        return f"Z[{layout.row(block, index)}, l]"

    lines = [f"length{i} = {z('length', i)}" for i in range(n)]
    for i in range(last):
        lines += [f"p{i} = {z('angle', i)}", f"w{i} = {z('rate', i)}", f"s{i}, c{i} = sine_cosine(p{i})"]
    reach = " + ".join([z("half_spacing"), *(f"length{i} * s{i}" for i in range(last))])
    lines += [
        f"s{last} = max(-0.9999, min(0.9999, -({reach}) / length{last}))",
        f"c{last} = sqrt(1.0 - s{last} * s{last})",
        f"p{last} = {z('angle', last)}",
        f"per = 1.0 / (length{last} * c{last})",
    ]
    lines += [f"r{i} = -length{i} * c{i} * per" for i in range(last)]
    lines.append(f"w{last} = " + " + ".join(f"r{i} * w{i}" for i in range(last)))
    lines += [f"q{i} = w{i} * w{i}" for i in range(n)]
    lines.append("gamma = (" + " + ".join(f"length{i} * s{i} * q{i}" for i in range(n)) + ") * per")
    lines += [
        f"foot = {z('height')} - (" + " + ".join(f"length{i} * c{i}" for i in range(n)) + ")",
        f"foot_speed = {z('speed')} + " + " + ".join(f"length{i} * s{i} * w{i}" for i in range(n)),
    ]
    return lines


def _contact(layout: JumpLayout) -> list[str]:
    """Normal force: linear, N = k p + c p', or Hunt-Crossley, N = k p (1 + d p'), p = penetration.

    The linear one may pull (``may_pull`` 1) like the lab's; the other never does.
    """
    z = {name: f"Z[{layout.row(name)}, l]" for name in
         ("contact_stiffness", "contact_damping", "contact_dissipation", "may_pull")}  # fmt: skip
    law = (
        f"{z['contact_stiffness']} * depth * (1.0 - {z['contact_dissipation']} * foot_speed)"
        f" - {z['contact_damping']} * foot_speed"
    )
    return [
        "depth = max(0.0, -foot)",
        "touching = 1.0 if depth > 0.0 else 0.0",
        f"normal = touching * ({law})",
        f"normal = max(normal, -1e9 * {z['may_pull']})",
        "half_normal = 0.5 * normal",
    ]


def _forces(layout: JumpLayout) -> list[str]:
    """Generalised forces without the motor: inertia of motion, gravity, ground, flexures, bending, stop."""
    n, last, knee = layout.n, layout.n - 1, layout.knee

    def z(block: str, index: int = 0) -> str:
        return f"Z[{layout.row(block, index)}, l]"

    lines = [f"g = {z('gravity')}", f"m = {z('mass')}", f"b = {z('joint_damping')}"]
    lines += [f"G{i} = {z('moment', i)}" for i in range(n)]
    for i in range(n):
        lines.append(f"m{i}{i} = Z[{layout.inertia_row(i, i)}, l]")
        for j in range(i + 1, n):
            lines.append(f"a = Z[{layout.inertia_row(i, j)}, l]")
            lines.append(f"m{i}{j} = a * (c{i} * c{j} + s{i} * s{j})")
            lines.append(f"h{i}{j} = a * (s{i} * c{j} - c{i} * s{j})")
    lines.append("fy = half_normal - m * g - (" + " + ".join(f"G{i} * c{i} * q{i}" for i in range(n)) + ")")
    for i in range(n):
        terms = "".join(f" - h{i}{j} * q{j}" for j in range(i + 1, n)) + "".join(f" + h{j}{i} * q{j}" for j in range(i))
        lines.append(f"f{i} = (half_normal * length{i} - g * G{i}) * s{i}{terms}")
    fold = f"p{knee - 1} - p{knee}"
    lines += [
        f"hip = {z('hip_rate')} * (p0 - {z('hip_rest')}) + b * w0",
        f"fold = {z('knee_rate')} * ({fold} - {z('knee_rest')}) + b * (w{knee - 1} - w{knee})",
        # the foot's joint turns twice as far as one lower link, and its torque acts on each of them
        f"spread = {z('foot_rate')} * (-2.0 * p{last} - {z('foot_rest')}) - 2.0 * b * w{last}",
        f"past = max(0.0, {z('stop')} - p0)",
        f"stopping = {z('stop_rate')} * past * max(0.0, 1.0 - {z('stop_dissipation')} * w0)",
        "f0 = f0 - hip + stopping",
        f"f{knee - 1} = f{knee - 1} - fold",
        f"f{knee} = f{knee} + fold",
        f"f{last} = f{last} + spread",
    ]
    for i in range(n - 1):
        if i != knee - 1:
            lines.append(f"bend{i} = {z('beam', i)} * (p{i + 1} - p{i})")
            lines += [f"f{i} = f{i} + bend{i}", f"f{i + 1} = f{i + 1} - bend{i}"]
    return lines


def _reduced_system(layout: JumpLayout) -> list[str]:
    """The last piece eliminated: symmetric system J x = r in (y, phi_0 .. phi_{n-2}), its solution without motor and
    its column for a unit torque on phi_0, by one factorisation.
    """
    n, last = layout.n, layout.n - 1
    lines = [f"n{i} = G{i} * s{i}" for i in range(n)]  # mass terms between y and the angles
    lines += [f"fy = fy - n{last} * gamma", f"e = f{last} - m{last}{last} * gamma"]
    lines += ["J00 = m", "right0 = fy"]
    for i in range(last):
        lines.append(f"J0{i + 1} = n{i} + r{i} * n{last}")
        lines.append(f"right{i + 1} = f{i} - m{i}{last} * gamma + r{i} * e")
        for j in range(i, last):
            cross = f"r{i} * m{j}{last} + r{j} * m{i}{last} + r{i} * r{j} * m{last}{last}"
            lines.append(f"J{i + 1}{j + 1} = m{i}{j} + {cross}")
    lines += factorise(n)
    lines += substitute(n, "free", [f"right{i}" for i in range(n)])
    lines += substitute(n, "column", ["1.0" if i == 1 else "0.0" for i in range(n)])
    return lines


def _motor(layout: JumpLayout) -> list[str]:
    """Winding, friction, gear and rotor: the torque T that the gear puts on the upper link, inward positive."""

    def z(block: str) -> str:
        return f"Z[{layout.row(block)}, l]"

    winding = f"{z('voltage')}, current, omega, {z('resistance')}, {z('back_emf')}, {z('inverse_inductance')}"
    return [
        "omega = -w0",
        f"sign = direction(omega, {z('reverse_speed')})",
        f"current = {z('current')}",
        f"slope = current_change({winding})",
        f"drawn = steady_line({z('linear_current')}, {z('current_slope')}, omega) + current",
        f"torque = steady_line({z('linear_torque')}, {z('torque_slope')}, omega) + {z('torque_constant')} * current",
        f"torque = after_friction(torque, sign, omega, {z('friction')}, {z('viscous')})",
        f"rotor = {z('rotor_inertia')}",
        "push = torque + rotor * free1",  # what would reach the gear if the link moved on without it
        f"factor = transmitted_share(push, sign, {z('driving')}, {z('braking')})",
        "share = 1.0 / (1.0 + factor * rotor * column1)",
        "gear = factor * push * share",
        # The stiff part of the joint that it drives: slopes over omega by friction, gear and a maker's line, and by the
        # leg's stop, of which the rotor takes its share. See ``synth.jump.jump_step``.
        f"steep = direction_slope(sign, omega, {z('reverse_speed')})",
        f"of_factor = steep * transmitted_slope(push, {z('driving')}, {z('braking')})",
        f"of_line = -max(0.0, {z('torque_slope')} - {EXPLICIT_DECAY} / column1)",
        f"of_push = -{z('friction')} * steep - {z('viscous')} + of_line",
        f"of_stop = -{z('stop_rate')} * past * {z('stop_dissipation')} if {z('stop_dissipation')} * w0 < 1.0 else 0.0",
        "stiff = share * (share * push * of_factor + factor * of_push + of_stop)",
    ]


def _outputs(layout: JumpLayout) -> list[str]:
    """Derivative rows and what the integrator looks at; a lane that is done stands still."""
    n, last = layout.n, layout.n - 1
    d = layout.row("derivative")
    own = layout.row("own_slope")
    lines = [f"alive = Z[{layout.row('alive')}, l]"]
    lines += [f"Z[{own + i}, l] = alive * column{i} * stiff" for i in range(n)]
    lines += [f"Z[{d}, l] = alive * Z[{layout.row('speed')}, l]"]
    lines += [f"Z[{d + 1 + i}, l] = alive * w{i}" for i in range(n)]
    lines += [f"Z[{d + 1 + n + i}, l] = alive * (free{i} - column{i} * gear)" for i in range(n)]
    lines += [
        f"Z[{d + 1 + 2 * n}, l] = alive * slope",
        f"Z[{d + 2 + 2 * n}, l] = alive * 2.0 * Z[{layout.row('voltage')}, l] * drawn",
        f"Z[{layout.row('normal')}, l] = normal",
        f"Z[{layout.row('foot')}, l] = foot",
        f"Z[{layout.row('foot_speed')}, l] = foot_speed",
        f"Z[{layout.row('com_speed')}, l] = Z[{layout.row('speed')}, l] + ("
        + " + ".join(f"n{i} * w{i}" for i in range(n)) + ") / m",
        f"Z[{layout.row('com')}, l] = Z[{layout.row('height')}, l] - ("
        + " + ".join(f"G{i} * c{i}" for i in range(n)) + ") / m",
        f"Z[{layout.row('gear_torque')}, l] = gear",
        f"Z[{layout.row('drawn')}, l] = 2.0 * drawn",
        f"Z[{layout.row('bend')}, l] = s{last}",
    ]  # fmt: skip
    return lines
