"""Mass, centre of mass and inertia of each part of the drawn joints.

Printed, wound and cut parts: from their solids and densities. Heat-set inserts, which are not drawn, from their table,
all of one half together. Of bought dampers and encoders only the envelopes are
known, so their masses come from the project (``cad: masses``) or are assumed and marked as such.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from synth.swing.rigid_body import RigidBody, Tensor, combined_body
from synth.units import quantity

if TYPE_CHECKING:
    from synth.cad import BuiltLeg
    from synth.cad.joint import BuiltJoint
    from synth.cad.moments import Moments

ENCODER = 0.014  # kg: AMT103, CUI Devices' data sheet of the AMT10 series (2019), "Mechanical: weight"
# kg/m^3 of a damper's envelope, our assumption: plastic and oil about 1 to 1.4, small shares of zinc 6.6 and steel 7.85
DAMPER_DENSITY = 2000.0
ASSUMED = {
    "damper": f"assumed: {DAMPER_DENSITY:g} kg/m^3 of the drawn envelope; no catalogue gives it",
    "encoder": "assumed: as an AMT103 weighs by its data sheet",
}
WEIGHED = "the project file"
SOLID = "its solid"
TABLE = "its table in the catalogue"
BRASS = "tubes of brass by the table of heat-set inserts"
INSERTS = "inserts"  # end of the names, and the family


@dataclass(frozen=True, order=True)
class Pieces:
    """Number of equal dampers and springs at a joint, of which fewer may be drawn."""

    dampers: int = 1
    springs: int = 1


@dataclass(frozen=True)
class PartMass:
    """One part: the group that it moves with (``upper``, ``lower``, ``spring``), its rigid body, its mass's source.

    ``body`` is in the joint's frame at q = 0.
    """

    part: str
    joint: str
    family: str
    moves_with: str
    body: RigidBody
    basis: str

    @property
    def assumed(self) -> bool:
        """Whether the mass is assumed, neither weighed nor computed."""
        return self.basis in ASSUMED.values()


def masses_of(
    leg: BuiltLeg, weighed: Mapping[str, float], pieces: Mapping[str, Pieces], joints: Sequence[int]
) -> tuple[PartMass, ...]:
    """Every part's mass, joint by joint.

    Parameters
    ----------
    weighed
        kg by part, from the project.
    pieces
        numbers of parts at each joint: one damper is drawn, and of more than two springs one; a drawn part has the
        mass of those that are not drawn too.
    joints
        indices of the joints to weigh.
    """
    density, found = leg.dimensions.printing.density, []
    for joint, link in [(leg.joints[index], leg.links[index]) for index in joints]:
        name = joint.dimensions.name
        whole = pieces.get(name, Pieces())
        number = {"damper": whole.dampers, "spring": max(1.0, whole.springs / len(joint.springs))}
        for part in (*joint.parts, link):
            moments = part.moments()
            mass, basis = part.mass(density), SOLID if part.bought_mass is None else TABLE
            kilograms = None if mass is None else mass * 1e-3
            if kilograms is None:
                kilograms = ENCODER if part.family == "encoder" else DAMPER_DENSITY * moments.volume * 1e-9
                basis = ASSUMED["encoder" if part.family == "encoder" else "damper"]
            if part.name in weighed:
                kilograms, basis = weighed[part.name], WEIGHED
            body = _body(kilograms * number.get(part.family, 1), moments)
            found.append(PartMass(part.name, name, part.family, part.group, body, basis))
        found += _inserts(joint, weighed)
    return tuple(found)


def _body(kilograms: float, moments: Moments) -> RigidBody:
    scale = kilograms / moments.volume * 1e-6  # of mm^5 to kg m^2
    xx, yy, zz, xy, xz, yz = (scale * value for value in moments.tensor)
    x, y, z = (1e-3 * place for place in moments.centre)
    return RigidBody(kilograms, (x, y, z), (xx, yy, zz, xy, xz, yz))


def _inserts(joint: BuiltJoint, weighed: Mapping[str, float]) -> list[PartMass]:
    """The heat-set inserts of either half as one part, which is not drawn."""
    from synth.cad.insert_bodies import insert_bodies
    from synth.cad.parts import file_name

    name, found = joint.dimensions.name, []
    bodies = insert_bodies(joint)
    for group in dict.fromkeys(item.group for item in bodies):
        body = combined_body(_body(item.mass * 1e-3, item.moments) for item in bodies if item.group == group)
        part, basis = f"{file_name(name)}_{group}_{INSERTS}", BRASS
        if part in weighed:
            body, basis = body.share(weighed[part] / body.mass), WEIGHED
        found.append(PartMass(part, name, INSERTS, group, body, basis))
    return found


def unknown_parts(weighed: Mapping[str, float], masses: Sequence[PartMass]) -> list[str]:
    """Names under ``cad: masses`` that are not names of parts."""
    known = {item.part for item in masses}
    return [name for name in weighed if name not in known]


def mass_json(item: PartMass) -> dict[str, Any]:
    """The mass properties of a part, as written under ``solids.masses`` in ``design.json``."""
    names = ("xx", "yy", "zz", "xy", "xz", "yz")
    return {
        "part": item.part,
        "joint": item.joint,
        "family": item.family,
        "moves_with": item.moves_with,
        "mass": quantity(item.body.mass, "g"),
        "com": [quantity(place, "mm") for place in item.body.centre],
        "inertia": {n: quantity(v, "kg*m^2") for n, v in zip(names, item.body.inertia, strict=True)},
        "basis": item.basis,
    }


def mass_from(written: Mapping[str, Any]) -> PartMass:
    """The part that ``mass_json`` wrote, with lengths in mm and masses in g."""
    x, y, z = (place["value"] * 1e-3 for place in written["com"])
    tensor: Tensor = tuple(value["value"] for value in written["inertia"].values())
    body = RigidBody(written["mass"]["value"] * 1e-3, (x, y, z), tensor)
    return PartMass(written["part"], written["joint"], written["family"], written["moves_with"], body, written["basis"])
