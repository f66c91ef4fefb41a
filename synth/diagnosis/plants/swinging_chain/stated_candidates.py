"""Candidates at the places of effects that the leg file states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from synth.diagnosis.absent_effects import with_absent_effects
from synth.diagnosis.angle_search import search
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.odds import Calibration
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.plants.swinging_chain.stated_forms import in_stated_forms
from synth.diagnosis.workbench import Workbench
from synth.estimation.parameters import Shape
from synth.swing.stated_effects import COUNTS, REPLACED_WAYS, Place, stated_effects

ABSENT = Shape((), {})


def search_from_stated(
    bench: Workbench, found: Sequence[Candidate], calibration: Calibration, say: Callable[[str], None]
) -> Hypotheses[EvaluatedHypothesis]:
    """How well each cause, and each promising combination, explains the trials; stated effects may be left out."""
    formed = in_stated_forms(found)
    return with_absent_effects(bench, search(bench, formed, calibration, say), absent_effects(found), calibration)


def absent_effects(found: Sequence[Candidate]) -> list[Candidate]:
    """Each stated effect that a candidate takes the place of, in the shape in which it is not there."""
    made: dict[Place, Candidate] = {}
    for candidate in found:
        stated = {each.place for way in REPLACED_WAYS for each in stated_effects(candidate.leg, way)}
        if candidate.place in stated and candidate.effect.name != COUNTS:
            made.setdefault(candidate.place, replace(candidate, shape=ABSENT))
    return list(made.values())
