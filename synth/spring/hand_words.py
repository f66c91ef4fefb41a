"""The hands of several equal springs in words."""

from __future__ import annotations

from collections.abc import Sequence


def hand_words(hands: Sequence[str]) -> str:
    """``right-hand`` of one, ``all right-hand`` of equal ones, ``one right-hand, one left-hand`` of a pair."""
    if len(set(hands)) > 1:
        return ", ".join(f"one {hand}-hand" for hand in hands)
    return f"{'all ' if len(hands) > 1 else ''}{hands[0]}-hand"
