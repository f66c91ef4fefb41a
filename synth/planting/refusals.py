"""Why a cause cannot be planted."""

from __future__ import annotations


class NotApplicable(Exception):
    """The effect cannot act, or cannot be seen, at this joint in these trials."""


class TooSmall(NotApplicable):
    """It acts, but its largest size leaves a smaller gap than asked for."""
