"""A drive's columns on another clock than the angles: late or early by more than any delay that is a cause.

Of a known torque the lag is that at which it is nearest to the torque that the designed leg needs to move as recorded,
of a servo's command that at which the designed leg's motion under it is nearest to the recorded one. Both are
proposals: whether the leg follows its recordings with the columns so shifted is decided as of all slips.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.lanes import Block, state_size
from synth.diagnosis.plants.swinging_chain.chain_candidates import natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_where import missing_torque
from synth.diagnosis.score import first_state
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo, ServoSignals
from synth.errors import UserError
from synth.fit.recordings import Recording, recordings
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

# Of a recording's length, the largest lag: the other two thirds show whether it is one.
MOST_SHARE = 1.0 / 3.0
# Of the smoothing's width, the spacing of the lags that are tried: what is compared holds nothing finer than the width.
STEP_SHARE = 0.25
MOST_LAGS = 500  # that are tried to either side; a longer recording's largest lag is shorter than ``MOST_SHARE``
# Of the mean square without a lag, what the best lag may leave to be tried. On a real pendulum swung up by a torque
# that scatters by as much as its leg file leaves, most recordings leave 0.02 to 0.2.
LEAST_GAIN = 0.25
# Another lag that leaves less than so many times the square of the best is as good: the motion repeats itself. Of the
# real pendulum's 5 swings that tell their lag at all, the second best leaves 1.8 times as much and more.
REPEATED = 1.5
APART = 2.0  # widths of the smoothing beyond which a lag is another one
# Of the longest delay that is a cause, the least lag of columns that are late, which no effect makes: a period
# over 2 pi.
LATE_SHARE = 0.5
MOST_TRIED = 3  # lags that are tried in simulations, those that most recordings show


@dataclass(frozen=True)
class OtherClock:
    """The columns of the drives of ``joints``, ``shift`` s later than recorded; see ``column_changes.Change``.

    ``recordings`` : names of those that show it.
    """

    joints: tuple[int, ...]
    shift: float
    recordings: frozenset[str]
    text: str
    remedy: str
    either: tuple[str, str] | None = None
    scale: float = 1.0
    must_follow: bool = False

    def of_leg(self, leg: Leg) -> Leg:
        """The leg file is not concerned."""
        return leg

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """With the columns shifted, and without the angles at which they are then not known."""
        made, torques, signals = self.compared(trial), trial.torques, trial.signals
        if torques is not None:
            torques = torques.copy()
            for j in self.joints:
                torques[:, j] = np.interp(trial.time - self.shift, trial.time, torques[:, j])
        if signals is not None:
            signals = _shifted(signals, self.joints, self.shift)
        return replace(made, torques=torques, signals=signals)

    def compared(self, trial: Trial) -> Trial:
        """As recorded, without the angles at which the shifted columns are not known."""
        known = [trial.time] if trial.torques is not None else []
        known += [trial.signals.time] if trial.signals is not None else []
        if not known:
            return trial
        begin, end = max(each[0] for each in known), min(each[-1] for each in known)
        there = trial.time - self.shift
        inside = (there >= begin) & (there <= end)
        return replace(trial, angles=np.where(inside[:, None], trial.angles, np.nan))


def _shifted(signals: ServoSignals, joints: Sequence[int], shift: float) -> ServoSignals:
    """Signals of which those of ``joints`` come ``shift`` s later, on the union of both times."""
    time, later = np.union1d(signals.time, signals.time + shift), replace(signals, time=signals.time + shift)
    chosen = np.isin(np.arange(signals.command.shape[1]), joints)
    command = np.where(chosen, later.commands_held(time), signals.commands_held(time))
    supply, enabled = (
        np.stack([np.interp(time - shift * late, signals.time, values[:, j]) for j, late in enumerate(chosen)], axis=1)
        for values in (signals.supply, signals.enabled)
    )
    return replace(signals, time=time, command=command, supply=supply, enabled=enabled)


@dataclass(frozen=True)
class _Lags:
    """What is left of a ``joint``'s motion in one recording with its column shifted; ``width`` s of its smoothing.

    ``left`` (n_shift,) : mean square over that without a shift, at all ``shifts`` (n_shift,) s of all recordings;
    infinite where the recording is too short for the shift. ``turned`` : the same with it combined with its own rate.
    """

    name: str
    joint: int
    width: float
    shifts: Array
    left: Array
    turned: float

    @property
    def own(self) -> float | None:
        """S, the shift that leaves least; None of one that leaves much, is the farthest, or no better than another."""
        best = int(np.argmin(self.left))
        others = self.left[np.abs(self.shifts - self.shifts[best]) > APART * self.width]
        inside = 0 < best < len(self.left) - 1 and np.all(np.isfinite(self.left[[best - 1, best + 1]]))
        rivals = min(self.turned, float(others.min(initial=np.inf)))
        told = inside and self.left[best] < LEAST_GAIN and self.left[best] * REPEATED <= rivals
        return float(self.shifts[best]) if told else None

    def shows(self, shift: float) -> bool:
        """Whether its column may be shifted by so much, s, as far as it can tell."""
        near = float(np.interp(shift, self.shifts, self.left))
        return near < min(LEAST_GAIN, self.turned / REPEATED) and (
            near <= REPEATED * self.left.min() or self.is_near(shift)
        )

    def is_near(self, shift: float) -> bool:
        """Whether the shift that leaves least is this one."""
        return bool(abs(self.shifts[np.argmin(self.left)] - shift) <= APART * self.width)


def lag_changes(leg: Leg, trials: Sequence[Trial], bench: Workbench, column: Callable[[int], str]) -> list[OtherClock]:
    """The lags that recordings show; ``column`` : name of a joint's driving one, empty without any."""
    driven = [j for j in range(len(leg.joints)) if column(j)]
    made = [angle_trial(each, held_out=False) for each in _read(leg, trials)] if driven else []
    if not made:
        return []
    sizes, shifts = natural_sizes_of(leg, made), _shifts(made)
    seen, least = list[_Lags](), dict[int, float]()
    for j in driven:
        servo = isinstance(leg.joints[j].drive, Servo)
        (delay,) = effect_named("command_delay" if servo else "torque_delay").parameters
        assert delay.prior is not None
        least[j] = delay.prior.upper * sizes.of(delay.unit, j)
        compared = partial(_motions if servo else _torques, leg, bench, j)
        seen += _lags_of(made, j, shifts, compared)
    changes = []
    for shift, joints in list(_together(seen))[:MOST_TRIED]:
        if abs(shift) < min(least[j] for j in joints) * (1.0 if shift > 0.0 else LATE_SHARE):
            continue
        names = frozenset(each.name for each in seen if each.shows(shift))
        sets = [tuple(driven), joints] if set(joints) < set(driven) else [joints]
        changes += [_change([column(j) for j in chosen], chosen, shift, names) for chosen in sets]
    return changes


def _change(columns: Sequence[str], joints: tuple[int, ...], shift: float, names: frozenset[str]) -> OtherClock:
    """With the words."""
    one, size = len(columns) == 1, significant(abs(shift), 2)
    which = f"the column{'' if one else 's'} {' and '.join(columns)} look{'s' if one else ''}"
    text = f"{which} {size} s {'early' if shift > 0.0 else 'late'} against the angles"
    remedy = f"shift {'it' if one else 'them'} by {'+' if shift > 0.0 else '-'}{size} s, or set the two clocks alike"
    return OtherClock(joints, shift, names, text, remedy)


def _read(leg: Leg, trials: Sequence[Trial]) -> Iterator[Recording]:
    """Those that can be read as motion and that a drive moves."""
    for trial in trials:
        try:
            (made,) = recordings(leg, [trial], ())
        except UserError:
            continue
        if made.driven:
            yield made


_Compared = tuple[Array, Array, Array]  # times (w,) s, what is wanted there (w,), what is given there (w,)


def _torques(leg: Leg, bench: Workbench, j: int, trial: AngleTrial) -> _Compared:
    """The torque, N m, that the joint needs, and the known one."""
    needed = missing_torque(leg, replace(trial, recording=replace(trial.recording, known_torque=None)))
    return needed.time, needed.torque[:, j], needed.torque[:, j] - missing_torque(leg, trial).torque[:, j]


def _motions(leg: Leg, bench: Workbench, j: int, trial: AngleTrial) -> _Compared:
    """The joint's recorded rotation, rad, and the designed leg's under the recorded command."""
    begun = first_state(trial)
    state = np.zeros(state_size(bench.predictor, len(bench.noise), ()))
    state[: len(begun)] = begun
    (moved,) = bench.predictor.predict([trial], [Block((), np.zeros((bench.n_tolerance, 1)), state[None, :, None])])
    counts = trial.counts[:, j] & np.isfinite(moved[:, j, 0])
    return trial.time[counts], trial.measured[counts, j], moved[counts, j, 0]


def _lags_of(
    trials: Sequence[AngleTrial], j: int, shifts: Array, compared: Callable[[AngleTrial], _Compared]
) -> list[_Lags]:
    """Of the trials in which the joint is free and driven."""
    kept = [(trial, compared(trial)) for trial in trials if j in trial.free]
    kept = [(trial, made) for trial, made in kept if len(made[0]) > 1 and np.ptp(made[2]) > 0.0]
    found = []
    for trial, made in kept:
        left = np.array([_left(*made, shift) for shift in shifts.tolist()], dtype=np.float64)
        recording = trial.recording
        found.append(_Lags(recording.name, j, recording.smoothed.width, shifts, left, _turned(*made)))
    return found


def _shifts(trials: Sequence[AngleTrial]) -> Array:
    """(n_shift,) s, that are tried of all joints and recordings."""
    step = STEP_SHARE * min(trial.recording.smoothed.width for trial in trials)
    count = min(int(MOST_SHARE * max(float(trial.time[-1]) for trial in trials) / step), MOST_LAGS)
    return np.asarray(step * np.arange(-count, count + 1), dtype=np.float64)


def _turned(time: Array, wanted: Array, given: Array) -> float:
    """Mean square that is left with the best sum of ``given`` and its rate, over that with ``given`` alone.

    A damper, spring or mass that the leg file does not have makes such a sum. Of a motion by a single sinusoid it is
    any lag.
    """
    columns = np.stack([given, np.gradient(given, time), np.ones(len(time))], axis=1)
    best, *_ = np.linalg.lstsq(columns, wanted, rcond=None)
    without = float(np.mean((wanted - given) ** 2))
    return float(np.mean((wanted - columns @ best) ** 2)) / without if without > 0.0 else 0.0


def _left(time: Array, wanted: Array, given: Array, shift: float) -> float:
    """Mean square that is left with ``given`` shifted, over that without, both where the shifted one is known."""
    if abs(shift) > MOST_SHARE * (time[-1] - time[0]):
        return np.inf
    known = (time - shift >= time[0]) & (time - shift <= time[-1])
    without = float(np.mean((wanted[known] - given[known]) ** 2))
    away = wanted[known] - np.interp(time[known] - shift, time, given)
    return float(np.mean(away**2)) / without if without > 0.0 else np.inf


def _together(seen: Sequence[_Lags]) -> Iterator[tuple[float, tuple[int, ...]]]:
    """S, lags that recordings agree in, with the joints of these; of most recordings first."""
    rest = [(each, own) for each in seen if (own := each.own) is not None]
    while rest:
        most = max(([each for each, _ in rest if each.is_near(own)] for _, own in rest), key=len)
        rest = [(each, own) for each, own in rest if not any(each is other for other in most)]
        left = np.mean([np.minimum(each.left, 1.0) for each in most], axis=0)
        yield _vertex(most[0].shifts, left), tuple(sorted({each.joint for each in most}))


def _vertex(shifts: Array, left: Array) -> float:
    """S, where the parabola through the least and its neighbours is least."""
    best = min(max(int(np.argmin(left)), 1), len(left) - 2)
    before, here, after = left[best - 1 : best + 2].tolist()
    bend = before - 2.0 * here + after
    return float(shifts[best] + (0.5 * (shifts[1] - shifts[0]) * (before - after) / bend if bend > 0.0 else 0.0))
