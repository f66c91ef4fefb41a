"""The largest bending moments in a spring with both arms clamped, in closed form. Plain arithmetic, no solids.

The joint clamps both arms, so besides its torque it exerts a force on the wire that keeps the turning end on its circle
(``cad.flexed_wire``). The moment is therefore not the same everywhere: it is ``EI (tau + a x + b y)``, largest on the
side of the coil to which the force points, and with few coils some tenths above the torque.

``flexed`` finds the bent shape in some milliseconds, too long for every spring of a search. Here a uniform moment first
bends the wire into three arcs, each of a curvature larger by ``theta/L``. Then the force that takes its end from there
to its circle is found to first order (Castigliano's theorem for the bent shape; one step of Newton's method):

    (Jxx - Sx^2/L) a + (Jxy - Sx Sy/L) b =  ry
    (Jxy - Sx Sy/L) a + (Jyy - Sy^2/L) b = -rx,    tau = theta/L - (Sx a + Sy b)/L,

with S and J the first and second moments of the arcs' length about the axis, and r the distance of the end from its
place. For small angles this is exact.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from synth.cad.flexed_wire import effective_length

LEAST_ANGLE = 1e-4  # deg; a smaller one counts as this: the end's distance would be lost in rounding


@dataclass(frozen=True)
class PeakMoments:
    """Largest bending moments in the wire over the torque ``rate * angle``: in the ``coil``, in the straight ``arms``.

    The curvature correction factor of the stress holds in the coil only.
    """

    coil: float
    arms: float


@dataclass(slots=True)
class _Bent:
    """The uniformly bent wire; points x + iy, mm.

    ``ends`` : of the wire and of the coil, in order along it. ``begin``, ``turn`` : direction of the coil's first point
    from its ``centre``, and its angle, rad; ``radius`` mm. ``arm`` : length of each arm, mm.
    """

    ends: tuple[complex, complex, complex, complex]
    centre: complex
    radius: float
    begin: float
    turn: float
    arm: float


def peak_moments(radius: float, coils: float, arm: float, closing: float) -> PeakMoments:
    """The largest moments when the joint closes the arms by ``closing`` deg (negative: opens); lengths in mm.

    ``arm`` is the free length of each. The torque to which they refer is that of the small-angle rate,
    ``EI theta / effective_length``. Within 2 % of ``flexed`` as long as at least half of the coils remain.
    """
    theta = math.radians(closing if abs(closing) >= LEAST_ANGLE else LEAST_ANGLE)
    whole = math.tau * coils * radius + 2 * arm
    bent = _bent(radius, math.tau * coils, arm, theta / whole)
    place = complex(radius, arm) * cmath.rect(1.0, math.tau * coils + theta)
    tau, force = _load(bent, whole, theta, place)
    to_force, size = force.conjugate(), abs(force)
    linear = abs(theta) / effective_length(radius, coils, arm)
    at_ends = [abs(tau + (to_force * point).real) for point in bent.ends]
    middle, swing = tau + (to_force * bent.centre).real, size * bent.radius
    ahead = (cmath.phase(force) - bent.begin) % math.tau
    in_coil = at_ends[1:3]
    if ahead <= bent.turn:
        in_coil.append(abs(middle + swing))
    if (ahead + math.pi) % math.tau <= bent.turn:
        in_coil.append(abs(middle - swing))
    return PeakMoments(max(in_coil) / linear, max(at_ends) / linear)


def _bent(radius: float, turn: float, arm: float, uniform: float) -> _Bent:
    """The wire with its curvature changed by ``uniform`` 1/mm all along; ``turn`` rad of the free coil."""
    half = uniform * arm / 2
    chord = arm * (1.0 - half * half / 6.0)  # sin(half)/half; half is a few hundredths
    first = complex(radius, -arm)
    start = first + cmath.rect(chord, math.pi / 2 + half)
    heading = math.pi / 2 + 2 * half
    bent_radius = radius / (1.0 + uniform * radius)
    bent_turn = turn * (1.0 + uniform * radius)
    centre = start + cmath.rect(bent_radius, heading + math.pi / 2)
    begin = heading - math.pi / 2
    finish = centre + cmath.rect(bent_radius, begin + bent_turn)
    last = finish + cmath.rect(chord, heading + bent_turn + half)
    return _Bent((first, start, finish, last), centre, bent_radius, begin, bent_turn, arm)


def _load(bent: _Bent, whole: float, theta: float, place: complex) -> tuple[float, complex]:
    """``tau`` 1/mm and the force a + ib, 1/mm^2, both over EI, of the module's text.

    Integrals of z, z^2 and |z|^2 over the coil, z = centre + rho e^(i psi), and over both arms along their chords.
    """
    rho, centre, length = bent.radius, bent.centre, bent.radius * bent.turn
    low, high = cmath.rect(1.0, bent.begin), cmath.rect(1.0, bent.begin + bent.turn)
    around, twice = rho * rho * (high - low) / 1j, rho**3 * (high * high - low * low) / 2j
    once = centre * length + around
    square = centre * centre * length + 2 * centre * around + twice
    size = (abs(centre) ** 2 + rho * rho) * length + 2 * (centre.conjugate() * around).real
    for p, q in (bent.ends[:2], bent.ends[2:]):
        once += bent.arm * (p + q) / 2
        square += bent.arm * (p * p + p * q + q * q) / 3
        size += bent.arm * (abs(p) ** 2 + (p.conjugate() * q).real + abs(q) ** 2) / 3
    sx, sy = once.real, once.imag
    jxx = (size + square.real) / 2 - sx * sx / whole
    jyy = (size - square.real) / 2 - sy * sy / whole
    jxy = square.imag / 2 - sx * sy / whole
    off, determinant = bent.ends[3] - place, jxx * jyy - jxy * jxy
    a = (off.imag * jyy + off.real * jxy) / determinant
    b = (-off.real * jxx - off.imag * jxy) / determinant
    return (theta - sx * a - sy * b) / whole, complex(a, b)
