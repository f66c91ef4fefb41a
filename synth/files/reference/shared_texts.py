"""Meanings of keys that several kinds of file share."""

from __future__ import annotations

KIND = "What kind of file this is; the first line."
NAME = "A title for the reports."
SEED = "Seed of everything random; the same seed gives the same result."
TRIALS = "The recordings: files, globs, or mappings with the conditions of a trial."
LEG = "The leg file, relative to this file."


def remark_texts(key: str) -> dict[str, str]:
    """Meanings of the fields of a list of warnings under ``key``."""
    return {
        f"{key}[].text": "The warning.",
        f"{key}[].severity": "How much it matters.",
        f"{key}[].remedy": "What to do about it.",
    }
