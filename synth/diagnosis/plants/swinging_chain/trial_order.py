"""The order in which a diagnosis takes the trials: by file name, whatever the order of the project's list.

Sums over trials round in another way in another order. Dry friction makes the cost rough, and a search on it can then
end in another minimum, and the odds of explanations that lie near each other differ. Resampling and the folds of trials
left out go by their place as well.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TypeVar

from synth.files.trial_list import Trial

T = TypeVar("T")


def in_canonical_order(trials: Sequence[Trial]) -> list[Trial]:
    """The trials by name, numbers in it by size (``t2`` before ``t10``), and by content where names are equal."""
    return sorted(trials, key=lambda trial: (_words_and_numbers(trial.name), trial.name, trial.sha256))


def as_listed(names: Sequence[str], items: Sequence[T], trials: Sequence[Trial]) -> tuple[T, ...]:
    """The ``items`` of recordings with these ``names``, in the order of the project's list."""
    place = {trial.name: k for k, trial in enumerate(trials)}
    order = sorted(range(len(items)), key=lambda k: place[names[k]])
    return tuple(items[k] for k in order)


def _words_and_numbers(name: str) -> list[tuple[str, int]]:
    """The name as words, each with the number that follows it; 0 where none does."""
    parts = re.findall(r"(\D*)(\d*)", name)
    return [(word, int(number or 0)) for word, number in parts]
