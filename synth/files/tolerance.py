"""Uncertainty from manufacturing and measurement: the ``tolerance:`` of ``gap``, ``fit``, ``leg``, ``reproduce``.

``tolerance: {mass: 1 %, knee: {mass: 5 %, damper: 20 %}}``: for all joints, with deviating values for a joint and
its link under the joint's name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import radians
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synth.arrays import Array
from synth.drives.servo import Servo, TorqueDrive
from synth.errors import Problem
from synth.files.made_in_code import check_section, check_values
from synth.files.named_files import ProjectReader
from synth.files.schema import Because, Default, read_section
from synth.files.validate import BARE_DEVIATION, Quantity
from synth.files.yaml_lines import Document
from synth.swing.leg_model import Joint, Leg
from synth.swing.tolerances import LINK_QUANTITIES, MOTOR_POWERS, QUANTITIES
from synth.units import quantity

HALF_DEGREE = radians(0.5)  # typical of manual assembly to a drawn angle: our estimate
MOST = 0.5  # a quantity with a larger deviation is unknown, and nothing can be inferred from it

Share = Annotated[float, Quantity("1", least=0, most=MOST, bare=BARE_DEVIATION)]
Turn = Annotated[float, Quantity("rad", least=0, most=radians(90))]

_USUAL = "usual for a leg that was measured after it was built"


@dataclass(frozen=True)
class JointTolerance:
    """Standard deviations of a joint's and its link's numbers.

    Shares of the nominal value; ``free_angle`` in rad. Zero: known exactly, so that any deviation counts as an
    effect.
    """

    length: Annotated[Share, Because(_USUAL)] = 0.005
    mass: Annotated[Share, Because(_USUAL)] = 0.01
    com: Annotated[Share, Because(_USUAL)] = 0.01
    inertia: Annotated[Share, Because(_USUAL)] = 0.02
    spring: Annotated[Share, Because("remaining uncertainty of a measured spring rate")] = 0.03
    damper: Annotated[Share, Because("remaining uncertainty of a measured damper rate")] = 0.05
    free_angle: Annotated[Turn, Because("assembly error of the spring's free angle"), Field(examples=["2 deg"])] = (
        HALF_DEGREE
    )
    torque_constant: Annotated[Share, Because("usual between motors of one batch; for joints with a motor")] = 0.1
    resistance: Annotated[Share, Because("usual for a winding, with its temperature; for joints with a motor")] = 0.1


@dataclass(frozen=True)
class Tolerance(JointTolerance):
    """The same for every joint except ``joints``: name of a joint -> deviating quantities."""

    joints: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def of_joint(self, name: str) -> JointTolerance:
        """The tolerances of one joint."""
        common = {item.name: getattr(self, item.name) for item in fields(JointTolerance)}
        return JointTolerance(**{**common, **self.joints.get(name, {})})

    def widths(self, leg: Leg, by_current: Sequence[int] = ()) -> Array:
        """(9, n) standard deviation of each quantity, in the order of the fields, at each joint.

        Those of a motor are 0 for a joint without a motor, or whose motor's torque is known; not that of the constant
        at the joints ``by_current``, whose torque is a recorded current times it.
        """
        found = [self.of_joint(name) for name in leg.joint_names]
        width = np.array([[getattr(one, item.name) for one in found] for item in fields(JointTolerance)])
        motors = np.array([_has_motor(joint) for joint in leg.joints])
        width[QUANTITIES.index("torque_constant")] *= motors | np.isin(np.arange(len(motors)), by_current)
        width[QUANTITIES.index("resistance")] *= motors
        return width


def read_tolerance(reader: ProjectReader, leg: Leg | None, key: str = "tolerance") -> Tolerance | None:
    """The project's tolerances, with applied defaults recorded; None after a mistake, which ``reader`` holds.

    ``leg`` None: it could not be read; names of joints are then not checked.
    """
    found = _read(reader, leg, key)
    if leg is None or not any(_has_motor(joint) for joint in leg.joints):
        motors = {f"{key}.{name}" for name in MOTOR_POWERS}
        if leg is not None and any(_has_known_current(joint) for joint in leg.joints):
            motors.remove(f"{key}.torque_constant")
        reader.defaults[:] = [default for default in reader.defaults if default.key not in motors]
    return found


def check_tolerance(given: Tolerance, place: Document, problems: list[Problem]) -> None:
    """Check the values of tolerances made in code as a file's are; mistakes go to ``problems``."""
    known = {item.name for item in fields(JointTolerance)}
    check_section(Tolerance, given, place, ("tolerance",), problems, JointTolerance)
    for name, own in given.joints.items() if isinstance(given, Tolerance) else ():
        values = {quantity: value for quantity, value in own.items() if quantity in known}
        check_values(JointTolerance, values, place, ("tolerance", name), problems)


def _has_known_current(joint: Joint) -> bool:
    """Whether it is driven by a motor whose current is recorded."""
    return isinstance(joint.drive, TorqueDrive) and joint.drive.motor is not None


def _has_motor(joint: Joint) -> bool:
    """Whether it is driven by a motor of unknown torque."""
    return isinstance(joint.drive, Servo) and joint.drive.motor is not None


def _read(reader: ProjectReader, leg: Leg | None, key: str) -> Tolerance | None:
    written = reader.written.get(key)
    if not isinstance(written, Mapping):
        common = reader.section(JointTolerance, key)
        return None if common is None else Tolerance(**vars(common))
    names = leg.joint_names if leg is not None else ()
    own = {name: value for name, value in written.items() if isinstance(value, Mapping) or name in names}
    rest = {name: value for name, value in written.items() if name not in own}
    before = len(reader.problems)
    common = read_section(JointTolerance, reader.document, (key,), reader.problems, reader.defaults, rest)
    if leg is not None:
        reader.known_joints(own, leg, (key,))
    joints = {name: _of_joint(reader, value, key, name) for name, value in own.items()}
    if common is None or len(reader.problems) > before:
        return None
    return Tolerance(**vars(common), joints=joints)


def _of_joint(reader: ProjectReader, value: Any, key: str, name: str) -> dict[str, float]:
    """The quantities that are given for one joint."""
    if not isinstance(value, Mapping):
        reader.refuse(f"{value!r} is not a mapping of tolerances: write {name}: {{mass: 5 %}}", (key, name))
        return {}
    found = reader.entry(JointTolerance, (key, name), dict(value))
    return {} if found is None else {quantity: getattr(found, quantity) for quantity in value}


def links_json(tolerance: Tolerance, leg: Leg) -> dict[str, Any]:
    """The uncertainty of each joint's link and motor for ``fit.json``, as standard deviations."""
    found: dict[str, Any] = {}
    for joint in leg.joints:
        one = tolerance.of_joint(joint.name)
        motor = tuple(MOTOR_POWERS) if _has_motor(joint) else ("torque_constant",) if _has_known_current(joint) else ()
        found[joint.name] = {item: quantity(getattr(one, item), "%") for item in (*LINK_QUANTITIES, *motor)}
    return found


def of_links(defaults: Sequence[Default]) -> list[Default]:
    """The defaults except those of springs, dampers and free angles, which a fit estimates."""
    sought = {"tolerance.spring", "tolerance.damper", "tolerance.free_angle"}
    return [default for default in defaults if default.key not in sought]
