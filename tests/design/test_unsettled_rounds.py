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


def _weigh_wrongly(monkeypatch: pytest.MonkeyPatch, factors: Iterable[float]) -> None:
    """Links of ``factors`` times their mass, drawing by drawing."""
    found, left = mass_loop.JointWeights.on_links, iter(factors)

    def wrong(self: Any, design: Any) -> Any:
        leg, factor = found(self, design), next(left)
        links = [replace(j.link, mass=factor * j.link.mass, inertia=factor * j.link.inertia) for j in leg.joints]
        return replace(leg, joints=tuple(replace(j, link=k) for j, k in zip(leg.joints, links, strict=True)))

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
