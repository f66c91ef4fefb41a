"""The heat-set inserts' brass: one for each screw without a nut, where its hole is cut from the print."""

from __future__ import annotations

import math

import pytest

from synth.cad import BuiltLeg
from synth.cad.hardware import insert_of, inserts
from synth.cad.insert_bodies import BRASS, insert_bodies, insert_mass
from synth.cad.joint import BuiltJoint
from synth.cad.standard_part import StandardPart
from synth.design.part_masses import SOLID, TABLE, WEIGHED, masses_of


def screws_of(joint: BuiltJoint) -> list[tuple[str, float]]:
    """Names and threads of the screws that end in inserts."""
    made = [(part.name, part.made) for part in joint.parts]
    return [
        (name, item.thread)
        for name, item in made
        if isinstance(item, StandardPart) and item.has_insert and item.thread is not None
    ]


def test_every_insert_lies_in_the_hole_of_its_screw(leg: BuiltLeg) -> None:
    """Round its middle there is no print up to the hole's radius, and print outside it."""
    import manifold3d

    joint = leg.joints[1]
    bodies, screws = insert_bodies(joint), screws_of(joint)
    assert len(bodies) == len(screws) > 12
    for body, (name, thread) in zip(bodies, screws, strict=True):
        printed = [part.mesh.manifold for part in joint.parts if part.printed and part.group == body.group]
        around = []
        for radius in (insert_of(thread).hole / 2 - 0.1, insert_of(thread).hole / 2 + 0.5):
            disc = manifold3d.Manifold.cylinder(0.2, radius, center=True).translate(body.moments.centre)
            around.append(sum(float((disc ^ part).volume()) for part in printed))
        assert around[0] < 0.01, name
        assert around[1] > 0.5, name


def test_an_insert_weighs_what_its_tube_of_brass_does() -> None:
    """M3 x 5.7 in a hole of 4 mm: 0.3 to 0.4 g; each is lighter than a bar of its hole and heavier than a sleeve."""
    assert insert_mass(inserts()[3.0]) == pytest.approx(0.336, abs=0.001)
    for insert in inserts().values():
        bar = BRASS * 1e-3 * math.pi / 4 * insert.hole**2 * insert.length
        assert 0.2 * bar < insert_mass(insert) < 0.7 * bar


def test_its_moments_are_those_of_a_tube(leg: BuiltLeg) -> None:
    insert = insert_of(3.0)
    body = next(b for b, (_, thread) in zip(insert_bodies(leg.joints[2]), screws_of(leg.joints[2]), strict=True)
                if thread == 3.0)  # fmt: skip
    inner, outer, long = 0.89 * 3.0 / 2, insert.hole / 2, insert.length
    volume = math.pi * (outer**2 - inner**2) * long
    assert body.moments.volume == pytest.approx(volume)
    assert body.moments.about_z == pytest.approx(volume * (outer**2 + inner**2) / 2)
    assert body.moments.tensor[0] == pytest.approx(volume * (3 * (outer**2 + inner**2) + long**2) / 12)


def test_the_links_carry_the_inserts_of_their_halves(leg: BuiltLeg) -> None:
    """Beside the printed parts, in which they are holes; weighed ones take the place of the table's."""
    bodies = insert_bodies(leg.joints[2])
    found = {item.part: item for item in masses_of(leg, {"ankle_lower_inserts": 4e-3}, {}, [2])}
    upper = found["ankle_upper_inserts"]
    assert upper.moves_with == "upper"
    assert upper.body.mass * 1e3 == pytest.approx(sum(body.mass for body in bodies if body.group == "upper"))
    assert upper.body.mass * 1e3 > 3.0
    assert not upper.assumed
    assert (found["ankle_lower_inserts"].body.mass, found["ankle_lower_inserts"].basis) == (4e-3, WEIGHED)
    assert found["ankle_bearing_a"].basis == TABLE
    assert found["ankle_shaft"].basis == SOLID
