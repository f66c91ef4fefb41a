"""Which of the poses of an NWB file is meant: by its name, or by that of its skeleton, subject, camera or video.

A file has one pose (``PoseEstimation``) for each animal and camera. sleap-io calls them ``track=NAME`` in a module for
each video; others name them as they like, all of one name in the modules or cameras that hold them too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath, PureWindowsPath

from synth.errors import Problem, UserError
from synth.files.validate import near
from synth.motion.importers.foreign_data import name_list

TRACK = "track="  # before the name of a track, as sleap-io writes it


def chosen_pose(poses: Mapping[str, Sequence[str]], wanted: str | None, name: str) -> str:
    """The place of the pose that is meant; of a single one none need be named.

    Parameters
    ----------
    poses : place in the file -> names of what the pose is of: skeleton, subject, camera, video.
    wanted : ``individual`` of the project; ``name`` of the file, in messages.

    Raises
    ------
    UserError : several poses and none wanted, or one that is not there or not the only one; it lists them.
    """
    shown = _shortest_names(list(poses))
    if wanted is None:
        if len(poses) > 1:
            text = f"contains {len(poses)} poses; choose one, individual: NAME, of {_listed(poses, shown)}"
            raise UserError(Problem(text, name))
        return next(iter(poses))
    last = {place: place.rsplit("/", 1)[-1] for place in poses}
    for known in (
        {place: {shown[place], place} for place in poses},
        {place: {shown[place].removeprefix(TRACK), last[place].removeprefix(TRACK)} for place in poses},
        {place: {*of, *map(_file_name, of)} for place, of in poses.items()},
    ):
        found = [place for place, names in known.items() if wanted in names]
        if len(found) == 1:
            return found[0]
        if found:
            text = f'individual: "{wanted}" is that of several poses; choose one: {_listed(found, shown)}'
            raise UserError(Problem(text, name))
    hint = near(wanted, list(shown.values()))
    if not hint.startswith("; did you mean"):
        hint = f"; the file has {_listed(poses, shown)}{'; leave it out' if len(poses) == 1 else ''}"
    raise UserError(Problem(f'there is no individual "{wanted}"{hint}', name))


def _shortest_names(places: Sequence[str]) -> dict[str, str]:
    """Place -> its last parts, as many as tell it from the others."""
    found = {}
    for place in places:
        parts = place.split("/")
        ends = ["/".join(parts[-count:]) for count in range(1, len(parts) + 1)]
        counts = Counter(end for other in places for end in ends if f"/{other}".endswith(f"/{end}"))
        found[place] = next((end for end in ends if counts[end] == 1), place)
    return found


def _listed(poses: Mapping[str, Sequence[str]] | Sequence[str], shown: Mapping[str, str]) -> str:
    """The names of poses, each with what it alone is of."""
    of = poses if isinstance(poses, Mapping) else {}
    common = set.intersection(*({*each} for each in of.values())) if len(of) > 1 else set()
    words = []
    for place in poses:
        own = [each for each in of.get(place, ()) if each not in common]
        words.append(shown[place] + (f" ({', '.join(own)})" if own else ""))
    return name_list(words)


def _file_name(text: str) -> str:
    """A video's name without its folders, of either system."""
    return PurePosixPath(PureWindowsPath(text).as_posix()).name
