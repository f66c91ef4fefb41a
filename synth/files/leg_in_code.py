"""A leg made in code, checked as one that is read: it is written in the form of its file, in SI, and this is checked.

A key in a message is the attribute's name, an item of a list by its name or number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from numbers import Integral, Real
from typing import Any, get_args

import numpy as np
from pydantic.fields import FieldInfo

from synth import units
from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.errors import Problem
from synth.files.curve import checked_curve
from synth.files.drive import drive_text
from synth.files.leg_file import leg_of
from synth.files.leg_keys import DamperKeys, JointKeys, LegKeys, LinkKeys, SpringKeys
from synth.files.made_in_code import number_fault, other_class, with_hint
from synth.files.schema import quantity_of
from synth.files.validate import FileModel, Quantity, gathering, raise_if_any
from synth.files.yaml_lines import Document, Key
from synth.swing.effects import registered
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

PARTS: dict[str, tuple[type[FileModel], type[Any]]] = {
    "link": (LinkKeys, Link),
    "spring": (SpringKeys, Spring),
    "damper": (DamperKeys, Damper),
}
# Of a drive: infinite where there is none, or not known.
UNBOUNDED = ("torque_limit", "current_limit", "integral_limit", "resistance")
EFFECTS = '{"coulomb_friction": {"torque": 0.05}}'
ABSENT = object()


def check_leg(leg: object, place: Document) -> None:
    """Check a leg made in code as its file is checked.

    ``place`` : where it is, for messages, see ``in_code``. Parts are not looked up: a spring or damper has its numbers.

    Raises
    ------
    UserError
        With every mistake: attribute, value, and what is allowed.
    """
    written = _Written()
    value = written.mapping(LegKeys, Leg, leg, ())
    document = Document(place.path, place.name, {"kind": "leg", **(value or {})}, {}, b"")
    problems = [document.problem(text, key) for text, key in written.faults]
    if not problems:
        leg_of(document, problems, curve_of=lambda name: written.curves[name])
    raise_if_any([with_hint(problem) for problem in problems])


@dataclass
class _Written:
    """Objects as mappings of a file; ``faults`` : text and key of what cannot be written; ``curves`` of dampers."""

    faults: list[tuple[str, Key]] = field(default_factory=list)
    curves: dict[str, DamperCurve] = field(default_factory=dict)

    def mapping(self, keys: type[FileModel], wanted: type[Any], given: object, key: Key) -> dict[str, Any] | None:
        """An object of class ``wanted`` with the keys of its section; None if it is another one."""
        if not isinstance(given, wanted):
            self.faults.append((other_class(given, wanted), key))
            return None
        made = {}
        for name, info in keys.model_fields.items():
            value = getattr(given, name, ABSENT)
            left_out = value is None and name != "effects" and type(None) in get_args(info.annotation)
            if value is not ABSENT and not left_out:
                made[name] = self.value(name, value, info, (*key, name))
        return made

    def value(self, name: str, value: Any, info: FieldInfo, key: Key) -> object:
        """An attribute as its key in a file holds it."""
        if name in PARTS:
            return self.mapping(*PARTS[name], value, key)
        if name in ("joints", "range"):
            return self.items(name, value, info, key)
        if name in ("effects", "drive", "curve"):
            return getattr(self, name)(value, key)
        quantity = _quantity(info)
        if quantity is not None:
            return self.number(value, quantity.unit, key)
        return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else value

    def number(self, value: Any, unit: str, key: Key) -> str | None:
        """A number in SI with its unit."""
        fault = number_fault(value, unit)
        if fault:
            self.faults.append((fault, key))
            return None
        return units.write(float(value), unit)

    def items(self, name: str, value: Any, info: FieldInfo, key: Key) -> list[Any] | None:
        """The joints, or the two ends of a range."""
        if not isinstance(value, (tuple, list)):
            how = "(synth.Joint(...),)" if name == "joints" else "(1.0, 2.6), in rad"
            self.faults.append((f"{value!r:.80} is not allowed: in code this is a tuple, {how}", key))
            return None
        if name == "joints":
            return [self.mapping(JointKeys, Joint, joint, (*key, index)) for index, joint in enumerate(value)]
        return [self.number(end, "rad", (*key, index)) for index, end in enumerate(value)]

    def effects(self, given: Any, key: Key) -> list[dict[str, dict[str, Any]]]:
        """Effects as a file lists them."""
        if not isinstance(given, Mapping) or not all(isinstance(values, Mapping) for values in given.values()):
            self.faults.append((f"{given!r:.80} is not allowed: in code this is a mapping, {EFFECTS}", key))
            return []
        # Asked only where there are some, because their laws load the compiler.
        known = {effect.name: effect for effect in registered()} if given else {}
        made = []
        for index, (name, values) in enumerate(given.items()):
            unit = {parameter.name: parameter.unit for parameter in known[name].parameters} if name in known else {}
            one = {
                parameter: self.number(value, unit.get(parameter, "1"), (*key, index, str(name), str(parameter)))
                for parameter, value in values.items()
            }
            made.append({name: one})
        return made

    def drive(self, given: Any, key: Key) -> dict[str, Any] | None:
        """A servo, or a motor of known torque."""
        faults = len(self.faults)
        if not isinstance(given, (Servo, TorqueDrive)):
            self.faults.append((f"{given!r:.80} is no Servo or TorqueDrive", key))
            return None
        self.drive_numbers(given, key)
        motor = given.motor
        if isinstance(motor, GearedMotor):
            self.drive_numbers(motor, (*key, "motor"))
        elif motor is not None:
            self.faults.append((f"{motor!r:.80} is no GearedMotor", (*key, "motor")))
        return drive_text(given) if len(self.faults) == faults else None

    def drive_numbers(self, given: Servo | TorqueDrive | GearedMotor, key: Key) -> None:
        """Faults of a drive's numbers, which are all in SI."""
        for item in fields(given):
            value = getattr(given, item.name)
            if item.name == "motor" or isinstance(value, bool) or (value is None and item.default is None):
                continue
            if not (item.name in UNBOUNDED and isinstance(value, Real) and value == math.inf):
                fault = number_fault(value, "the SI unit")
                self.faults += [(fault, (*key, item.name))] if fault else []

    def curve(self, given: Any, key: Key) -> str | None:
        """The name of a damper's curve, which is checked as its table is."""
        if not isinstance(given, DamperCurve):
            text = f"{given!r:.80} is no DamperCurve: write synth.DamperCurve((1.0, 4.0), (0.5, 0.8))"
            self.faults.append((text, key))
            return None
        columns = {"speed": given.speed, "torque": given.torque}
        arrays = [self.column(values, (*key, name)) for name, values in columns.items()]
        speed, torque = arrays
        if speed is None or torque is None:
            return None
        if len(speed) != len(torque):
            self.faults.append((f"has {len(speed)} speeds and {len(torque)} torques; each point needs both", key))
            return None
        if len(speed) and speed[0] == 0.0:
            self.faults.append(("leave the point at speed 0 out: in code (0, 0) is implied", key))
            return None
        problems: list[Problem] = []
        with gathering(problems):
            name = f"curve {len(self.curves) + 1}"
            self.curves[name] = checked_curve(speed, torque, lambda text, row: Problem(_of_point(text, row)))
            return name
        self.faults += [(problem.text, key) for problem in problems]
        return None

    def column(self, values: Any, key: Key) -> Array | None:
        """(n,) the speeds or the torques of a curve."""
        try:
            made = np.array(values, dtype=float)
        except (TypeError, ValueError):
            made = np.empty((0, 0))
        if made.ndim != 1 or not np.isfinite(made).all():
            self.faults.append((f"{values!r:.80} is not allowed: in code this is a tuple of numbers in SI", key))
            return None
        return made


def _of_point(text: str, row: int | None) -> str:
    return text if row is None else f"point {row + 1}: {text}"


def _quantity(info: FieldInfo) -> Quantity | None:
    """The quantity of a key; None if it has no unit."""
    marks = [mark for mark in info.metadata if isinstance(mark, Quantity)]
    return marks[0] if marks else quantity_of(info.annotation)
