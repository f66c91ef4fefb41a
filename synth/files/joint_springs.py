"""A joint's spring in the forms of MuJoCo: a polynomial of the joint, and polynomials that begin beyond a deflection.

MuJoCo's joint spring is ``k1 u + k2 u^2 + k3 u^3`` with u signed, so its quadratic term pulls the same way on both
sides and holds no odd law. The spring of a fixed tendon is the same polynomial of what the angle exceeds a dead band
(``springlength``) by; with one bound far away it acts on one side only. A sum of those is any spline.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, radians

import numpy as np

from synth.arrays import Array
from synth.swing.effects.one_sided_spring import to_rotation
from synth.swing.leg_model import Joint

IN_SPRING = ("hardening_spring", "one_sided_spring")  # effects that are included in the spring's curve
LEAST = radians(1.0)  # rad, reach of a spring whose joint never moves
MARGIN = 1.1  # of the largest known deflection: another engine's motion overshoots a little
ACCURATE = 3e-4  # of the torque: a leg of one joint then swings for 1.5 s within 0.007 deg
FLOOR = 0.02  # of the largest torque, below which torques count as this much
MOST_KNOTS = 24  # exponent 1.2, whose curvature has no bound at rest, needs 13

Law = Callable[[Array], Array]
Cubic = tuple[float, float, float]


@dataclass(frozen=True)
class SpringPiece:
    """Torque ``a x + b x^2 + c x^3`` of the deflection ``x`` beyond ``start`` (rad).

    ``side`` : 1 for positive deflections, -1 for negative ones, where the torque is negated, 0 for both.
    """

    start: float
    side: int
    polynomial: Cubic

    def torque(self, deflection: Array) -> Array:
        """Torque (N m) at deflections (rad, any shape)."""
        way = np.sign(deflection) if self.side == 0 else np.full_like(deflection, self.side)
        x = np.maximum(way * deflection - self.start, 0.0)
        a, b, c = self.polynomial
        return np.asarray(way * (a * x + b * x**2 + c * x**3))


@dataclass(frozen=True)
class SpringTerms:
    """Spring torque ``linear u + cubic u^3`` of the deflection u, plus pieces.

    ``fitted`` : some pieces are a fit up to ``reach`` (rad of deflection), from where the curve goes on straight;
    otherwise they hold everywhere. ``error`` : largest within reach, as a share of the largest torque there.
    """

    linear: float
    cubic: float
    pieces: tuple[SpringPiece, ...]
    fitted: bool
    reach: float
    error: float

    def torque(self, deflection: Array) -> Array:
        """Torque (N m) at deflections (rad, any shape)."""
        found = self.linear * deflection + self.cubic * deflection**3
        return np.asarray(sum((piece.torque(deflection) for piece in self.pieces), found))


def reach_of(joint: Joint, deflected: float | None) -> float:
    """Deflection (rad) up to which the joint's spring is represented: of the known motion and of the joint's range.

    ``deflected`` : rad, largest of the motion; None: unknown. Half a turn where nothing is known.
    """
    known = [] if deflected is None else [MARGIN * deflected]
    known += [] if joint.ends is None else [abs(angle - joint.rest) for angle in joint.ends]
    return max(LEAST, *known) if known else pi


def spring_torque(joint: Joint, deflection: Array) -> Array:
    """Torque (N m) over deflection (rad of rotation, any shape) of the spring with its effects."""
    assert joint.spring is not None
    torque = joint.spring.rate * deflection
    hard = joint.effects.get("hardening_spring")
    if hard is not None:
        beyond = (np.maximum(np.abs(deflection) - hard.get("onset", 0.0), 0.0) + 1e-9) / hard.get("reach", 1.0)
        torque = torque / np.sqrt(1.0 + (hard.get("softening", 0.0) * deflection) ** 2)
        torque = torque + hard.get("stiffening", 0.0) * beyond ** hard.get("exponent", 3.0) * np.sign(deflection)
    if "one_sided_spring" in joint.effects:
        above, below, shift, width = _losses(joint)
        beyond = deflection - shift
        root = np.sqrt(beyond**2 + width**2) - width
        torque = torque - 0.5 * joint.spring.rate * (above * (beyond + root) + below * (beyond - root))
    return np.asarray(torque)


def spring_terms(joint: Joint, reach: float) -> SpringTerms:
    """The spring in MuJoCo's terms; what they do not hold exactly is fitted over deflections up to ``reach`` rad."""
    assert joint.spring is not None
    fitted = [_softened(joint, reach), _stiffened(joint, reach), _one_sided(joint, reach)]
    linear, cubic, pieces = joint.spring.rate, 0.0, []
    for piece in (piece for part, _ in fitted for piece in part):
        a, b, c = piece.polynomial
        if piece.side == 0 and piece.start == b == 0.0:
            linear, cubic = linear + a, cubic + c
        elif piece.side == 0 and b:  # even in MuJoCo: one side each
            pieces += [SpringPiece(piece.start, side, piece.polynomial) for side in (1, -1)]
        else:
            pieces.append(piece)
    terms = SpringTerms(linear, cubic, tuple(pieces), any(fit for _, fit in fitted), reach, 0.0)
    grid = np.linspace(-reach, reach, 801)
    wanted = spring_torque(joint, grid)
    largest = float(np.abs(wanted).max())  # 0 of a joint without a spring, whose torque nothing misses
    error = float(np.abs(terms.torque(grid) - wanted).max()) / largest if largest > 0.0 else 0.0
    return SpringTerms(linear, cubic, tuple(pieces), terms.fitted, reach, error)


def _losses(joint: Joint) -> tuple[float, float, float, float]:
    """Shares lost above and below, shift (rad), width (rad) of a one-sided spring in the sense of rotations."""
    lost = joint.effects["one_sided_spring"]
    above, below, shift, width = (lost.get(name, 0.0) for name in ("loss_above", "loss_below", "shift", "width"))
    return (*to_rotation(joint.sign, joint.zero, above, below, shift), width)


def _softened(joint: Joint, reach: float) -> tuple[list[SpringPiece], bool]:
    """What the spring loses by softening, and whether it is fitted."""
    softening = joint.effects.get("hardening_spring", {}).get("softening", 0.0)
    if not softening:
        return [], False
    assert joint.spring is not None
    rate = joint.spring.rate

    def lost(x: Array) -> Array:
        return np.asarray(rate * x * (1.0 / np.sqrt(1.0 + (softening * x) ** 2) - 1.0))

    found = _spline(lost, reach, lambda x: spring_torque(joint, x), odd=True)
    return [SpringPiece(start, 0, polynomial) for start, polynomial in found], True


def _stiffened(joint: Joint, reach: float) -> tuple[list[SpringPiece], bool]:
    """The torque that stiffening adds beyond its onset, and whether it is fitted."""
    hard = joint.effects.get("hardening_spring", {})
    size, exponent, onset = hard.get("stiffening", 0.0), hard.get("exponent", 3.0), hard.get("onset", 0.0)
    if not size:
        return [], False
    scale = size / hard.get("reach", 1.0) ** exponent
    if exponent in (1.0, 2.0, 3.0):
        a, b, c = (scale if exponent == power else 0.0 for power in (1.0, 2.0, 3.0))
        return [SpringPiece(onset, 0, (a, b, c))], False
    # An onset that the motion hardly reaches: the curve is begun nevertheless.
    found = _spline(
        lambda x: scale * x**exponent, max(reach - onset, 0.2 * reach), lambda x: spring_torque(joint, onset + x)
    )
    return [SpringPiece(onset + start, 0, polynomial) for start, polynomial in found], True


def _one_sided(joint: Joint, reach: float) -> tuple[list[SpringPiece], bool]:
    """What the spring lacks on each side, and whether its changeover is fitted."""
    if "one_sided_spring" not in joint.effects:
        return [], False
    assert joint.spring is not None
    above, below, shift, width = _losses(joint)
    rate = joint.spring.rate
    if width == 0.0:
        sides = ((1, above), (-1, below))
        return [SpringPiece(side * shift, side, (-rate * lost, 0.0, 0.0)) for side, lost in sides if lost], False

    def least(x: Array) -> Array:
        return np.minimum(*(np.abs(spring_torque(joint, shift + side * x)) for side in (1.0, -1.0)))

    rounded = _spline(lambda x: np.sqrt(x**2 + width**2) - width, reach + abs(shift), least)
    pieces = []
    for side in (1, -1):
        even = -0.5 * rate * side * (above - below)
        pieces.append(SpringPiece(side * shift, side, (-0.5 * rate * (above + below), 0.0, 0.0)))
        pieces += [
            SpringPiece(side * shift + start, side, (even * a, even * b, even * c)) for start, (a, b, c) in rounded
        ]
    return pieces, True


def _spline(law: Law, reach: float, beside: Law, *, odd: bool = False) -> list[tuple[float, Cubic]]:
    """A law with ``law(0) = 0`` over 0 to ``reach`` rad as cubics that begin at knots; beyond, it goes on straight.

    Least squares over truncated powers (de Boor, A Practical Guide to Splines, 1978), in shares of the spring's whole
    torque ``beside``; a knot is added amid the worst interval until all is accurate.
    ``odd`` : without the quadratic term.
    """
    x = np.unique(np.concatenate([np.linspace(0.0, reach, 301)[1:], np.geomspace(1e-3 * reach, reach, 100)]))
    wanted, whole = law(x), np.abs(beside(x))
    weight = 1.0 / (whole + FLOOR * whole.max())
    knots = [0.0]
    while True:
        powers = [x**3] if odd else [x**2, x**3]
        terms = np.column_stack([*powers, *(np.maximum(x - knot, 0.0) ** 3 for knot in knots[1:])])
        scale = terms.max(axis=0)
        found = np.linalg.lstsq(terms / scale * weight[:, None], wanted * weight, rcond=None)[0] / scale
        off = np.abs(terms @ found - wanted) * weight
        if off.max() <= ACCURATE or len(knots) > MOST_KNOTS:
            break
        worst = float(x[int(np.argmax(off))])
        after = next((knot for knot in knots if knot > worst), reach)
        before = max(knot for knot in knots if knot <= worst)
        knots = sorted([*knots, 0.5 * (before + after)])
    square = 0.0 if odd else float(found[0])
    cubes = [float(value) for value in (found if odd else found[1:])]
    bend = square + sum(3.0 * cube * (reach - knot) for cube, knot in zip(cubes, knots, strict=True))
    pieces = [(knot, (0.0, square if knot == 0.0 else 0.0, cube)) for knot, cube in zip(knots, cubes, strict=True)]
    return [*pieces, (reach, (0.0, -bend, -sum(cubes)))]
