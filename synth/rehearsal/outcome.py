"""The outcome of one planted case: what was planted, the diagnosis, and whether it was right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from synth.rehearsal.plants import LIBRARY, PlantingTask

Key = tuple[str, str]  # effect and joint
CANNOT, FAILED = "cannot", "failed"  # the joint cannot have such a cause; the diagnosis failed


@dataclass(frozen=True)
class CaseOutcome:
    """One case.

    ``planted`` : the main cause, None if there was none or it was not possible; ``gap`` rad and ``size`` (SI, see
    ``sizes.MEANING``) of it; ``small`` : additional causes. ``verdict`` : of the diagnosis, ``cannot`` or ``failed``;
    ``named`` : its causes, the most probable first; ``probability`` of the first; ``shrink`` : the reduction of the
    gap that it states for the first. ``message`` : the end of the error output if the diagnosis failed.
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
    seconds: float
    message: str = ""

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
    def right(self) -> bool:
        """Right if the main cause is named; if unlisted, for unknown; if there is none, for no absent cause named."""
        if self.kind == "cause":
            return self.planted in self.named
        if self.kind == "unlisted":
            return self.verdict == "unknown"
        return not set(self.named) - set(self.small)

    @property
    def taken_for(self) -> str:
        """The diagnosis in words: ``coulomb_friction (knee)``, ``none``, ``unknown``."""
        if not self.counts:
            return self.verdict
        if self.planted is not None and self.planted in self.named:
            return _words(self.planted)
        return _words(self.named[0]) if self.named else self.verdict

    def as_json(self) -> dict[str, Any]:
        """One entry of ``plants`` in the result; also stored for an interrupted run."""
        return {
            "effect": self.task.effect,
            "joint": self.task.joint,
            "rung": self.task.rung,
            "draw": self.task.draw,
            "planted": None if self.planted is None else list(self.planted),
            "form": self.form,
            "gap": self.gap,
            "size": self.size,
            "small": [list(key) for key in self.small],
            "verdict": self.verdict,
            "named": [list(key) for key in self.named],
            "probability": self.probability,
            "seconds": self.seconds,
            "message": self.message,
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> CaseOutcome:
        """The inverse of ``as_json``."""
        task = PlantingTask(content["effect"], content["joint"], content["rung"], content["draw"])
        planted = content["planted"]
        return cls(
            task,
            None if planted is None else (planted[0], planted[1]),
            content["form"],
            content["gap"],
            content["size"],
            _keys(content["small"]),
            content["verdict"],
            _keys(content["named"]),
            content["probability"],
            content["seconds"],
            content["message"],
        )


def named_causes(document: Mapping[str, Any]) -> tuple[Key, ...]:
    """Causes named by a ``gap.json``: those of the explanation first, the most probable first, then tied ones."""
    if document["verdict"] not in ("effect", "tie"):
        return ()
    order = [(c["effect"], c["joint"]) for c in document["ranked"]]
    named = [(c["effect"], c["joint"]) for each in (document["explanation"], *document["tied"]) for c in each]
    return tuple(sorted(dict.fromkeys(named), key=lambda key: order.index(key) if key in order else len(order)))


def _keys(pairs: Sequence[Sequence[str]]) -> tuple[Key, ...]:
    return tuple((effect, joint) for effect, joint in pairs)


def _words(key: Key) -> str:
    return f"{key[0]} ({key[1]})"
