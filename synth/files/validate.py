"""Check a YAML document against its model and report all mistakes together, in the user's terms."""

from __future__ import annotations

import types
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, PydanticCustomError, core_schema

from synth import units
from synth.errors import Problem, UserError, did_you_mean
from synth.files.names import title_fault
from synth.files.yaml_lines import Document, Key
from synth.units_spelling import read_number

# The purpose of each kind of file: the command that reads it, or the key by which other files name it.
COMMANDS = {
    "fit": '"synth fit"',
    "gap": '"synth gap"',
    "import": '"synth import"',
    "reproduce": '"synth reproduce"',
    "leg-design": '"synth leg"',
    "part-wish": '"synth catalog show"',
    "hopper-design": '"synth hopper"',
    "hopper-motor": '"synth hopper"',
    "hopper-pull-ups": '"synth hopper"',
    "hopper-jumps": '"synth hopper"',
    "leg": None,
}
# Required keys of each kind, which identify a file without ``kind:``; the most specific first.
_KEYS = {
    "hopper-motor": {"gear_ratio", "runs"},
    "hopper-pull-ups": {"design", "body_mass", "trials"},
    "hopper-jumps": {"design", "jumps"},
    "leg-design": {"source", "target"},
    "hopper-design": {"motors", "lengths"},
    "import": {"leg", "files"},
    "fit": {"leg", "trials"},
    "gap": {"leg", "trials"},
    "leg": {"joints"},
}


class FileModel(BaseModel):
    """A mapping of a user's file: unknown keys are mistakes, values are not coerced."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


Model = TypeVar("Model", bound=FileModel)


def refusal(text: str) -> PydanticCustomError:
    """A mistake with a message of our own, to raise inside a pydantic validator."""
    return PydanticCustomError("user", "{text}", {"text": text})


def _title(value: str) -> str:
    fault = title_fault(value)
    if fault is not None:
        raise refusal(f'"{value[:60]}" {fault}')
    return value


Title = Annotated[str, AfterValidator(_title)]  # the title of a leg, a project or a part; never a file name


# The largest deviation that may be written without "%": 0.1 to 1 are usual deviations in per cent, so that above it
# the sign is more likely forgotten than a deviation of a tenth and more is meant.
BARE_DEVIATION = 0.05
ROUNDED = 1e-9  # relative: a size written in another unit differs from it by rounding only


MOST_DIGITS = 9  # of a limit with its unit, which is else written in the SI unit


@dataclass(frozen=True)
class Quantity:
    """Marks a float field as written with a unit: ``length: Annotated[float, Quantity("m", above=0)]``.

    ``unit`` is the SI unit in which the model holds it; ``above`` is an exclusive lower limit in it, ``least``
    and ``most`` inclusive ones. ``sizes``: the only values, in ``unit``; a value that differs by rounding is made one.
    ``bare`` : of a share, the largest number without a ``%``: of a larger one it may have been forgotten.
    """

    unit: str
    above: float | None = None
    least: float | None = None
    most: float | None = None
    sizes: tuple[float, ...] = ()
    bare: float | None = None

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """A quantity; of ``float | Model`` a mapping is held against the model, so that its keys keep their names."""
        model = _inner_model(source)
        if model is None:
            return core_schema.no_info_plain_validator_function(self.read)

        def read(value: object, of_model: ValidatorFunctionWrapHandler) -> Any:
            return of_model(value) if isinstance(value, dict) else self.read(value)

        return core_schema.no_info_wrap_validator_function(read, handler.generate_schema(model))

    @property
    def example(self) -> str:
        return units.MEANINGS[self.unit][1]

    @property
    def shown(self) -> str:
        """The user's unit."""
        return self.example.split(" ", 1)[1]

    def limit_text(self, limit: float) -> str:
        """A limit in the user's unit, or in the SI unit where that is too long to be read at a glance."""
        shown, plain = units.write(limit, self.shown), units.write(limit, self.unit)
        return plain if len(shown) > MOST_DIGITS and len(plain) < len(shown) and self.unit != "1" else shown

    def read(self, value: object) -> float:
        """The value in ``unit``; raises if not allowed."""
        try:
            number = units.parse(value, self.unit)
        except UserError as error:
            raise refusal(error.problems[0].text) from None
        if self.above is not None and not number > self.above:
            raise refusal(f"{value} is not allowed: it must be more than {units.write(self.above, self.shown)}")
        if self.least is not None and number < self.least:
            raise refusal(f"{value} is not allowed: it must be at least {units.write(self.least, self.shown)}")
        if self.bare is not None and number > self.bare and (written := read_number(str(value))) and not written[1]:
            other = self.most is None or number <= self.most
            meant = f", or {units.write(number, '%')} if that is meant" if other else ""
            raise refusal(f"{value} is not allowed without a unit: write {value} %{meant}")
        if self.most is not None and number > self.most:
            raise refusal(f"{value} is not allowed: it can be at most {self.limit_text(self.most)}")
        if self.sizes:
            nearest = min(self.sizes, key=lambda size: abs(size - number))
            if abs(number - nearest) > ROUNDED * nearest:
                raise refusal(f"{value} is not allowed: it must be {self.listed}")
            return nearest
        return number

    @property
    def listed(self) -> str:
        """The only values in words, e.g. ``one of 3, 4 and 5 mm``."""
        *most, last = (units.write(size, self.shown).split(" ")[0] for size in self.sizes)
        return f"one of {', '.join(most)} and {last} {self.shown}"


@contextmanager
def gathering(problems: list[Problem], document: Document | None = None, key: Key = ()) -> Iterator[None]:
    """Continue after a mistake: a ``UserError`` in the block is added to ``problems``.

    Problems without a file get the place ``key`` of ``document``, which named the faulty file.
    """
    try:
        yield
    except UserError as error:
        for problem in error.problems:
            placed = document.problem(problem.text, key) if document and problem.file is None else problem
            problems.append(placed)


def raise_if_any(problems: Sequence[Problem]) -> None:
    """Raise one ``UserError`` with all problems, without duplicates, in the order of the file."""
    if problems:
        raise UserError(list(dict.fromkeys(problems)))


def check_kind(document: Document, kind: str) -> None:
    """Refuse a file of another kind, and name the command that reads it.

    Raises
    ------
    UserError
        If ``kind:`` is missing, unknown, or not ``kind``.
    """
    found = document.value.get("kind")
    if found == kind:
        return
    wanted = f"kind: {kind}"
    if found is None:
        meant = _meant(document, kind)
        why = "" if meant == kind else f"its keys are those of a {_reader(meant)}: "
        raise UserError(document.problem(f'"kind" is missing: {why}write "kind: {meant}" as the first line'))
    if not isinstance(found, str) or found not in COMMANDS:
        raise UserError(document.problem(f"{found!r} is no kind of file{near(found, COMMANDS)}", ("kind",)))
    if kind == "leg":
        text = f'this is a project (kind: {found}) where a leg file ("{wanted}") is needed'
    elif found == "leg":
        text = f'a leg file is named by a project under "leg:"; {COMMANDS[kind]} reads a project with "{wanted}"'
    elif COMMANDS[found] == COMMANDS[kind]:
        text = f'{COMMANDS[found]} reads a file of kind {found} on the command line only; here "{wanted}" is needed'
    else:
        text = f'a file of kind {found} is read by {COMMANDS[found]}; {COMMANDS[kind]} reads "{wanted}"'
    raise UserError(document.problem(text, ("kind",)))


def _reader(kind: str) -> str:
    """A file of a kind in words, by the command that reads it."""
    return "leg file" if COMMANDS[kind] is None else f"file for {COMMANDS[kind]}"


def may_be_of(document: Document, kind: str) -> bool:
    """Whether a file is, or may be meant as, one of this kind: its ``kind:`` is misspelt, unknown or missing."""
    found = document.value.get("kind")
    if isinstance(found, str) and found in COMMANDS:
        return found == kind
    meant = did_you_mean(found, COMMANDS) if isinstance(found, str) else ""
    if meant:
        return meant == did_you_mean(str(found), [kind])
    return kind in _KEYS and _KEYS[kind] <= set(document.value)


def _meant(document: Document, kind: str) -> str:
    """The kind of a file without ``kind:``, from its keys; ``kind`` unless they fit another one better."""
    written = set(document.value)
    if kind in _KEYS and _KEYS[kind] <= written:
        return kind
    return next((other for other, keys in _KEYS.items() if keys <= written), kind)


def check_part(model: type[Model], document: Document, value: Any, key: Key, problems: list[Problem]) -> Model | None:
    """Validate one part of a document; mistakes go to ``problems``, and the result is then None."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        details = error.errors(include_url=False)
        found = [_problem(model, document, key, detail) for detail in details if not _counts_faulty_items(detail)]
        problems.extend(sorted(found, key=lambda problem: problem.line or 0))
        return None


def _counts_faulty_items(detail: ErrorDetails) -> bool:
    """Whether a list is too short only without its faulty items, each of which has a message of its own."""
    written = detail["input"]
    return detail["type"] == "too_short" and isinstance(written, list) and len(written) >= detail["ctx"]["min_length"]


def near(value: object, names: Sequence[str] | dict[str, Any]) -> str:
    """``; did you mean knee?`` if a name is similar, else the list of allowed names."""
    known = list(names)
    meant = did_you_mean(value, known) if isinstance(value, str) else ""
    if meant:
        return meant
    if not known:
        return ""
    return f"; allowed here: {', '.join(known[:30])}{' ...' if len(known) > 30 else ''}"


def _problem(model: type[BaseModel], document: Document, key: Key, detail: ErrorDetails) -> Problem:
    """One pydantic error in the user's words."""
    where: Key = tuple(detail["loc"])
    # "[key]" is pydantic's own mark for a mapping's key.
    where = where[:-1] if where and where[-1] == "[key]" else where
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    owner, field = _field(model, where)
    name = _cut(str(where[-1])) if where else "the file"
    if kind == "user":
        text = str(context["text"])
    elif kind == "missing":
        text = f'"{name}" is missing: write it{_example(name, field)}'
    elif kind == "extra_forbidden":
        known = list(owner.model_fields) if owner else []
        text = f'"{name}" is not a key here{near(name, known)}'
    elif kind == "literal_error":
        allowed = [str(item) for item in _choices(field)]
        text = f"{_shown(value)} is not allowed{near(value, allowed)}"
    elif value is None:
        text = f"has no value: write one{_example(name, field)}, or leave the key out"
    elif kind in ("too_short", "too_long"):
        count = len(value) if isinstance(value, list) else context["actual_length"]  # the latter of valid items only
        text = f"{_shown(value)} has {count} items; {_length(context)} needed"
    else:
        text = f"{_shown(value)} is not allowed: {_EXPECTED.get(kind, detail['msg'])}"
    return document.problem(text, (*key, *where))


_EXPECTED = {
    "model_type": "a mapping {key: value, ...} is needed",
    "model_attributes_type": "a mapping {key: value, ...} is needed",
    "dict_type": "a mapping {key: value, ...} is needed",
    "list_type": "a list [..., ...] is needed",
    "tuple_type": "a list [..., ...] is needed",
    "string_type": "text is needed; put it in quotes if it looks like a number or like yes/no",
    "bool_type": "write true or false",
    "int_type": "a whole number is needed",
}


def _field(model: type[BaseModel], where: Key) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The model that owns the key at ``where`` and its field, as far as the path can be followed."""
    current: type[BaseModel] | None = model
    owner: type[BaseModel] | None = model
    field: FieldInfo | None = None
    for part in where:
        if isinstance(part, int) or current is None:
            continue
        if field is not None and _is_mapping(field):
            owner, field = None, None  # a name chosen by the user, such as a joint's, not a key of a model
            continue
        owner = current
        field = current.model_fields.get(part)
        current = _inner_model(field.annotation) if field else None
    return owner, field


def _is_mapping(field: FieldInfo) -> bool:
    return any(get_origin(option) is dict for option in _options(field.annotation))


def _options(annotation: Any) -> tuple[Any, ...]:
    """The members of a union, or the annotation itself."""
    if get_origin(annotation) in (Union, types.UnionType):
        return get_args(annotation)
    return (annotation,)


def _inner_model(annotation: Any) -> type[BaseModel] | None:
    """The model inside ``Model | None``, ``list[Model]``, ``dict[str, Model]``."""
    for option in (annotation, *get_args(annotation)):
        if isinstance(option, type) and issubclass(option, BaseModel):
            return option
        inner = _inner_model(option) if option is not annotation and get_args(option) else None
        if inner is not None:
            return inner
    return None


def _example(name: str, field: FieldInfo | None) -> str:
    """An example of the key, if there is one."""
    marks = [mark.example for mark in field.metadata if isinstance(mark, Quantity)] if field else []
    examples = marks or list(field.examples or () if field else ())
    return f", for example {name}: {examples[0]}" if examples else ""


def _length(context: dict[str, Any]) -> str:
    least, most = context.get("min_length"), context.get("max_length")
    return f"at least {least} are" if most is None else f"no more than {most} are"


def _choices(field: FieldInfo | None) -> tuple[Any, ...]:
    for option in _options(field.annotation) if field else ():
        if get_origin(option) is Literal:
            return get_args(option)
    return ()


def _shown(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return _cut(text)


def _cut(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."
