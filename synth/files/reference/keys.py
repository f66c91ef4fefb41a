"""Documentation of a schema class's keys: type, unit, range, default and its reason, example."""

from __future__ import annotations

import types
from collections.abc import Iterator
from dataclasses import dataclass, is_dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Le, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from synth.files.reference.sections import KeySection
from synth.files.reference.texts import TEXTS
from synth.files.schema import Because, Written, schema_model
from synth.files.validate import Quantity


@dataclass(frozen=True)
class KeyRow:
    """One key of a section; ``default`` None: required."""

    name: str
    type: str
    unit: str
    allowed: str
    default: str | None
    why: str
    meaning: str
    example: str


def model_of(section: KeySection) -> type[BaseModel]:
    """The pydantic model that checks the section."""
    schema = section.schema
    return schema_model(schema) if is_dataclass(schema) else schema


def rows(section: KeySection) -> list[KeyRow]:
    """The keys of a section in the order of its class.

    Raises
    ------
    KeyError
        For a key that has no text.
    """
    found = []
    for name, item in model_of(section).model_fields.items():
        written = next(marks(item, Written), None)
        quantity = next(marks(item, Quantity), written.each if written is not None else None)
        because = next(marks(item, Because), None)
        meaning = TEXTS[f"{section.name}.{name}"]
        found.append(
            KeyRow(
                name,
                _type(name, item, section),
                "" if quantity is None else quantity.shown if quantity.unit != "1" else "none, or %",
                _allowed(item, quantity),
                default_text(item, quantity, because),
                "" if because is None else because.reason,
                meaning,
                example(section, name, item, quantity),
            )
        )
    return found


def marks(item: FieldInfo, kind: type[Any]) -> Iterator[Any]:
    """Marks of a kind on a field, those inside unions and lists too."""
    yield from (mark for mark in item.metadata if isinstance(mark, kind))
    yield from _inside(item.annotation, kind)


def _inside(annotation: Any, kind: type[Any]) -> Iterator[Any]:
    if get_origin(annotation) is Annotated:
        base, *found = get_args(annotation)
        yield from (mark for mark in found if isinstance(mark, kind))
        yield from _inside(base, kind)
        for mark in found:
            if isinstance(mark, FieldInfo):
                yield from (own for own in mark.metadata if isinstance(own, kind))
        return
    for inner in get_args(annotation):
        if not isinstance(inner, str):
            yield from _inside(inner, kind)


def options(annotation: Any) -> list[Any]:
    """The members of a union without None and without Annotated, or the annotation itself."""
    if get_origin(annotation) is Annotated:
        return options(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [inner for option in get_args(annotation) if option is not type(None) for inner in options(option)]
    return [annotation]


def choices(item: FieldInfo) -> tuple[Any, ...]:
    """The allowed words or numbers, if they are few."""
    found = [option for option in options(item.annotation) if get_origin(option) is Literal]
    return tuple(value for option in found for value in get_args(option))


def _type(name: str, item: FieldInfo, section: KeySection) -> str:
    inner = section.inner.get(name)
    written = next(marks(item, Written), None)
    if written is not None:
        return str(written.type)
    if inner is not None:
        what = {"mapping": "mapping", "list": "list of mappings", "by name": "mapping, one key per joint"}[inner.how]
        return f"{what}: {inner.name.replace('_', ' ')}"
    if choices(item):
        return "one of the listed values"
    quantity = next(marks(item, Quantity), None)
    kinds = [get_origin(option) or option for option in options(item.annotation)]
    if any(kind in (list, tuple) for kind in kinds):
        return "list of quantities" if quantity is not None else "list"
    if dict in kinds:
        return "mapping of quantities" if quantity is not None else "mapping"
    if quantity is not None:
        return "quantity" if quantity.unit != "1" else "number"
    words = {str: "text", bool: "true or false", int: "whole number", float: "number"}
    return next((words[kind] for kind in kinds if kind in words), "text or number")


def _allowed(item: FieldInfo, quantity: Quantity | None) -> str:
    if values := choices(item):
        return ", ".join(str(value) for value in values)
    messages = []
    if quantity is not None:
        for limit, word in ((quantity.above, "more than"), (quantity.least, "at least"), (quantity.most, "at most")):
            if limit is not None:
                messages.append(f"{word} {_written(limit, quantity)}")
        messages += [quantity.listed] if quantity.sizes else []
        messages += [f"at most {quantity.bare:g} without %"] if quantity.bare is not None else []
    messages += [f"at least {found.ge}" for found in marks(item, Ge)]
    messages += [f"at most {found.le}" for found in marks(item, Le)]
    messages += [f"at least {found.min_length} items" for found in marks(item, MinLen)][:1]
    messages += [f"at most {found.max_length} items" for found in marks(item, MaxLen)][:1]
    return ", ".join(dict.fromkeys(messages))


def _written(value: float, quantity: Quantity) -> str:
    """A number with its unit; of shares only a deviation has one, of which a bare number may lack its ``%``."""
    with_unit = quantity.unit != "1" or quantity.bare is not None
    return _short(quantity.limit_text(float(value))) if with_unit else f"{value:g}"


def _short(quantity: str) -> str:
    number, _, unit = quantity.partition(" ")
    return f"{float(number):.6g} {unit}".strip()


def default_text(item: FieldInfo, quantity: Quantity | None, because: Because | None) -> str | None:
    """The default as written in a file; None: required."""
    if because is not None and because.shown:
        return because.shown
    value = item.get_default(call_default_factory=True)
    if value is PydanticUndefined:
        return None
    return shown(value, quantity)


def shown(value: Any, quantity: Quantity | None) -> str:
    """A value as written in a file."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(shown(item, quantity) for item in value)}]" if value else "none"
    if isinstance(value, dict):
        return "none" if not value else str(value)
    if isinstance(value, (int, float)) and quantity is not None:
        return _written(value, quantity)
    return str(value)


def example(section: KeySection, name: str, item: FieldInfo, quantity: Quantity | None) -> str:
    """An example of a section's key; its own before one that keys of this name share."""
    if (own := f"{section.name}.{name}") in OWN_EXAMPLES:
        return OWN_EXAMPLES[own]
    given = [str(text) for found in (item.examples or (), *(mark.examples or () for mark in marks(item, FieldInfo)))
             for text in found]  # fmt: skip
    if given:
        return given[0]
    if quantity is not None and (name, quantity.unit) in QUANTITIES:
        return QUANTITIES[name, quantity.unit]
    if name in EXAMPLES:
        return EXAMPLES[name]
    if values := choices(item):
        return str(values[-1])
    if quantity is not None:
        default = item.get_default(call_default_factory=True)
        if isinstance(default, (int, float)) and not isinstance(default, bool) and default:
            return shown(float(default), quantity)
        return quantity.example if quantity.unit != "1" or quantity.bare is not None else "0.05"
    return ""


# Usual sizes of keys without a default, by the key's unit; else the example would be any quantity of that unit.
QUANTITIES = {
    ("com", "m"): "91 mm", ("com_across", "m"): "6 mm",
    ("at", "m"): "60 mm", ("most", "m"): "160 mm", ("min_outer_diameter", "m"): "12 mm",
    ("max_outer_diameter", "m"): "30 mm", ("min_inner_diameter", "m"): "8 mm", ("min_body_length", "m"): "6 mm",
    ("max_body_length", "m"): "25 mm", ("min_wire_diameter", "m"): "0.8 mm", ("max_wire_diameter", "m"): "3 mm",
    ("tip_mass", "kg"): "50 g", ("payload", "kg"): "20 g", ("foot_mass", "kg"): "2 g", ("body_mass", "kg"): "180 g",
    ("armature", "kg*m^2"): "2e-5 kg*m^2", ("rotor_inertia", "kg*m^2"): "1e-7 kg*m^2",
    ("inertia", "kg*m^2"): "1.2e-3 kg*m^2",
    ("delay", "s"): "4 ms", ("dead_band", "rad"): "0.5 deg", ("duty_limit", "1"): "0.85", ("efficiency", "1"): "0.8",
    ("gear_ratio", "1"): "150", ("torque_limit", "N*m"): "2.5 N*m", ("source_resistance", "ohm"): "0.1 ohm",
    ("control_period", "s"): "1 ms", ("lean", "rad"): "5 deg", ("frame_rate", "Hz"): "250 Hz",
    ("likelihood", "1"): "0.9",
    ("cycles", "1"): "100000", ("roll", "rad"): "3 deg", ("travel", "rad"): "40 deg",
    ("included_angle", "rad"): "120 deg", ("torque", "1"): "10 %", ("motor", "1"): "5 %",
}  # fmt: skip
DAMPER, SPRING, MOTOR = "6597K21", "LTR135H 10 M", '"N20 HP 6V 210:1"'  # rows of the built-in catalogues
# Of keys that mean something else elsewhere.
OWN_EXAMPLES = {
    "spring.part": SPRING, "spring_choice.part": SPRING, "select.without": f"[{DAMPER}]",
    "part_wish.without": f"[{DAMPER}]", "drive.motor": "{torque_constant: 0.02 N*m/A, resistance: 2 ohm}",
    "hopper.leg": "{hip_spacing: 30 mm, structure_mass: 17.9 g}", "command_limits.lowest": "60 deg",
    "command_limits.highest": "150 deg", "plate_jumps.jumps": "[jumps/*.csv]", "plate_jumps.currents": "[meter/*.csv]",
    "hopper_leg.crouch_lower": "50 deg", "run_ups.motor": '"N20 HP 6V 150:1"',
    "run_ups.stall": "[stall.csv]", "run_ups.free_speed": "[free_speed.csv]",
    "column.gear_ratio": "6", "command_column.gear_ratio": "1",
    "input_column.unit": "",  # of a voltage, a current, a torque ...: the examples of these keys have theirs
}  # fmt: skip
EXAMPLES = {
    "name": "dog hind leg", "seed": "1", "duty_steps": "885", "counts": "4096", "zero_count": "2048", "part": DAMPER,
    "curve": "damper.csv", "held_out": "true",
    "locked": "[hip]", "drive_off": "[hip]", "mirror": "true", "individual": "rat1", "topic": "/joint_states",
    "format": "deeplabcut",
    "catalogs": "[my_parts/*.csv]", "make": "true", "wire": "music", "parallel": "2", "encoder": "false",
    "mount": "false", "supported": "true", "file": "a.csv", "design": "hopper.yaml", "motor": MOTOR,
    "range": "[60 deg, 150 deg]", "tilt": "20 deg", "torque": "{hip: 1.9 N*m}", "free_angle": "105 deg",
    "runs": "[run_ups/*.csv]", "jumps": "[jumps/*.csv]", "leg": "rat.leg.yaml", "unit": "deg",
}  # fmt: skip
