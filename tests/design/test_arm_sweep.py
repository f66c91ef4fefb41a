"""Springs too weak to be wound up in a drawn joint are not chosen; joints of the user's own are not limited."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from design.own_springs import own_spring
from synth.cad.dimensions import coil_fraction
from synth.design.arm_sweep import WAY, least_rates
from synth.design.choose_springs import TOO_WEAK, SpringSource, WantedTravel, other_springs, spring_options
from synth.design.part_swaps import RATE_FACTORS
from synth.design.response import WantedRelease, WantedResponse
from synth.design.spring_warnings import wanted_rate_note
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

MASS, COM, REST, GRAVITY = 0.2, 0.1, np.radians(30.0), 9.81


def at_rest(sign: int, stated: tuple[float, float] | None = None) -> tuple[Leg, WantedResponse]:
    """A pendulum held at 30 deg by its spring, and the wanted motion: rest. ``stated``: the joint's range, deg."""
    torque = MASS * GRAVITY * COM * np.sin(REST)
    ends = None if stated is None else (float(np.radians(stated[0])), float(np.radians(stated[1])))
    joint = Joint("hip", Link(0.2, MASS, COM, 0.001), sign=sign, damper=Damper(0.02), range=ends)
    free = sign * float(REST + torque / 0.3)
    leg = Leg("a", (replace(joint, spring=Spring(0.3, free)),), gravity=GRAVITY)
    still = WantedRelease("one", np.linspace(0.0, 1.0, 11), np.array([REST]), np.zeros(1), Conditions())
    return leg, WantedResponse.of(leg, [still])


@pytest.mark.parametrize("sign", [1, -1])
def test_the_least_rate_has_its_free_angle_so_far_from_the_farther_stop(sign: int) -> None:
    """Motion at 30 deg, margins of 5 deg and stops of 3: from 22 deg (or from -38 to the other side) 140 deg on."""
    (least,) = least_rates(*at_rest(sign))
    free = np.degrees(REST + MASS * GRAVITY * COM * np.sin(REST) / least)
    assert free - (30.0 - 5.0 - 3.0) == pytest.approx(WAY, abs=1.01)  # drawn ranges are whole degrees


def test_between_wide_stops_the_free_angle_may_lie_anywhere() -> None:
    (least,) = least_rates(*at_rest(1, (-80.0, 100.0)))
    free = np.degrees(REST + MASS * GRAVITY * COM * np.sin(REST) / least)
    assert free == pytest.approx(101.5)  # the stop


def source(least: float, **choice: object) -> SpringSource:
    travel = WantedTravel(np.radians(100.0), 0.0)
    asked = SpringChoice(**choice)  # type: ignore[arg-type]
    return SpringSource("hip", asked, travel, Catalogue.load(), CadOptions(), drawn=True, least_rate=least)


def test_a_weaker_wanted_rate_is_held_to_the_least_and_told() -> None:
    (option,), _, _ = spring_options(source(0.05, make=True), 0.002)
    assert option.rate == pytest.approx(0.05, rel=0.01)
    assert option.held
    (said,) = wanted_rate_note("hip", option, "D", 0.002, SpringChoice(make=True))
    assert "0.002 N*m/rad, which would be unloaded farther away" in said
    (free,), _, _ = spring_options(source(0.0, make=True), 0.05)
    assert not free.held
    assert not source(0.05).winds_up(0.05 * RATE_FACTORS[3])


def test_bought_springs_that_are_too_weak_are_left_out_with_the_reason(tmp_path: Path) -> None:
    whole, row = own_spring(tmp_path, 1.14, 3.2, 33.0, 8 + coil_fraction(120.0))
    asked = replace(source(0.0, rate_tolerance=0.6), catalogue=replace(whole, springs=(row,)))
    assert [option.part for option in spring_options(asked, 1.1)[0]] == [row.part]
    limited = replace(asked, least_rate=1.3)
    (wound,), reasons, _ = spring_options(limited, 1.1)
    assert wound.row is None
    assert reasons == {TOO_WEAK: 1}
    assert all(option.row is None for option in other_springs(limited, 1.3, [wound]))
