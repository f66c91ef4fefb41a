"""A recording that contradicts all others of its experiment: it is named, and not averaged in.

On its own such a file is well-formed: two columns exchanged, a sensor's sign, a clock in another unit. Each recording
is held against what all others say (leave one out).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from synth.errors import Problem, UserError

LEAST = 3  # recordings among which one can stand out
SHARE, TIMES = 0.1, 5.0  # of a recording that the others must miss, and times what they miss of each other


def refuse_odd(
    names: Sequence[str], missed: Callable[[int], tuple[float, float] | None], what: str, least_share: float = SHARE
) -> None:
    """Refuse recordings that the others do not explain, where these explain each other.

    Parameters
    ----------
    missed
        For a recording's place: the share of it that what all others say misses, and the largest share that it misses
        of any of these; None where the others say nothing.
    what
        Of what the share is, as in "the others miss 40 % of its torque".
    least_share
        A smaller share is never odd.

    Raises
    ------
    UserError : with every such recording.
    """
    if len(names) < LEAST:
        return
    problems = []
    for index, name in enumerate(names):
        found = missed(index)
        if found is not None and found[0] > max(TIMES * found[1], least_share):
            text = f"what the other recordings say misses {found[0]:.0%} of its {what}, and {found[1]:.1%} of theirs; "
            problems.append(Problem(f"{text}are its columns exchanged, or is it another device's?", name))
    if problems:
        raise UserError(problems)
