"""The outcome of one planted case: what was planted, the diagnosis, and whether it was right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from synth.rehearsal.plants import LIBRARY, PlantingTask

Key = tuple[str, str]  # effect and joint
CANNOT, FAILED = "cannot", "failed"  # no such cause can be planted there, or not as large; the diagnosis failed
TIED, TIE = "tied with others", "tie of others"  # columns of the confusion matrix


@dataclass(frozen=True)
class CaseOutcome:
    """One case.

    ``planted`` : the main cause, None if there was none or it was not possible; ``gap`` rad and ``size`` (SI, see
    ``sizes.SIZE_MEANINGS``) of it; ``small`` : additional causes, which leave ``small_gap`` rad together. ``verdict`` :
    of the diagnosis, ``cannot`` or ``failed``; ``named`` : the causes of all its explanations, the most probable first;
    ``probability`` of the first. ``explanations`` : the accepted one and those tied with it; None: one only.
    ``message`` : how the diagnosis ended if it failed, and the end of its error output; of what cannot be planted the
    reason, empty if it can, but not as large. ``truth`` : the built ``leg`` where it differs from the designed one, and
    all ``causes`` with their numbers, SI.
    """

    task: PlantingTask
    planted: Key | None
    form: str
    gap: float
    size: float | None
    small: tuple[Key, ...]
    verdict: str
    named: tuple[Key, ...]
    probability: float
    message: str = ""
    explanations: tuple[tuple[Key, ...], ...] | None = None
    small_gap: float = 0.0
    truth: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """``cause`` of the library, ``unlisted`` (outside the library), or ``nothing``."""
        if not self.task.effect:
            return "nothing"
        return "cause" if self.task.effect in LIBRARY else "unlisted"

    @property
    def counts(self) -> bool:
        """Whether the case was planted and diagnosed."""
        return self.verdict not in (CANNOT, FAILED)

    @property
    def agreed(self) -> tuple[Key, ...]:
        """Causes that the diagnosis names: those in each of its explanations. What only some of a tie hold is open."""
        if self.explanations is None:
            return self.named
        return tuple(key for key in self.named if all(key in each for each in self.explanations))

    @property
    def right(self) -> bool:
        """Right if the main cause is named; if unlisted, for unknown; if there is none, for no absent cause at all."""
        if self.kind == "cause":
            return self.planted in self.agreed
        if self.kind == "unlisted":
            return self.verdict == "unknown"
        return not set(self.named) - set(self.small)

    @property
    def tied(self) -> bool:
        """Whether some of the tied explanations are true: hold the main cause, without one no absent cause."""
        if self.kind == "unlisted" or self.right:
            return False
        if self.kind == "cause":
            return self.planted in self.named
        return any(set(each) <= set(self.small) for each in self.explanations or ())

    @property
    def tied_with(self) -> tuple[str, ...]:
        """The causes that may be there instead of the main one, in words; empty if it is not tied.

        Those of the explanations without it, but for planted ones and those that stand beside it in another.
        """
        if not self.tied:
            return ()
        explanations = self.explanations or (self.named,)
        beside = {key for each in explanations if self.planted in each for key in each}
        instead = {key for each in explanations if self.planted not in each for key in each}
        return tuple(_cause_words(key) for key in self.named if key in instead - beside - {*self.small})

    @property
    def with_absent(self) -> bool:
        """Whether the main cause is named together with a cause that was not planted."""
        return self.right and self.kind == "cause" and bool({*self.agreed} - {*self.small, self.planted})

    @property
    def taken_for(self) -> str:
        """The diagnosis in words: ``coulomb_friction (knee)``, ``none``, ``unknown``; of a tie, all its causes."""
        if self.verdict == CANNOT:
            return f"cannot be planted: {self.message}" if self.message else "cannot be planted as large"
        if not self.counts:
            return self.verdict
        if self.planted is not None and self.planted in self.agreed:
            return _cause_words(self.planted)
        if self.agreed:
            absent = [key for key in self.agreed if key not in self.small]
            return _cause_words((absent or self.agreed)[0])
        return f"tie of {', '.join(_cause_words(key) for key in self.named)}" if self.named else self.verdict

    @property
    def diagnosis(self) -> str:
        """The same in a word, for a table: ties are ``TIED`` with the main cause among theirs, ``TIE`` without it."""
        if self.tied:
            return TIED
        return TIE if self.counts and self.named and not self.agreed else self.taken_for

    def as_json(self) -> dict[str, Any]:
        """One entry of ``plants`` in the result; also stored for an interrupted run."""
        return {
            "name": self.task.name,
            "effect": self.task.effect,
            "joint": self.task.joint,
            "rung": self.task.rung,
            "draw": self.task.draw,
            "planted": None if self.planted is None else list(self.planted),
            "form": self.form,
            "gap": self.gap,
            "size": self.size,
            "small": [list(key) for key in self.small],
            "small_gap": self.small_gap,
            "truth": dict(self.truth),
            "verdict": self.verdict,
            "named": [list(key) for key in self.named],
            "probability": self.probability,
            "message": self.message,
            "explanations": None if self.explanations is None else [[list(k) for k in e] for e in self.explanations],
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> CaseOutcome:
        """The inverse of ``as_json``."""
        task = PlantingTask(content["effect"], content["joint"], content["rung"], content["draw"])
        planted, explanations = content["planted"], content["explanations"]
        return cls(
            task,
            None if planted is None else (planted[0], planted[1]),
            content["form"],
            content["gap"],
            content["size"],
            _cause_keys(content["small"]),
            content["verdict"],
            _cause_keys(content["named"]),
            content["probability"],
            content["message"],
            None if explanations is None else tuple(_cause_keys(each) for each in explanations),
            content["small_gap"],
            content["truth"],
        )


def named_causes(document: Mapping[str, Any]) -> tuple[Key, ...]:
    """Causes in some explanation of a ``gap.json``, the most probable first."""
    order = [(c["effect"], c["joint"]) for c in document["ranked"]]
    named = [key for each in explanations_of(document) for key in each]
    return tuple(sorted(dict.fromkeys(named), key=lambda key: order.index(key) if key in order else len(order)))


def explanations_of(document: Mapping[str, Any]) -> tuple[tuple[Key, ...], ...]:
    """The explanation of a ``gap.json`` and those tied with it; none where its verdict names no cause."""
    if document["verdict"] not in ("effect", "tie"):
        return ()
    each = (document["explanation"], *document["tied"])
    return tuple(tuple((cause["effect"], cause["joint"]) for cause in causes) for causes in each)


def _cause_keys(pairs: Sequence[Sequence[str]]) -> tuple[Key, ...]:
    return tuple((effect, joint) for effect, joint in pairs)


def _cause_words(key: Key) -> str:
    return f"{key[0]} ({key[1]})"
