"""Assignment of parts to links, parts included in a link's stated masses, and the warnings."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from types import SimpleNamespace
from typing import Any

import pytest

from cad_joints import cleared
from synth.cad import JointDimensions, LegDimensions, MountDimensions, SpringDimensions
from synth.cad.leg_joints import build_leg_of_facets
from synth.design.link_masses import built_links, link_warnings, midway_links, same_links, turns_back, with_links
from synth.design.mass_loop import NEAR_JOINTS, pieces_of, same_but_for
from synth.design.part_masses import ASSUMED, SOLID, PartMass, Pieces, mass_from, mass_json, masses_of, unknown_parts
from synth.swing.leg_model import Joint, Leg, Link
from synth.swing.rigid_body import RigidBody, link_body

LENGTH = 0.2


def part(joint: str, group: str, mass: float, at: float, family: str = "upper", basis: str = SOLID) -> PartMass:
    """A part ``at`` m above its joint (along the links), of no size."""
    return PartMass(f"{joint}_{group}", joint, family, group, RigidBody(mass, (0.0, at, 0.0), (0.0,) * 6), basis)


PARTS = (
    part("hip", "upper", 0.9, 0.02),  # on the body: no link's
    part("hip", "lower", 0.10, -0.02),
    part("hip", "spring", 0.04, 0.0, "spring"),
    part("hip", "lower", 0.03, -0.1, "link"),
    part("knee", "upper", 0.06, 0.01, "damper", ASSUMED["damper"]),
    part("knee", "lower", 0.05, -0.02),
    part("knee", "spring", 0.02, 0.0, "spring"),
    part("knee", "lower", 0.01, -0.1, "link"),
)


def leg(includes: str, mass: float = 0.08, com: float = 0.1, inertia: float = 4e-4) -> Leg:
    link = Link(LENGTH, mass, com, inertia, includes)  # type: ignore[arg-type]
    return Leg("leg", (Joint("hip", link), Joint("knee", link)))


def test_parts_are_added_to_links_whose_figures_include_none() -> None:
    hip, knee = built_links(leg("none"), PARTS)
    assert hip.body.mass == pytest.approx(0.08 + 0.10 + 0.02 + 0.06 + 0.01)
    assert knee.body.mass == pytest.approx(0.08 + 0.05 + 0.01)
    moment = 0.08 * 0.1 + 0.10 * 0.02 + 0.06 * (LENGTH - 0.01) + 0.01 * LENGTH
    assert hip.link.com == pytest.approx(moment / hip.body.mass)
    about = 4e-4 + 0.08 * 0.1**2 + 0.10 * 0.02**2 + 0.06 * (LENGTH - 0.01) ** 2 + 0.01 * LENGTH**2
    assert hip.link.inertia + hip.link.mass * hip.link.com**2 == pytest.approx(about)
    assert [name for name, _, _ in knee.parts] == ["knee_lower", "knee_spring"]


def test_plausible_link_figures_are_kept() -> None:
    """Parts of 220 g on 500 g leave 280 g at 113 mm; with 3 kg mm^2 more than a point has, they can exist."""
    whole = leg("joint", 0.5, inertia=1.5e-3)
    hip, knee = built_links(whole, PARTS)
    assert hip.stands
    assert knee.stands
    assert with_links(whole, (hip, knee)) == whole
    assert knee.drawn.mass == pytest.approx(0.05 + 0.01 + 0.01)
    assert hip.rest is not None
    assert hip.rest.centre == pytest.approx((0.5 * 0.1 - 0.22 * hip.drawn.link(LENGTH).com) / 0.28)
    (_, text), *_ = link_warnings((hip, knee), {})
    assert "no other parts of 280 g, with their centre at 113 mm" in text


def test_a_rest_without_enough_inertia_comes_nearer_to_the_hinge() -> None:
    """Figures whose rest would have a negative inertia about its own centre were simulated as stated."""
    hip, _ = built_links(leg("joint", 0.5), PARTS)
    about = 4e-4 + 0.5 * 0.1**2
    place = sqrt((about - hip.drawn.about_hinge) / 0.28)
    assert place == pytest.approx(0.0944, abs=1e-4)
    assert hip.link.mass == pytest.approx(0.5)
    assert hip.body.about_hinge == pytest.approx(about)
    assert hip.link.com == pytest.approx((0.22 * hip.drawn.link(LENGTH).com + 0.28 * place) / 0.5)
    assert hip.body.inertia[2] > hip.drawn.inertia[2]
    (_, text), *_ = link_warnings((hip,), {})
    assert "no link with the drawn tube and joint parts has the target's figures" in text
    assert "would have their centre at 113 mm and 0.00249 kg*m^2, where at least 0.00357 is possible" in text
    assert (
        "The leg is designed with its mass and inertia about the joint and its centre at 90 instead of 100 mm" in text
    )
    assert text.endswith("as if these 280 g lay about 94 mm from the joint")


def test_heavier_parts_do_not_raise_a_stated_inertia() -> None:
    """They pushed the rest outwards, which asked for a stiffer and heavier spring, round by round."""
    heavier = [*PARTS, part("hip", "lower", 0.05, 0.0)]
    (hip, _), (other, _) = (built_links(leg("joint", 0.5), parts) for parts in (PARTS, heavier))
    assert other.drawn.mass == pytest.approx(hip.drawn.mass + 0.05)
    assert other.body.about_hinge == pytest.approx(hip.body.about_hinge)


@pytest.mark.parametrize(("com", "at"), [(0.02, 0.0), (0.19, LENGTH)])
def test_a_rest_off_the_link_is_put_on_it(com: float, at: float) -> None:
    """240 g of which 20 g would lie 65 mm above the hinge, or 1.4 m below it."""
    hip, _ = built_links(leg("joint", 0.24, com, 1e-4), PARTS)
    assert not hip.stands
    assert hip.body.mass == pytest.approx(0.24)
    assert hip.link.com == pytest.approx((0.22 * hip.drawn.link(LENGTH).com + 0.02 * at) / 0.24)
    assert hip.body.about_hinge == pytest.approx(hip.drawn.about_hinge + 0.02 * at**2)
    (_, text), *_ = link_warnings((hip,), {})
    assert "the other 20 g would have their centre at" in text


def test_a_rest_with_more_inertia_than_its_reach_allows_is_replaced() -> None:
    """1 g beside the parts that is to hold the inertia of 5 kg at the link's end."""
    hip, _ = built_links(leg("joint", 0.221, 0.0836, 0.2), PARTS)
    assert not hip.stands
    assert hip.body.about_hinge < hip.drawn.about_hinge + 0.001 * LENGTH**2 * 1.01


def test_impossible_link_figures_are_replaced_by_the_drawn_ones() -> None:
    """Drawn tube and parts of 220 g cannot be on a link of 80 g."""
    hip, knee = built_links(leg("joint", com=0.04), PARTS)
    assert not hip.stands
    assert hip.body.mass == pytest.approx(0.10 + 0.02 + 0.03 + 0.06 + 0.01)
    assert knee.stands
    (joint, text), *others = link_warnings((hip, knee), {})
    assert joint == "hip"
    assert "220 g instead of 80 g" in text
    assert [name for name, _ in others] == ["knee"]
    assert "parts weigh 70 g" in others[0][1]


def test_assumed_masses_are_named_with_their_key() -> None:
    links = built_links(leg("none"), PARTS)
    said = [text for _, text in link_warnings(links, {"knee_upper": "assumed"})]
    named = [text for text in said if "60 g of its link's 270 g are assumed masses of knee_upper" in text]
    assert len(named) == 1
    assert "cad: {masses:" in named[0]


@pytest.mark.parametrize(("drawn", "count"), [(1, 1), (2, 2), (1, 3)])
def test_all_springs_of_a_joint_are_weighed(drawn: int, count: int) -> None:
    """Of three in parallel one is drawn, and the links held the mass of that one."""
    spring = SpringDimensions(2.032, 17.018, 6.17, 120.0)
    ankle = cleared(JointDimensions("ankle", spring, 139.0, 138.0, range=(80.0, 170.0), springs=drawn))
    built, weighed = build_leg_of_facets(LegDimensions("leg", (ankle,))), {"ankle_spring": 0.01}

    def springs(given: dict[str, float]) -> list[float]:
        found = masses_of(built, given, {"ankle": Pieces(springs=count)}, [0])
        return [item.body.mass for item in found if item.family == "spring"]

    one = 7.85e-6 * built.joints[0].springs[0].exact_volume  # kg: steel
    assert sum(springs({})) == pytest.approx(count * one)
    assert springs(weighed)[0] == pytest.approx(0.01 * count / drawn)  # one of them was weighed


def test_the_pieces_of_a_joint_are_those_of_its_chosen_parts() -> None:
    damper, spring = SimpleNamespace(arrangement=SimpleNamespace(pieces=2)), SimpleNamespace(number=3)
    design: Any = SimpleNamespace(
        built=SimpleNamespace(joint_names=("hip",)),
        dampers=SimpleNamespace(chosen=(damper,)),
        springs=SimpleNamespace(chosen=(spring,)),
    )
    assert pieces_of(design) == {"hip": Pieces(dampers=2, springs=3)}


def test_links_within_half_a_per_cent_are_equal() -> None:
    assert same_links(leg("none", 0.080), leg("none", 0.0803))
    assert not same_links(leg("none", 0.080), leg("none", 0.081))


def test_an_unknown_weighed_part_is_named() -> None:
    assert unknown_parts({"hip_lower": 0.1, "hip_lowr": 0.1}, PARTS) == ["hip_lowr"]


def test_masses_round_trip_through_json() -> None:
    body = RigidBody(0.0123, (0.001, -0.02, 0.003), (1e-6, 2e-6, 3e-6, 1e-7, -2e-7, 3e-8))
    item = PartMass("hip_lower", "hip", "lower", "lower", body, SOLID)
    again = mass_from(mass_json(item))
    assert again.body.mass == pytest.approx(body.mass)
    assert again.body.centre == pytest.approx(body.centre)
    assert again.body.inertia == pytest.approx(body.inertia)
    assert link_body(Link(0.2, 0.1, 0.1, 1e-4)).mass == 0.1


def test_joints_are_weighed_again_only_after_a_relevant_change() -> None:
    spring = SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0)
    hip = JointDimensions("hip", spring, 110.0, 110.0, range=(80.0, 140.0))
    assert same_but_for(hip, replace(hip, free_angle=110.0 + 0.9 * NEAR_JOINTS), NEAR_JOINTS)
    assert same_but_for(hip, replace(hip, range=(80.0, 140.0 + 0.9 * NEAR_JOINTS)), NEAR_JOINTS)
    for other in (
        replace(hip, free_angle=110.0 + 1.1 * NEAR_JOINTS),
        replace(hip, range=(80.0, 140.0 + 1.1 * NEAR_JOINTS)),
        replace(hip, spring=replace(spring, mean_diameter=24.1)),
        replace(hip, spring=replace(spring, hand="left")),
        replace(hip, name="knee"),
        replace(hip, mount=MountDimensions()),
    ):
        assert not same_but_for(hip, other, NEAR_JOINTS)


def test_midway_links_have_the_mean_mass_centre_of_mass_and_inertia_about_the_joint() -> None:
    one, other = leg("joint"), leg("joint", 0.24, 0.02, 1e-4)
    made = midway_links(one, other).joints[1].link
    assert made.mass == pytest.approx(0.16)
    assert made.com == pytest.approx((0.08 * 0.1 + 0.24 * 0.02) / 0.32)
    about = [link_body(each.joints[1].link).about_hinge for each in (one, other)]
    assert link_body(made).about_hinge == pytest.approx(sum(about) / 2)


def test_links_turn_back_where_the_second_change_is_against_the_first() -> None:
    light, middle, heavy = (leg("joint", mass) for mass in (0.08, 0.12, 0.2))
    assert turns_back(light, heavy, middle)
    assert turns_back(heavy, light, middle)
    assert not turns_back(light, middle, heavy)
    assert not turns_back(light, middle, middle)
