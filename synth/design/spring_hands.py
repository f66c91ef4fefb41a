"""The hand of each spring of a joint: the one source for drawing, bill, quotation, page and warnings.

Of two springs the second is the mirror image of the first, as the joint is drawn: its lower arm is at the same floor,
so the turn that closes a right-hand coil above the floor closes a left-hand one below it. More than two are not drawn;
they are alike, as they stand beside each other turned the same way.
"""

from __future__ import annotations

from synth.design.choose_springs import SpringOption
from synth.files.spring_words import OTHER_HAND
from synth.remarks import decisive, noted


def hands_of(option: SpringOption) -> tuple[str, ...]:
    """The hand of each spring, the drawn one first; one whose catalogue states none is drawn right-hand."""
    if option.row is not None:
        first = option.row.hand or "right"
    else:
        assert option.design is not None
        first = option.design.hand
    return (first, OTHER_HAND[first]) if option.number == 2 else (first,) * option.number


def is_pair(option: SpringOption) -> bool:
    """Whether the springs are a mirrored pair, one of each hand."""
    return len(set(hands_of(option))) == 2


def hand_notes(joint: str, option: SpringOption) -> list[str]:
    """What is to be told of several springs that are drawn; none of one."""
    hands, row = hands_of(option), option.row
    if is_pair(option):
        how = "wind" if row is None else "order"
        which = [f"{hand}-hand" for hand in hands]
        if row is not None and row.hand and option.mirror is not None:
            which = [f"{part} ({hand})" for part, hand in zip((row.part, option.mirror.part), which, strict=True)]
        return [f"{joint}: two springs, drawn as a mirrored pair: {how} one {which[0]} and one {which[1]}"]
    if len(hands) > 1:
        return [
            noted(
                f"{joint}: {len(hands)} springs act in parallel; one is drawn, and the pocket is for one. All are "
                f"{hands[0]}-hand, as it is; one that you mount mirrored must be of the other hand"
            )
        ]
    return []


def unstated_hand(joint: str, option: SpringOption) -> list[str]:
    """That no catalogue states the hand of a drawn spring, for which three parts are printed; not of a pair."""
    row = option.row
    if row is None or row.hand or is_pair(option):
        return []
    hand = hands_of(option)[0]
    text = (
        f"{joint}: the catalogue does not say which way {row.part} is wound; drawn {hand}-hand. One of the other hand "
        "does not fit the printed lower part, upper part and seat"
    )
    remedy = (
        "Look which way it is wound before printing: a right-hand coil rises like a common screw's thread. If it is "
        "the other one, add a row of it with its hand under select.catalogs."
    )
    return [decisive(text, remedy)]


def hand_warnings(joint: str, option: SpringOption) -> list[str]:
    """A warning on a bought pair of which no catalogue has the spring of the other hand."""
    row = option.row
    if row is None or not is_pair(option) or option.mirror is not None:
        return []
    first, second = hands_of(option)
    known = (
        f"{row.part} is {first}-hand, and no catalogue has a {second}-hand spring of its sizes and rate"
        if row.hand
        else f"the catalogue does not state the hand of {row.part}"
    )
    remedy = (
        f"Ask {row.vendor or 'its vendor'} for both hands and add the row of the other under select.catalogs, have the "
        "pair wound (make: true), or use one spring (parallel: 1)."
    )
    return [decisive(f"{joint}: its two springs are mirrored, one of each hand, but {known}", remedy)]
