"""Code needed amid a computation is compiled as one announced stage, and no more of it than is needed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from synth.compiling import code_cache
from synth.compiling.announced import announced, told_to
from synth.swing.active_effects import ActiveEffects
from synth.swing.chain import compiled_chain
from synth.swing.chain_modules import LAWS
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

STAGES: list[str] = []


@contextmanager
def stage(text: str) -> Iterator[None]:
    STAGES.append(text)
    yield
    STAGES.append("end")


@dataclass
class Source:
    """A module whose code is on disk or not; loading it stores it."""

    name: str
    on_disk: bool
    parts: tuple[str, ...] = ()

    def load(self) -> None:
        STAGES.append(self.name)
        self.on_disk = True


@pytest.mark.parametrize("kept", [False, True])
def test_the_code_of_the_laws_is_announced_once(monkeypatch: pytest.MonkeyPatch, kept: bool) -> None:
    """A first fit announced 3 to 6 s, and compiled 36 s more silently under "fitting"."""
    monkeypatch.setattr(code_cache, "compile_aside", lambda *_: None)
    chain = compiled_chain(2)
    sources: Any = {name: Source(name, kept) for name in chain.sources}
    chain = replace(chain, sources=sources)
    STAGES.clear()
    with told_to(stage):
        chain.load_laws()
        chain.load_laws()
    if kept:
        assert STAGES == []
        return
    assert STAGES[0].startswith("compiling the equations of motion with friction")
    assert "once on this machine" in STAGES[0]
    assert STAGES[1:] == [*LAWS, "end"]


def test_nobody_is_told_after_the_block() -> None:
    STAGES.clear()
    with told_to(stage):
        pass
    with announced("compiling"):
        pass
    assert STAGES == []


def test_laws_without_memory_need_no_integrator_with_servos() -> None:
    """A first fit compiled it, 22 of 48 s of processor, for hardening springs and quadratic damping."""
    chain = compiled_chain(1)
    rest = {name: source for name, source in chain.sources.items() if name != "integrator"}
    assert len(replace(chain, sources=rest)._smooth) == 5


@pytest.mark.parametrize("law", ["hardening_spring", "quadratic_damping"])
def test_the_short_integrator_takes_the_same_steps(monkeypatch: pytest.MonkeyPatch, law: str) -> None:
    chain, times = compiled_chain(2), np.linspace(0.0, 0.5, 51)
    link = Link(length=0.1, mass=0.05, com=0.05, inertia=5e-5)
    leg = Leg("two", tuple(Joint(name, link, Spring(0.08, 0.1), Damper(1e-3)) for name in ("hip", "knee")))
    lanes = np.repeat(chain.parameters(leg)[:, None], 20, axis=1)
    lanes[chain.layout.rows("rotation")] = np.linspace(-0.6, 0.7, 40).reshape(2, 20)
    effect = effect_named(law)
    strength = chain.layout.parameter_rows(law, effect.index(effect.strengths[0]))
    lanes[strength] = 0.02
    short = chain.run(lanes, times)
    monkeypatch.setattr(ActiveEffects, "needs_whole", staticmethod(lambda active: True))
    np.testing.assert_allclose(short, chain.run(lanes, times), rtol=0.0, atol=1e-12)
    lanes[strength] = 0.0
    assert np.abs(short - chain.run(lanes, times)).max() > 1e-3  # the law acts


def test_friction_alone_does_not_need_the_other_integrator() -> None:
    """It was compiled with it, though it was not called: half of the whole compilation."""
    chain = compiled_chain(1)
    rest = {name: source for name, source in chain.sources.items() if name != "integrator"}
    assert len(replace(chain, sources=rest)._rubbing) == 5
