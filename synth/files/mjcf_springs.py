"""A spring's curve in MJCF: the joint's own stiffness, and fixed tendons whose springs begin beyond a dead band."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Comment, Element, SubElement

from synth.files.joint_springs import SpringTerms

FAR = 1e6  # rad, the bound of a dead band on the side where the spring does not act: no joint turns as far


def spring_attributes(terms: SpringTerms, rest: float) -> dict[str, str]:
    """A hinge's attributes; ``rest`` : rad, where the spring is unloaded."""
    return {"stiffness": polynomial((terms.linear, 0.0, terms.cubic)), "springref": f"{rest:.10g}"}


def add_spring_pieces(tendons: Element, joint: str, rest: float, terms: SpringTerms) -> None:
    """One fixed tendon per piece on the hinge named ``joint``; ``rest`` as for ``spring_attributes``."""
    if terms.pieces:
        tendons.append(
            Comment(f" beside the stiffness of {joint}: each is a polynomial of the angle beyond a dead band ")
        )
    for index, piece in enumerate(terms.pieces):
        low = rest - piece.start if piece.side <= 0 else -FAR
        high = rest + piece.start if piece.side >= 0 else FAR
        first, second, third = piece.polynomial
        # MuJoCo's excess is negative below the dead band, where its quadratic term alone keeps its sign.
        second = -second if piece.side < 0 else second
        fixed = SubElement(tendons, "fixed", {
            "name": f"{joint} spring {index + 1}",
            "springlength": f"{low:.12g} {high:.12g}",
            "stiffness": polynomial((first, second, third)),
        })  # fmt: skip
        SubElement(fixed, "joint", joint=joint, coef="1")


def polynomial(coefficients: Sequence[float]) -> str:
    """A single number if linear, which every version of MuJoCo reads; otherwise three."""
    first, second, third = coefficients
    return f"{first:.12g}" if second == third == 0.0 else f"{first:.12g} {second:.12g} {third:.12g}"
