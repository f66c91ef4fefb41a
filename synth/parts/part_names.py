"""The names of parts, vendors and wires that a project gives, looked up when it is read."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from synth.errors import Problem, did_you_mean
from synth.files.leg_project import LegProject
from synth.files.part_request import PartRequest
from synth.files.project_options import PartsOptions
from synth.files.validate import gathering, raise_if_any
from synth.files.yaml_lines import Document, Key, load
from synth.parts.catalogs import Catalogue
from synth.parts.part_candidates import named_damper, named_spring
from synth.parts.rows import DamperRow, TorsionSpringRow

NameList = Literal["vendors", "without"]


def require_known_names(project: LegProject, catalogue: Catalogue) -> None:
    """Refuse names in the project's file that no row of the catalogues has.

    Raises
    ------
    UserError
        With the line and key of every such name, and similar ones.
    """
    document = load(project.path)
    problems = _unknown_in(document, ("select",), project.parts, catalogue)
    for joint, choice in project.joints.items():
        place = ("select", "joints", joint)
        with gathering(problems, document, (*place, "spring", "part")):
            if choice.spring.part is not None:
                named_spring(catalogue, choice.spring.part)
        with gathering(problems, document, (*place, "spring", "wire")):
            if choice.spring.wire is not None:
                catalogue.find_material(choice.spring.wire)
        with gathering(problems, document, (*place, "damper", "part")):
            if choice.damper.part is not None:
                named_damper(catalogue, choice.damper.part)
    for joint, measured in project.dampers.items():
        with gathering(problems, document, ("dampers", joint, "part")):
            if measured.part is not None:
                catalogue.find_damper(measured.part)
    raise_if_any(problems)


def require_known_wishes(request: PartRequest, catalogue: Catalogue) -> None:
    """Refuse vendors, and parts to leave out, that no row of the catalogues has.

    Raises
    ------
    UserError
        With the line and key of every such name, and similar ones.
    """
    raise_if_any(_unknown_in(load(request.path), (), request.parts, catalogue))


def _unknown_in(document: Document, place: Key, parts: PartsOptions, catalogue: Catalogue) -> list[Problem]:
    """The vendors and parts to leave out, of the mapping at ``place``, that are unknown."""
    options: tuple[tuple[NameList, Sequence[str]], ...] = (("vendors", parts.vendors), ("without", parts.without))
    return [
        document.problem(text, (*place, option, index))
        for option, names in options
        for index, text in unknown_names(names, option, catalogue)
    ]


def unknown_names(names: Sequence[str], option: NameList, catalogue: Catalogue) -> Iterable[tuple[int, str]]:
    """Position and fault of each vendor, or part to leave out, that no spring or damper of the catalogues has."""
    sold: list[TorsionSpringRow | DamperRow] = [*catalogue.springs, *catalogue.dampers]
    known = sorted({row.vendor if option == "vendors" else row.part for row in sold} - {""})
    folded = {name.casefold() for name in known}
    what = "no vendor" if option == "vendors" else "no part"
    listed = f"; there are {', '.join(known)}" if option == "vendors" else ""
    for index, name in enumerate(names):
        if name.casefold() not in folded:
            yield index, f'"{name}" is {what} in the catalogues{did_you_mean(name, known, 3)}{listed}'
