"""Joints' names in ROS 1's ``rostopic echo -p`` of joint states: field.name0 tells whose field.position0 is.

The order is the publisher's, often the alphabet's, and not the limb's. Units are those of ``sensor_msgs/JointState``;
the clock ``%time`` is the stamp in ns (ros_comm, ``rostopic``, ``CallbackEcho``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from synth.errors import Problem, UserError
from synth.motion.importers.foreign_data import MISSING

_NAME = re.compile(r"(.*\.)name(\d+)")
CLOCK = "time"  # without the mark of its comment
QUANTITIES = {"position": ("", "rad"), "velocity": (" velocity", "rad/s"), "effort": (" effort", "N*m")}


def echoed_joints(
    titles: Sequence[str], rows: Sequence[Sequence[str]], lines: Sequence[int], name: str
) -> dict[int, tuple[str, str]]:
    """By the index of a column: its name, of the joint and the quantity as of a robot's log, and its unit.

    ``rows`` : the cells below the header, ``lines`` : their numbers in the file ``name``.

    Raises
    ------
    UserError : a column of names changes: the columns are of one joint and then of another.
    """
    places = {title: index for index, title in enumerate(titles)}
    found: dict[int, tuple[str, str]] = {}
    for title, index in places.items():
        match = _NAME.fullmatch(title)
        if match is None or f"{match[1]}position{match[2]}" not in places:
            continue
        cells = [(row[index].strip(), line) for row, line in zip(rows, lines, strict=True) if index < len(row)]
        cells = [(cell, line) for cell, line in cells if cell.casefold() not in MISSING]
        other = next(((cell, line) for cell, line in cells if cell != cells[0][0]), None)
        if other is not None:
            text = (
                f'is "{other[0]}" after "{cells[0][0]}": the columns are of other joints from row to row; import the '
            )
            raise UserError(
                Problem(f"{text}bag itself, or write one message's joints to a file", name, other[1], title)
            )
        for quantity, (suffix, unit) in QUANTITIES.items():
            place = places.get(f"{match[1]}{quantity}{match[2]}")
            if place is not None and cells:
                found[place] = f"{cells[0][0]}{suffix}", unit
    if found and CLOCK in places:
        found[places[CLOCK]] = CLOCK, "ns"
    return found
