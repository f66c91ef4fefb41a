"""Where the rounds of parts and masses do not settle, every figure is that of the leg as drawn."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from design.one_joint import designed
from synth.design import mass_loop
from synth.remarks import severity_of
from synth.swing.leg_model import Leg


def _heavier(leg: Leg, factor: float) -> Leg:
    links = [replace(j.link, mass=factor * j.link.mass, inertia=factor * j.link.inertia) for j in leg.joints]
    return replace(leg, joints=tuple(replace(j, link=k) for j, k in zip(leg.joints, links, strict=True)))


def _weigh_wrongly(monkeypatch: pytest.MonkeyPatch, factors: Iterable[float]) -> None:
    """Links of ``factors`` times their mass, drawing by drawing."""
    found, left = mass_loop.JointWeights.on_links, iter(factors)

    def wrong(self: Any, design: Any) -> Any:
        return _heavier(found(self, design), next(left))

    monkeypatch.setattr(mass_loop.JointWeights, "on_links", wrong)


def test_forecast_costs_and_warnings_are_those_of_the_last_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Forecast and costs were those of the round before, 4.5 deg, beside a response of 6.5 deg.

    Here the last round chooses for links of six times their mass.
    """
    _weigh_wrongly(monkeypatch, (1.0, 6.0, 1.0))
    monkeypatch.setattr(mass_loop, "MOST_ROUNDS", 2)
    design = designed(tmp_path, amplitude=30, frequency=2)
    assert design.rounds == mass_loop.MassRounds(2, settled=False)
    error = float(np.sqrt(np.mean(design.errors**2)))
    assert error > np.radians(2.0)
    chosen = design.sets.chosen
    assert [chosen.error, chosen.forecast.nominal, chosen.ready.nominal] == pytest.approx([error] * 3, rel=0.02)
    assert design.springs.chosen[0].error == design.dampers.chosen[0].error == chosen.error
    assert design.springs.chosen[0] in design.springs.ranked[0]
    texts = [text for _, text in design.warnings]
    assert any(f"the built leg will move {np.degrees(error):.1f} deg" in text for text in texts)
    (told,) = [text for text in texts if "still changes with the links' masses" in text]
    assert severity_of(told) == "decide"


def test_the_same_parts_on_other_links_are_chosen_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wire of one label gets other coils as the links change, which settled the rounds at a link 16 % off."""
    _weigh_wrongly(monkeypatch, (1.0, 1.0, 1.05, 1.05))
    assert designed(tmp_path, amplitude=30, frequency=2).rounds == mass_loop.MassRounds(3, settled=True)


def test_rounds_that_turned_back_and_choose_alike_go_on_from_the_links_of_their_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They went half the way in each round, until the limit of rounds or of SAME_CHOICE."""
    found, seen, drawings = mass_loop.JointWeights.on_links, [], iter((1.0, 1.5, 1.0))
    choose = mass_loop.design_for

    def weighed(self: Any, design: Any) -> Any:
        return _heavier(found(self, design), next(drawings, 1.0))

    def told(project: Any, catalogue: Any, known: Any, target: Leg, stage: Any, **wanted: Any) -> Any:
        seen.append(target.joints[0].link.mass)
        return choose(project, catalogue, known, target, stage, **wanted)

    monkeypatch.setattr(mass_loop.JointWeights, "on_links", weighed)
    monkeypatch.setattr(mass_loop, "design_for", told)
    design = designed(tmp_path, amplitude=30, frequency=2)
    _, light, heavy, midway, *last = [mass / design.built.joints[0].link.mass for mass in seen]
    assert [light, heavy, midway] == pytest.approx([1.0, 1.5, 1.25], rel=0.1)
    assert last == pytest.approx([1.0], rel=0.05)
    assert design.rounds == mass_loop.MassRounds(4, settled=True)


@pytest.mark.slow
def test_rounds_whose_links_turn_back_begin_midway(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Here parts and masses agree at links of 3 times their mass; the rounds alternated between 1 and 7 times.

    The rate that a swing wants is in proportion to the link's mass.
    """
    found, rates = mass_loop.JointWeights.on_links, []

    def lighter_with_a_stiffer_spring(self: Any, design: Any) -> Any:
        rates.append(design.springs.chosen[0].rate)
        return _heavier(found(self, design), min(max(9.0 - 2.0 * rates[-1] / rates[0], 1.0), 7.0))

    monkeypatch.setattr(mass_loop.JointWeights, "on_links", lighter_with_a_stiffer_spring)
    design = designed(tmp_path, amplitude=30, frequency=2)
    assert rates[1] > 7.0 * rates[0]
    assert rates[2] < 1.5 * rates[0]
    assert rates[-1] / rates[0] == pytest.approx(3.0, rel=0.2)
    assert design.springs.chosen[0].rate / rates[0] == pytest.approx(3.0, rel=0.4)


def test_of_unsettled_rounds_the_best_with_its_own_masses_is_taken(tmp_path: Path) -> None:
    """The last was taken, though its links were six times as heavy as those for which its parts were chosen."""
    one = designed(tmp_path, amplitude=30, frequency=2, solids=False)
    other, leg = replace(one), one.sets.leg
    assert mass_loop._best_as_drawn([(one, leg), (other, _heavier(leg, 6.0))]) is one
    assert mass_loop._best_as_drawn([(one, _heavier(leg, 6.0)), (other, leg)]) is other
