"""An argument of a comparison, ``NAME=PATH#VIEW``, and the kind of its path."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from synth.errors import Problem, UserError
from synth.files.names import name_fault
from synth.files.trial_list import Trial
from synth.files.validate import COMMANDS, check_kind, near
from synth.files.yaml_lines import load

# Result file -> its kind; the first one found in a folder decides.
RESULTS = {"design.json": "design", "gap.json": "gap", "fit.json": "fit"}
# The views of each kind, in the order of the page; "leg" and "trials" are a single side.
VIEWS = {
    "design": ("animal", "wanted", "built"),
    "gap": ("recorded", "designed", "explained"),
    "fit": ("recorded", "fitted"),
    "gap project": ("recorded", "designed"),
    "fit project": ("recorded", "fitted"),
    "leg-design project": ("animal", "wanted"),
    "leg": ("leg",),
    "trials": ("recorded",),
}
PROJECTS = {"fit": "fit project", "gap": "gap project", "leg-design": "leg-design project", "leg": "leg"}
_OTHER = {"hopper.json": "a jumping leg's study", "spring.json": "a spring", "fits.json": "many fits"}


@dataclass(frozen=True)
class Source:
    """One argument: path, kind, name, and requested views.

    ``in_code``: it is no file of the user's but an object of the library, written at ``path``; ``trials`` : recordings
    that were read, of the kind ``trials``.
    """

    label: str
    path: Path  # the file, or a result's folder
    kind: str
    views: tuple[str, ...]
    written: str
    in_code: bool = False
    trials: tuple[Trial, ...] = ()

    def named(self, view: str) -> str:
        """The side's name: the label, with the view if there are several."""
        return self.label if len(self.views) == 1 else f"{self.label} {view}"


def read_source(written: str) -> Source:
    """Read one argument.

    Raises
    ------
    UserError
        If nothing exists at the path, it cannot be compared, or a view is unknown for its kind.
    """
    label, text = _label(written)
    text, _, asked = text.partition("#")
    path = Path(text)
    if not path.exists():
        raise UserError(Problem("does not exist; name a result folder, a project, a leg file or a CSV", text))
    place, kind = _kind(path)
    views = tuple(view.strip() for view in asked.split(",")) if asked else VIEWS[kind]
    for view in views:
        if view not in VIEWS[kind]:
            text = f'"{view}" is not a view of a {kind}{near(view, VIEWS[kind])}'
            raise UserError(Problem(text, written))
    name = label or place.name.removesuffix(".yaml").removesuffix(".leg").removesuffix(".csv")
    fault = name_fault(name)
    if fault is not None:
        raise UserError(Problem(f'"{name}" {fault}; give a name: new={text}', written))
    return Source(name, place, kind, views, written)


def _label(written: str) -> tuple[str, str]:
    """``NAME=PATH`` as its two parts; an existing path that contains an equals sign is a path."""
    label, equals, rest = written.partition("=")
    if not equals or Path(written.partition("#")[0]).exists():
        return "", written
    return label.strip(), rest


def _kind(path: Path) -> tuple[Path, str]:
    """The file or folder to read, and its kind."""
    if path.name in RESULTS:
        return path.parent, RESULTS[path.name]
    if path.name in _OTHER:
        raise UserError(Problem(_not_a_leg(_OTHER[path.name]), str(path)))
    if path.is_dir():
        for name, kind in RESULTS.items():
            if (path / name).is_file():
                return path, kind
        for name, what in _OTHER.items():
            if (path / name).is_file():
                raise UserError(Problem(_not_a_leg(what), str(path)))
        if any(path.glob("*.csv")):
            return path, "trials"
        raise UserError(Problem(f"contains no {', '.join(RESULTS)} and no recording (*.csv)", str(path)))
    if path.suffix == ".csv":
        return path, "trials"
    document = load(path)
    found = document.value.get("kind")
    if not isinstance(found, str) or found not in COMMANDS:
        check_kind(document, "leg")
    if found not in PROJECTS:
        text = f"is of kind {found}, which cannot be compared; allowed here: {', '.join(PROJECTS)}"
        raise UserError(Problem(text, str(path)))
    return path, PROJECTS[str(found)]


def _not_a_leg(what: str) -> str:
    return f"is {what}; compare takes fits, designs and gaps of swinging legs, their projects, legs and recordings"
