"""Notes on many recordings: those that differ in numbers and joints only are one line."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

MANY = 4  # recordings with a note of one form, from which they are told together: three lines are still read
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
_JOINT = "\0"


def grouped_notes(notes: Sequence[tuple[str, str]], joints: Sequence[str]) -> list[str]:
    """Lines of all ``notes``, each a recording's name and its text.

    A form of text that ``MANY`` recordings share is one line, ``27 of 34 recordings: ...``, in which each number is a
    range and each joint those named; the others follow with the name of their recording, in order. A form that one
    recording has for several joints is told joint by joint.
    """
    joint = re.compile("|".join(rf"\b{re.escape(name)}\b" for name in sorted(joints, key=len, reverse=True)) or r"(?!)")
    of_any = [_NUMBER.sub("0", joint.sub(_JOINT, text)) for _, text in notes]
    times = Counter((name, form) for (name, _), form in zip(notes, of_any, strict=True))
    repeated = {form for (_, form), number in times.items() if number > 1}
    forms = [
        _NUMBER.sub("0", text) if form in repeated else form for (_, text), form in zip(notes, of_any, strict=True)
    ]
    sharing: dict[str, dict[str, str]] = {}
    for (name, text), form in zip(notes, forms, strict=True):
        sharing.setdefault(form, {})[name] = text
    count = len({name for name, _ in notes})
    # Texts of one recording that differ in numbers only are told as they are.
    together = {
        form: texts for form, texts in sharing.items() if len(texts) >= MANY and forms.count(form) == len(texts)
    }
    lines = [
        f"{len(texts)} of {count} recordings: {_with_ranges(list(texts.values()), joints, joint)}"
        for texts in together.values()
    ]
    alone = (note for note, form in zip(notes, forms, strict=True) if form not in together)
    return [*lines, *(f"{name}: {text}" for name, text in alone)]


def _with_ranges(texts: Sequence[str], joints: Sequence[str], joint: re.Pattern[str]) -> str:
    """The common text, with the range of each number and the joints at each place."""
    named = [joint.findall(text) for text in texts]
    plain = [joint.sub(_JOINT, text) for text in texts]
    places = iter([_either([name for name in joints if name in column]) for column in zip(*named, strict=True)])
    ranges = iter([_range(column) for column in zip(*map(_NUMBER.findall, plain), strict=True)])
    text = _NUMBER.sub(lambda _: next(ranges), plain[0])
    return re.sub(_JOINT, lambda _: next(places), text)


def _range(numbers: Sequence[str]) -> str:
    low, high = min(numbers, key=float), max(numbers, key=float)
    return low if low == high else f"{low} to {high}"


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
