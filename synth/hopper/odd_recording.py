"""A recording that contradicts all others of its experiment is named, and not averaged in.

Such a file is well-formed by itself: two exchanged columns, a sensor's sign, a clock in another unit. Each recording
is compared with the result of all others (leave one out).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from synth.errors import Problem, UserError

LEAST_RECORDINGS = 3  # recordings needed to identify a different one
SHARE, TIMES = 0.1, 5.0  # unexplained share of a recording, and its ratio to that of the others


def refuse_odd(
    names: Sequence[str], missed: Callable[[int], tuple[float, float] | None], what: str, least_share: float = SHARE
) -> None:
    """Refuse recordings that the others do not explain, if these explain each other.

    Parameters
    ----------
    missed
        For a recording's index: the share of it that the result of all others does not explain, and the largest such
        share of any of these; None if the others have no result.
    what
        The quantity of the share, as in "40 % of its torque".
    least_share
        A smaller share is never odd.

    Raises
    ------
    UserError : with every such recording.
    """
    if len(names) < LEAST_RECORDINGS:
        return
    problems = []
    for index, name in enumerate(names):
        found = missed(index)
        if found is not None and found[0] > max(TIMES * found[1], least_share):
            text = f"the other recordings leave {found[0]:.0%} of its {what} unexplained, of theirs {found[1]:.1%}; "
            problems.append(Problem(f"{text}are its columns exchanged, or is it from another device?", name))
    if problems:
        raise UserError(problems)
