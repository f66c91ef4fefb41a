"""Angles of a limb's joints from points on it, in a plane.

Link i runs from point i to point i + 1; its absolute rotation, counter-clockwise from straight down with x to the
right and z up, is ``atan2(dx, -dz)``, and a joint's rotation is the difference to its parent's.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.log_clock import LogClock, log_clock
from synth.motion.importers.foreign_data import Markers, name_list, other_side
from synth.motion.importers.limb_sides import exchanged_limb
from synth.noise import MAD_TO_SD
from synth.swing.leg_model import Leg

STRETCH = 0.2  # of a link's length; with a larger deviation a point is misplaced
SPREADS = 6.0  # robust standard deviations of the link's length, required too
MISMATCH = 0.25  # of a link's length against the leg file's, both relative to the whole leg
TILTED = np.radians(15.0)  # out of the plane, smallest reported value
ORIGIN = "origin"  # the coordinates' zero as a point: a first joint that does not move, and was not tracked
_AXIS = re.compile(r"([+-]?)([xyz])")


@dataclass(frozen=True, eq=False)
class TrackedAngles:
    """Angles from points: ``rotation`` (n, n_joint) rad, nan where a point is missing; ``points`` (n, n_point, 2)
    in units of the source, x right and z up, as used; ``scale`` metres per unit of the source, from the leg
    file's lengths; ``notes`` messages. ``right`` : of a fitted plane, (2,) in the axes of space that are not up.
    """

    clock: LogClock
    rotation: Array
    points: Array
    scale: float
    notes: tuple[str, ...]
    right: Array | None = None


def track(markers: Markers, leg: Leg, mapping: Mapping) -> TrackedAngles:
    """The joints' rotations from the points named by ``mapping``.

    Raises
    ------
    UserError : missing or too few points, no clock, a needless or missing plane.
    """
    clock, markers = _clock(markers, mapping), _with_origin(markers, mapping)
    chosen = _chosen_points(markers, leg, mapping)
    notes = [*clock.notes, *markers.notes]
    space = _restore_sides(markers, chosen, clock.time, notes)
    seen, right = _in_plane(space, markers, mapping, notes)
    flat = _turn_back(seen, mapping.roll)  # as filmed, so before it is mirrored
    if mapping.mirror:
        flat[..., 0] *= -1.0
    vector = np.diff(flat, axis=1)
    length = np.hypot(vector[..., 0], vector[..., 1])
    middle = np.nanmedian(np.where(np.isfinite(length).any(axis=0), length, 0.0), axis=0)
    if (middle <= 0).any():
        empty = [leg.joint_names[i] for i in np.flatnonzero(middle <= 0)]
        raise UserError(
            Problem(f"the points of these links are never visible together: {name_list(empty)}", markers.name)
        )
    absolute = np.arctan2(vector[..., 0], -vector[..., 1])
    absolute[_misplaced_links(length, middle, leg, notes)] = np.nan
    rotation = absolute.copy()
    rotation[:, 0] -= leg.tilt
    rotation[:, 1:] -= absolute[:, :-1]
    rotation = np.angle(np.exp(1j * rotation))
    scale = _scale(middle, leg, notes)
    return TrackedAngles(clock, np.asarray(rotation), flat, scale, tuple(notes), right)


def _clock(markers: Markers, mapping: Mapping) -> LogClock:
    """From the file, or the frame rate."""
    own, stated = markers.frame_rate, mapping.frame_rate
    if own is not None and stated is not None and abs(own / stated - 1.0) > 1e-6:  # as written to six digits
        text = f"the file says {own:g} Hz and the project {stated:g} Hz; leave it out"
        raise UserError(Problem(text, markers.name, key="frame_rate"))
    if markers.time is not None:
        return log_clock(markers.time, 1.0)
    rate = own or stated
    if rate is None:
        text = "has no clock: state the camera's frame rate, frame_rate: 250 Hz (--frame-rate '250 Hz'). "
        text += "For slow-motion video this is the rate of filming, not of playback"
        raise UserError(Problem(text, markers.name))
    return log_clock(markers.frames / rate, 1.0)


def _with_origin(markers: Markers, mapping: Mapping) -> Markers:
    """The points with ``ORIGIN`` among them, where it is asked for as the first and the file tracks no such point."""
    if not mapping.points or mapping.points[0] != ORIGIN or ORIGIN in markers.names:
        return markers
    fixed = np.zeros_like(markers.positions[:, :1])
    names = (*markers.names, ORIGIN)
    return replace(markers, names=names, positions=np.concatenate([markers.positions, fixed], axis=1))


def _chosen_points(markers: Markers, leg: Leg, mapping: Mapping) -> list[int]:
    """Indices of the points, proximal to distal."""
    n = len(leg.joints)
    if not mapping.points:
        text = f"name the points of the leg's joints, proximal to distal and then the tip, {n + 1} in total: "
        text += f"points: [{', '.join(leg.joint_names)}, tip] (--points); the file has {name_list(markers.names)}"
        raise UserError(Problem(text, markers.name))
    if len(mapping.points) != n + 1:
        text = f"{len(mapping.points)} points are named; {leg.name} has {n} joints and needs {n + 1}: each joint and "
        raise UserError(Problem(f"{text}the last link's end", markers.name, key="points"))
    if len(set(mapping.points)) < len(mapping.points):
        raise UserError(Problem("a point is listed twice", markers.name, key="points"))
    return [markers.find(point) for point in mapping.points]


def _restore_sides(markers: Markers, chosen: list[int], time: Array, notes: list[str]) -> Array:
    """Positions (n, n_point, d) of the chosen points, with exchanges between the sides reversed."""
    space = markers.positions[:, chosen].copy()
    others = [other_side(markers.names[index], markers.names) for index in chosen]
    both = [k for k, other in enumerate(others) if other is not None and other not in chosen]
    if both:
        there = [markers.positions[:, other] for other in others if other is not None and other not in chosen]
        here = [space[:, k] for k in both]
        found = exchanged_limb(here, there, [k + 1 == after for k, after in itertools.pairwise(both)])
        notes += found.notes([markers.names[chosen[k]] for k in both], time)
        for k, swapped, other in zip(both, found.swapped, there, strict=True):
            space[:, k] = np.where(swapped[:, None], other, space[:, k])
    for k, index in enumerate(chosen):
        if not np.isfinite(space[:, k]).any():
            raise UserError(Problem(f'the point "{markers.names[index]}" is never visible', markers.name))
    return np.asarray(space)


def _in_plane(space: Array, markers: Markers, mapping: Mapping, notes: list[str]) -> tuple[Array, Array | None]:
    """(n, n_point, 2): right and up; of a fitted plane, its right."""
    if space.shape[2] == 2:
        if markers.picture is not None:
            return _along(space, mapping.plane or markers.picture, markers), None
        if mapping.plane is not None:
            text = "the file's points are in an image plane already; leave `plane` out"
            raise UserError(Problem(text, markers.name, key="plane"))
        return space.copy(), None
    if mapping.plane is None and markers.up is not None:
        notes.append(f"no plane is given: using the best-fitting one, {markers.up} up (plane: [fit, {markers.up}])")
        return fitted_plane(space, markers.up, markers, notes, mapping.towards)
    if mapping.plane is not None and mapping.plane[0].strip().casefold() == "fit":
        return fitted_plane(space, mapping.plane[1], markers, notes, mapping.towards)
    if mapping.plane is None:
        moving = np.nanstd(space - np.nanmean(space, axis=0), axis=(0, 1))
        sizes = ", ".join(f"{axis} {size:.3g} {markers.unit}".strip() for axis, size in zip("xyz", moving, strict=True))
        text = "its points are in space: give the axes to the right and up in the plane of motion, for example "
        text += f"plane: [x, z], [-y, z] or [fit, z] (--plane=x,z). The points move by ({sizes}, SD)"
        raise UserError(Problem(text, markers.name))
    flat = _along(space, mapping.plane, markers)
    (left_out,) = {index for index in range(3) if not any("xyz"[index] in axis.casefold() for axis in mapping.plane)}
    across = np.abs(np.diff(space[..., left_out], axis=1))
    along = np.linalg.norm(np.diff(flat, axis=1), axis=-1)
    out = np.nanpercentile(np.degrees(np.arctan2(across, along)), 95)
    if np.radians(out) > TILTED:
        plane = ", ".join(mapping.plane)
        notes.append(f"links stand up to {out:.0f} deg out of the plane [{plane}]: is it correct?")
    return flat, None


def _along(points: Array, plane: tuple[str, str], markers: Markers) -> Array:
    """(n, n_point, 2) of points (n, n_point, 2 or 3) along two of their axes, with signs: to the right and up."""
    names = "xyz"[: points.shape[2]]
    axes = [_AXIS.fullmatch(axis.strip().casefold()) for axis in plane]
    picked = [(names.find(axis[2]), -1.0 if axis[1] == "-" else 1.0) for axis in axes if axis]
    if len({index for index, _ in picked if index >= 0}) < 2:
        examples = "[x, z], [-y, z] or [fit, z]" if names == "xyz" else "[x, y] or, if y counts downward, [x, -y]"
        text = f"[{', '.join(plane)}] is not a plane: write two of {', '.join(names)}, such as {examples}"
        raise UserError(Problem(text, markers.name, key="plane"))
    return np.stack([sign * points[..., index] for index, sign in picked], axis=-1)


def fitted_plane(
    space: Array, up: str, markers: Markers, notes: list[str], towards: tuple[float, float] | None = None
) -> tuple[Array, Array]:
    """(n, n_point, 2) in the upright plane that fits the points best, and its right; a note states their distance.

    The plane contains the axis ``up``; its normal is the horizontal direction in which the points vary least about
    their mean in each frame and over all frames (least squares, smallest eigenvalue of their covariance). Points of
    links that are far too long or short in a frame, such as unseen ones written as 0, 0, 0, do not count. To the right
    is the side of ``towards``, or else that on which the nearest axis of space grows.
    """
    match = _AXIS.fullmatch(up.strip().casefold())
    if match is None:
        raise UserError(Problem(f'"{up}" is not an axis: write x, y or z, such as [fit, z]', markers.name, key="plane"))
    vertical = "xyz".index(match[2])
    level = [index for index in range(3) if index != vertical]
    length = np.linalg.norm(np.diff(space, axis=1), axis=2)
    middle = np.nanmedian(length, axis=0)
    wrong = np.pad(_wrong_lengths(length, middle)[0], ((0, 0), (1, 1)))
    known = space[np.isfinite(space).all(axis=2) & ~(wrong[:, :-1] | wrong[:, 1:])][:, level]
    centred = known - known.mean(axis=0)
    spread, ways = np.linalg.eigh(centred.T @ centred / len(centred))
    right = along_its_axis(ways[:, 1])
    turned = towards is not None and float(right @ np.array(towards)) < 0.0
    right = -right if turned else right
    away = centred @ ways[:, 0]
    limb = float(np.nansum(middle))
    off = float(np.sqrt(np.mean(away**2)))
    unit = f" {markers.unit}" if markers.unit else ""
    where = ", ".join(f"{value:+.3f} {'xyz'[index]}" for value, index in zip(right, level, strict=True))
    shared = ", as in the other files" if turned else ""
    notes.append(
        f"plane fitted: right is ({where}){shared}, {match[0]} up; the points lie {off:.3g}{unit} RMS from it, "
        f"{off / limb:.1%} of the limb's length, at most {np.abs(away).max():.3g}{unit}"
    )
    if spread[1] < 4.0 * spread[0]:
        notes.append("the points vary hardly more along that plane than across it: is the limb's motion planar?")
    sign = -1.0 if match[1] == "-" else 1.0
    return np.stack([space[..., level] @ right, sign * space[..., vertical]], axis=-1), np.asarray(right)


def along_its_axis(way: Array) -> Array:
    """The direction ``way`` or its opposite: the one along which its nearest axis grows."""
    return np.asarray(way * np.sign(way[int(np.argmax(np.abs(way)))]))


def _misplaced_links(length: Array, middle: Array, leg: Leg, notes: list[str]) -> Mask:
    """(n, n_link) True if a link is so long or short that one of its points must be wrong."""
    wrong, spread = _wrong_lengths(length, middle)
    for i, name in enumerate(leg.joint_names):
        if wrong[:, i].any():
            limit = max(STRETCH, SPREADS * spread[i] / middle[i])
            text = f"the link below the {name} is more than {limit:.0%} too long or short in {int(wrong[:, i].sum())} "
            notes.append(f"{text}frames: a point is misplaced; these angles are left empty")
        if spread[i] > 0.05 * middle[i]:  # a marker on skin moves by some per cent of a link
            text = f"the link below the {name} changes its length by {spread[i] / middle[i]:.0%} (SD): it leaves the "
            notes.append(f"{text}plane, or a point slides on the skin")
    return np.asarray(wrong)


def _wrong_lengths(length: Array, middle: Array) -> tuple[Mask, Array]:
    """(n, n_link) True where a link's ``length`` differs too much from its ``middle`` one; its robust SD (n_link,)."""
    off = np.abs(length - middle)
    spread = MAD_TO_SD * np.nanmedian(off, axis=0)
    return off > np.maximum(STRETCH * middle, SPREADS * spread), spread


def _scale(middle: Array, leg: Leg, notes: list[str]) -> float:
    """Metres per unit of the source; reports links whose proportion differs from the leg file."""
    wanted = np.array([joint.link.length for joint in leg.joints])
    scale = float(wanted.sum() / middle.sum())
    for name, ratio in zip(leg.joint_names, middle * scale / wanted, strict=True):
        if abs(ratio - 1.0) > MISMATCH:
            text = f"the link below the {name} is {abs(ratio - 1):.0%} {'longer' if ratio > 1 else 'shorter'} between "
            notes.append(f"{text}its points than in the leg file (relative to the whole leg): are the points in order?")
    return scale


def _turn_back(flat: Array, roll: float) -> Array:
    """Points (..., 2) of a picture that is turned counter-clockwise by ``roll`` rad, turned back."""
    cosine, sine = np.cos(roll), np.sin(roll)
    x, z = flat[..., 0], flat[..., 1]
    return np.stack([cosine * x + sine * z, cosine * z - sine * x], axis=-1)
