"""Cut recordings where their motion amplifies small deviations, and join what was predicted of the pieces.

Over the top of a pendulum a deviation grows like exp(t sqrt(g / l)). A prediction from the initial state alone then
tells little about the leg after a few such times: the cost gets many minima, and the best fit to the whole recording
need not follow any part of it. Pieces with initial states of their own are followed by a model that is nearly right
(multiple shooting: Bock, *Recent advances in parameter identification techniques for O.D.E.*, 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.lanes import Block, LanePredictor
from synth.diagnosis.plants.swinging_chain.leg_torques import joint_torques
from synth.diagnosis.score import first_state
from synth.remarks import noted
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, momentum_and_force
from synth.threads import in_parallel

# Times that a deviation grows in a whole recording, beyond which it is cut: limbs stay below 6, a pendulum of .5 m at
# its top reaches it in .6 s. In a piece it grows less: near the top the errors of the torque's readings grow too, and
# in longer pieces they decide what is left. Decided by ``make rigs`` (a pendulum that swings up and balances).
MOST_GROWTH, MOST_GROWTH_IN_PIECE = 8.0, 4.0
PERIOD_IN_PACES = 4.0 * np.pi  # paces, which are half a radian of the motion's phase each
# Share of a deviation left after a period, from which on a leg hardly forgets: a damping ratio of .11.
FORGETTING_SHARE = 0.5
LOST_SHARE = 0.25  # of the motion, error of the nominal leg beyond which it does not follow it
LEAST_SAMPLES = 24  # of a piece, which has an initial angle and rate a joint
SAMPLES_BETWEEN = 8  # samples between the deviations that are followed
DERIVATIVE_STEP = 1e-6  # rad, and that over the motion's unit of time in rad/s, of the derivatives


def cut_into_pieces(leg: Leg, predictor: LanePredictor, trials: Sequence[AngleTrial]) -> tuple[AngleTrial, ...]:
    """The trials, those along whose motion errors grow or add up in pieces.

    A recording along which deviations grow more than ``MOST_GROWTH`` times is cut. So is one where a known torque
    drives a leg that hardly forgets, and the nominal leg loses the motion, into pieces of about half a period: what the
    torque is off acts all along, and the motion adds it up. In a piece deviations grow at most ``MOST_GROWTH_IN_PIECE``
    times. A leg that loses the motion is judged without its springs and dampers, since one of them may be what is
    wrong: a stated damper that is not there would let it forget, and the pieces get too long. Legs that servos drive
    are left whole: a servo holds them, and has a memory that a piece would not know.
    """
    found = in_parallel(lambda i: _pieces_of_trial(leg, predictor, trials[i]), len(trials))
    return tuple(piece for pieces in found for piece in pieces)


def _pieces_of_trial(leg: Leg, predictor: LanePredictor, trial: AngleTrial) -> list[AngleTrial]:
    if trial.recording.signals is not None:
        return [trial]
    lost = trial.recording.known_torque is not None and _loses_the_motion(predictor, trial)
    nominal = trial.recording.leg or leg
    along = Deviations.of(_without_springs_and_dampers(nominal) if lost else nominal, trial)
    period, longest = PERIOD_IN_PACES * trial.recording.smoothed.pace, len(trial.time)
    if lost and along.kept(period) > FORGETTING_SHARE:
        number = round(float(trial.time[-1]) / (0.5 * period))
        longest = max(-(-len(trial.time) // max(number, 1)), LEAST_SAMPLES)
    if len(along.cuts(longest, MOST_GROWTH)) == 1:
        return [trial]
    begins = along.cuts(longest, MOST_GROWTH_IN_PIECE)
    return [trial.piece(first, last) for first, last in zip(begins, [*begins[1:], len(trial.time)], strict=True)]


def _without_springs_and_dampers(leg: Leg) -> Leg:
    """The leg without springs and dampers."""
    return leg.with_joints(**{name: {"spring": None, "damper": None} for name in leg.joint_names})


def _loses_the_motion(predictor: LanePredictor, trial: AngleTrial) -> bool:
    """Whether the unchanged nominal leg, from the state that the first samples show, does not follow the motion."""
    block = Block((), np.zeros((predictor.n_tolerance, 1)), first_state(trial)[None, :, None])
    error = np.where(trial.counts, predictor.predict([trial], [block])[0][:, :, 0] - trial.measured, 0.0)
    motion = np.where(trial.counts, trial.measured - trial.measured.mean(axis=0), 0.0)
    return not float(np.sum(error**2)) <= LOST_SHARE**2 * float(np.sum(motion**2))


@dataclass(frozen=True)
class Deviations:
    """How deviations of the free joints' angles and momenta pass along a recorded motion of the nominal leg.

    ``step`` (m - 1, 2 n, 2 n) : from each sample to the next, by the trapezoidal rule of the variational equation;
    ``momentum`` (m, n, n) N m s/rad : a deviation of the momenta that goes with one of the angles at equal rates;
    ``forgetting`` : mean rate of decay of a deviation, 1/s (Liouville's formula).
    """

    step: Array
    momentum: Array
    forgetting: float

    def kept(self, time: float) -> float:
        """Share of a deviation, the mean of all directions, that is left after a ``time``, s."""
        return float(np.exp(-self.forgetting * time))

    def cuts(self, longest: int, most: float) -> list[int]:
        """Index of the first sample of each piece: as few as keep growth at ``most``, and samples at ``longest``.

        A deviation of the angles at some sample of a piece is followed to the piece's end.
        """
        count, n = len(self.momentum), self.momentum.shape[1]
        begins, followed = [0], np.zeros((0, 2 * n, n))
        for sample in range(count - LEAST_SAMPLES):
            if (sample - begins[-1]) % SAMPLES_BETWEEN == 0:
                begun = np.concatenate([np.eye(n), self.momentum[sample]])
                followed = np.concatenate([followed, begun[None]])
            followed = self.step[sample] @ followed
            length = sample + 1 - begins[-1]
            grown = np.abs(followed[:, :n]).max() > most and length >= LEAST_SAMPLES
            if grown or length >= longest:
                begins.append(sample + 1)
                followed = followed[:0]
        return begins

    @classmethod
    def of(cls, leg: Leg, trial: AngleTrial) -> Deviations:
        """Along a trial's smoothed motion."""
        smoothed, n = trial.recording.smoothed, len(leg.joints)
        nearest = np.clip(np.searchsorted(smoothed.time, trial.time), 0, len(smoothed.time) - 1)
        angle, rate = smoothed.angle[nearest], smoothed.rate[nearest]
        conditions = trial.recording.conditions
        found, tilt = coefficients(leg, conditions.tip), leg.tilt + conditions.tilt

        def flow(angle: Array, rate: Array) -> Array:
            momentum, force = momentum_and_force(found, angle, rate, tilt)
            return np.concatenate([momentum, force + joint_torques(leg, angle, rate)], axis=1)

        here, moved = flow(angle, rate), np.eye(n)
        by_angle = np.stack(
            [(flow(angle + DERIVATIVE_STEP * one, rate) - here) / DERIVATIVE_STEP for one in moved], axis=2
        )
        fast = DERIVATIVE_STEP / trial.time_unit
        by_rate = np.stack([(flow(angle, rate + fast * one) - here) / fast for one in moved], axis=2)
        free = trial.free
        momentum, mass = by_angle[:, free][:, :, free], by_rate[:, free][:, :, free]
        below = np.array(free) + n
        force, damping = by_angle[:, below][:, :, free], by_rate[:, below][:, :, free]
        inverse = np.linalg.inv(mass)
        rates = np.concatenate([-inverse @ momentum, inverse], axis=2)  # from deviations of angle and momentum
        slope = np.concatenate([rates, damping @ rates], axis=1)
        slope[:, len(free) :, : len(free)] += force
        half = 0.25 * np.diff(trial.time)[:, None, None] * (slope[1:] + slope[:-1])
        one = np.eye(2 * len(free))
        step = np.asarray(np.linalg.solve(one - half, one + half))
        forgetting = -float(np.trace(slope, axis1=1, axis2=2).mean()) / (2 * len(free))
        return cls(step, momentum, forgetting)


def whole_recordings(trials: Sequence[AngleTrial]) -> tuple[AngleTrial, ...]:
    """The recordings that trials are, or are pieces of; in order, each once."""
    return tuple({id(trial.whole): trial.whole for trial in trials}.values())


def join_pieces(trials: Sequence[AngleTrial], predicted: Sequence[Array]) -> tuple[Array, ...]:
    """(m, n) of each of the ``whole_recordings``, from (m, n) of each trial or piece."""
    rows: dict[int, list[Array]] = {}
    for trial, rotation in zip(trials, predicted, strict=True):
        rows.setdefault(id(trial.whole), []).append(rotation)
    return tuple(np.concatenate(each) for each in rows.values())


def cut_sentence(trials: Sequence[AngleTrial]) -> str:
    """The remark on recordings that were cut; empty without any."""
    cut = [trial for trial in trials if trial.part_of]
    if not cut:
        return ""
    whole, length = whole_recordings(cut), float(np.median([trial.time[-1] for trial in cut]))
    of = whole[0].recording.name if len(whole) == 1 else f"{len(whole)} of {len(whole_recordings(trials))} recordings"
    return noted(
        f"{of}: errors grow or add up along the motion, so it is compared in {len(cut)} pieces of {length:.2g} s "
        "(median), each from an initial state of its own"
    )
