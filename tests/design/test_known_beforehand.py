"""What a design computes of the animal, whatever the robot's links."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from synth.api.report import silent
from synth.design import leg_design


@dataclass(frozen=True)
class FittedSource:
    """The fields of a fit that are read or replaced."""

    cut: float
    warnings: tuple[str, ...] = ()
    wanted: object = None


def test_a_fit_that_begins_late_is_doubted_by_whole_recordings(monkeypatch: pytest.MonkeyPatch) -> None:
    """The doubts cut them where the fit begins: given the cut ones, they took the start off twice."""
    after = SimpleNamespace(fitted=("after the cut",), held_out=(), notes=())
    motion = SimpleNamespace(fitted=("whole",), held_out=(), notes=("noted",), cut=lambda _: after)
    project: Any = SimpleNamespace(source=None, release="free", fit=None, wanted_legs=(), wanted_shown=None, dampers={})

    @dataclass(frozen=True)
    class Options:
        release: str = "free"
        computed: bool = False

    seen = []

    def doubted(_: object, recordings: object, source: FittedSource) -> tuple[str, ...]:
        seen.append((recordings, source.cut))
        return ("doubt",)

    replaced = {
        "fit_options": lambda _: Options(),
        "read_motion": lambda _: motion,
        "fit_by": lambda *_: FittedSource(0.1, ("of the fit",)),
        "with_held_out": lambda source, _: source,
        "with_other_legs": lambda source, _: source,
        "doubts": doubted,
        "damper_laws": lambda _: {},
        "measured_curves": lambda *_: {},
    }
    for name, fake in replaced.items():
        monkeypatch.setattr(leg_design, name, fake)
    known = leg_design.known_beforehand(project, silent)
    assert seen == [(("whole",), 0.1)]
    assert known.motion is after  # type: ignore[comparison-overlap]
    assert known.source.warnings == ("noted", "doubt", "of the fit")
