"""Parts whose joints are longer than the links between them are not chosen where smaller ones do."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians

import numpy as np
import pytest

from synth.design import part_search
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption, SpringSource, WantedTravel
from synth.design.link_room import LinkRoom
from synth.design.part_search import FoundSets, best_allowed
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow
from synth.swing.leg_model import Damper, Joint, Leg, Link

CATALOGUE = Catalogue.load()
SMALL, LARGE = (CATALOGUE.find_spring(part) for part in ("9271K589", "LTR135H 10 M"))
TRAVEL = WantedTravel(radians(30.0), radians(10.0))


def leg(length: float) -> Leg:
    link = Link(length, 0.1, length / 2, 1e-4)
    return Leg("two links", (Joint("hip", link), Joint("knee", link)))


def option(row: TorsionSpringRow) -> SpringOption:
    assert row.rate is not None
    assert row.included_angle is not None
    return SpringOption(row.rate, row.included_angle, row=row)


def room(length: float, *, drawn: bool = True) -> LinkRoom:
    sources = [SpringSource(name, SpringChoice(), TRAVEL, CATALOGUE, CadOptions(), drawn=drawn) for name in ("a", "b")]
    return LinkRoom(sources, leg(length))


def fits(length: float, *rows: TorsionSpringRow, drawn: bool = True) -> bool:
    damper = DamperOption(None, Damper(0.1), "linear", "")
    return room(length, drawn=drawn).fits([(option(row), damper) for row in rows])


def test_the_longer_of_two_hinges_needs_the_longer_link() -> None:
    """The small spring's joint is as long as its damper's bracket asks, the large one's is longer by its coil."""
    lengths = np.arange(0.09, 0.2, 0.0005)

    def least(*rows: TorsionSpringRow) -> float:
        return float(next(length for length in lengths if fits(float(length), *rows)))

    small, mixed, large = least(SMALL, SMALL), least(SMALL, LARGE), least(LARGE, LARGE)
    assert small < mixed < large
    assert abs(small + large - 2.0 * mixed) < 0.002  # each hinge takes its own half
    assert fits(0.01, LARGE, LARGE, drawn=False)


def test_smaller_parts_are_looked_for_among_more_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 40 sets the best 3 do not fit; the first that do are taken, in their order."""

    def best(lanes: object, start: Sequence[int], keep: int, *, seed: int) -> FoundSets:
        index = np.arange(40)[:keep, None]
        return FoundSets(index, index[:, 0] * 0.1, 40, 40, None, True)

    class Lanes:
        counts = (40,)

    monkeypatch.setattr(part_search, "best_sets", best)
    lanes: object = Lanes()
    found, rows = best_allowed(lanes, 3, lambda row: row[0] >= 10)  # type: ignore[arg-type]
    assert found.index[:, 0].tolist() == [0, 1, 2]
    assert rows == [[10], [11], [12]]
    assert best_allowed(lanes, 3, lambda row: row[0] % 2 == 0)[1] == [[0], [2]]  # type: ignore[arg-type]
    assert best_allowed(lanes, 3, lambda row: False)[1] == []  # type: ignore[arg-type]
