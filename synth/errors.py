"""What went wrong because of the user's input, in words that say how to mend it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """One mistake in one place of the user's input.

    Parameters
    ----------
    text : what is wrong, with the value as written, what is allowed and how to write it.
    file : the file as the user named it, or None for the command line.
    line : 1-based line in that file, where known.
    key : dotted key path or column name, where there is one, e.g. ``joints.knee.link.mass``.
    """

    text: str
    file: str | None = None
    line: int | None = None
    key: str | None = None

    def __str__(self) -> str:
        place = self.file or ""
        if self.line is not None:
            place += f":{self.line}"
        parts = [part for part in (place, self.key) if part]
        return ": ".join([*parts, self.text])


class UserError(Exception):
    """Input that cannot be used. The command line prints every problem and exits with status 2."""

    def __init__(self, problems: Problem | str | list[Problem]) -> None:
        if isinstance(problems, str):
            problems = Problem(problems)
        self.problems: list[Problem] = problems if isinstance(problems, list) else [problems]
        super().__init__("\n".join(str(problem) for problem in self.problems))
