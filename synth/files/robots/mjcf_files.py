"""The files that an MJCF names: MuJoCo opens them by itself, wherever they lie, so they are looked through before.

A robot's file may come from anyone. What it names must lie in its folder's tree, as of a URDF.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from synth.errors import Problem, UserError
from synth.files.paths import refuse_outside
from synth.files.robots.xml_root import root_element

LARGEST = 200_000_000  # bytes; as of a robot's file
MOST = 200  # included files; a robot's file has a few
FOLDERS = ("meshdir", "texturedir", "assetdir")  # of a compiler: where meshes and textures are sought
# Attributes that name a file: of meshes, height fields, skins, flexes, textures, models, includes.
FILES = ("file", *(f"file{side}" for side in ("right", "left", "up", "down", "front", "back")))
PARTS = ("include", "model")  # elements whose file is MJCF again


def require_files_inside(path: Path) -> None:
    """Refuse an MJCF that names a file outside its folder, by itself or in a file that it includes.

    Raises
    ------
    UserError
        With every such name.
    """
    problems: list[Problem] = []
    waiting, seen = [path], {path.resolve()}
    folders = {""}
    while waiting:
        if len(seen) > MOST:
            raise UserError(Problem(f"includes more than {MOST} files", str(path)))
        file = waiting.pop()
        root = root_element(file, LARGEST, "a robot's file names its meshes and does not hold them")
        folders |= {item.get(key, "") for item in root.iter("compiler") for key in FOLDERS}
        bare = any(item.get("strippath") == "true" for item in root.iter("compiler"))
        for item, key in _named(root):
            name = item.get(key, "")
            of_part = item.tag in PARTS
            sought = PurePosixPath(name).name if bare and not of_part else name
            for base in dict.fromkeys((path.parent, file.parent)):
                for folder in ("",) if of_part else sorted(folders):
                    found = base / folder / sought
                    try:
                        refuse_outside(path.parent, found, str(PurePosixPath(folder, sought)))
                    except UserError as error:
                        problems.append(Problem(error.problems[0].text, str(file), key=f"{item.tag}.{key}"))
                        continue
                    if of_part and found.is_file() and found.resolve() not in seen:
                        seen.add(found.resolve())
                        waiting.append(found)
    if problems:
        raise UserError(list(dict.fromkeys(problems)))


def _named(root: Element) -> Iterator[tuple[Element, str]]:
    """Every element and attribute that names a file."""
    return ((item, key) for item in root.iter() for key in FILES if item.get(key, "").strip())
