"""Reading of a design's project, apart from the design: a run whose input is unchanged needs nothing else."""

from __future__ import annotations

from pathlib import Path

from synth.files.leg_project import LegProject, read_leg_project
from synth.parts.catalogs import Catalogue
from synth.parts.part_names import require_known_names
from synth.parts.resolver import resolver


def read_design(path: str | Path) -> tuple[LegProject, Catalogue]:
    """Read a project of kind ``leg-design`` with its legs, trials and catalogues.

    A motion that is wanted by its characteristics is computed, and is then the project's trial.

    Raises
    ------
    UserError
        With every mistake of the project, its legs, trials and curves; then with every part, vendor and wire that the
        catalogues do not have.
    """
    project = read_leg_project(path, open_catalogue=lambda paths: resolver(Catalogue.load(paths)))
    catalogue = Catalogue.load(project.catalogs)
    require_known_names(project, catalogue)
    if project.wanted:
        from synth.fit.wanted_motion import with_wanted_leg  # with the equations of motion, 0.3 s

        project = with_wanted_leg(project)
    return project, catalogue
