"""Arrow-shaped normal equations: common unknowns, and each trial's own unknowns, which are eliminated.

In the Hessian of a fit to many trials, a trial's own unknowns (its initial state) couple only to the common ones.
Eliminating them trial by trial makes the cost of a step linear in the number of trials (Triggs et al. 2000, "Bundle
adjustment", section 6). A damped step of the common unknowns is computed from one of two matrices:

``ArrowNormal``
    damps the whole matrix, then eliminates: Levenberg-Marquardt on all unknowns.
``ReducedNormal``
    eliminates, then damps: Levenberg-Marquardt on the variable projection (Golub & Pereyra, SIAM J. Numer. Anal. 10
    (1973) 413). Each trial's share of the reduced matrix is stored, so a fit without that trial has a closed form.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array

# Relative and absolute damping of every step: they keep a matrix with a null direction invertible. The relative
# one is 500 times the rounding of a double (2e-16), and a tenth of the least damping of any rule (1e-12).
LEAST_DAMPING, LEAST_DIAGONAL = 1e-13, 1e-300
# Most damping of own unknowns that follow a common step: it bounds those that a trial hardly determines, the state of a
# soft link.
FOLLOWING_DAMPING = 1e-3
HELD_ROUNDS = 6  # repetitions of a step because a further unknown reaches its bound


@dataclass(frozen=True)
class Information:
    """Arrow-shaped normal matrix: ``common`` (p, p), and ``cross`` (p, l) and ``own`` (l, l) per trial."""

    common: Array
    cross: tuple[Array, ...]
    own: tuple[Array, ...]

    def schur(self) -> Array:
        """(p, p) information on the common unknowns with every trial's own unknowns estimated."""
        reduced = self.common.copy()
        for cross, own in zip(self.cross, self.own, strict=True):
            reduced -= cross @ np.linalg.solve(own, cross.T)
        return 0.5 * (reduced + reduced.T)


@dataclass(frozen=True)
class OwnGroup:
    """Trials with the same number of own unknowns, stacked.

    ``trials`` : their indices (t,). ``matrix`` (t, l, l), ``gradient`` (t, l), ``cross`` (t, l, p).
    """

    trials: Sequence[int]
    matrix: Array
    gradient: Array
    cross: Array

    @property
    def diagonal(self) -> Array:
        """(t, l)."""
        return np.diagonal(self.matrix, axis1=1, axis2=2)

    def steps(self, common: Array, dampings: Array, scale: Array, *, follow: bool) -> Array:
        """(n_step, t, l) damped own steps for the common steps ``common`` (n_step, p).

        With ``follow`` only the correction of the own unknowns themselves is damped fully; what makes up for the common
        step hardly. A reduced gradient presumes that: without it no small step lowers the cost of a motion that depends
        on its initial state much more than on the common unknowns.
        """
        coupled = (self.cross @ common.T).transpose(2, 0, 1)
        added = (dampings[:, None, None] + LEAST_DAMPING) * scale + LEAST_DIAGONAL
        eye = np.eye(self.matrix.shape[1])
        damped = self.matrix + added[:, :, :, None] * eye
        if not follow:
            return np.asarray(-np.linalg.solve(damped, (self.gradient + coupled)[..., None])[..., 0])
        alone = np.linalg.solve(damped, np.broadcast_to(self.gradient, coupled.shape)[..., None])[..., 0]
        least = (np.minimum(dampings, FOLLOWING_DAMPING)[:, None, None] + LEAST_DAMPING) * scale + LEAST_DIAGONAL
        hardly = self.matrix + least[:, :, :, None] * eye
        return np.asarray(-alone - np.linalg.solve(hardly, coupled[..., None])[..., 0])


@dataclass(frozen=True)
class ParameterStep:
    """A step of the ``common`` unknowns (p,) and of each trial's ``own`` (l,)."""

    common: Array
    own: tuple[Array, ...]


@dataclass(frozen=True)
class DampingScale:
    """The scale of the damping: ``common`` (p,), and (t, l) per group of trials."""

    common: Array
    own: tuple[Array, ...]

    def remembering(self, last: DampingScale | None, memory: float) -> DampingScale:
        """At least the share ``memory`` of the last step's scale, so that it cannot collapse in one step."""
        if last is None or memory == 0.0:
            return self
        own = tuple(np.maximum(memory * a, b) for a, b in zip(last.own, self.own, strict=True))
        return DampingScale(np.maximum(memory * last.common, self.common), own)


@dataclass(frozen=True)
class StepLimits:
    """Step limits; a longer step is shortened as a whole.

    ``common`` : largest change of each common unknown, (p,) or one number; ``own`` : of a trial's own. ``follow`` :
    each trial's own step is optimal for the common step after shortening and bounds; otherwise it is solved first and
    shortened with the common step.
    """

    common: Array | float = np.inf
    own: float = np.inf
    follow: bool = False


@dataclass(frozen=True)
class NormalEquations(ABC):
    """``groups`` : the trials' own unknowns. Gradients are of the cost at the point of linearisation."""

    groups: tuple[OwnGroup, ...]

    @property
    @abstractmethod
    def scale(self) -> DampingScale:
        """The diagonals of the damped matrices."""

    @abstractmethod
    def damped(self, damping: float, scale: DampingScale) -> tuple[Array, Array]:
        """Damped matrix (p, p) and gradient (p,) of the common unknowns, with the trials' own eliminated."""

    @abstractmethod
    def predicted_fall(self, step: ParameterStep) -> float:
        """Decrease of the cost that the linearisation predicts for an undamped step."""

    def steps(
        self, at: Array, dampings: Array, scale: DampingScale, bounds: tuple[Array, Array], limits: StepLimits
    ) -> list[ParameterStep]:
        """One step for each of ``dampings`` (n_step,) from the common unknowns ``at`` (p,).

        Unknowns at a bound that would move outwards are fixed; so are those with equal bounds.
        """
        low, high = bounds
        made = [self._held_step(*self.damped(damping, scale), at, bounds) for damping in dampings.tolist()]
        common = np.array([step * _share(step, limits.common) for step in made])
        if limits.follow:
            common = np.clip(at + common, low, high) - at
            return self._with_own(common, dampings, scale, follow=True)
        steps = self._with_own(np.array(made), dampings, scale)
        shortened = []
        for step in steps:
            longest = max((float(np.max(np.abs(own), initial=0.0)) for own in step.own), default=0.0)
            share = min(_share(step.common, limits.common), limits.own / max(longest, 1e-300))
            moved = np.clip(at + share * step.common, low, high) - at
            shortened.append(ParameterStep(moved, tuple(share * own for own in step.own) if share < 1.0 else step.own))
        return shortened

    @staticmethod
    def _held_step(matrix: Array, gradient: Array, at: Array, bounds: tuple[Array, Array]) -> Array:
        """Step (p,) without the unknowns at their bounds."""
        low, high = bounds
        held = low >= high
        step = np.zeros(len(at))
        for _ in range(HELD_ROUNDS):
            moving = ~held
            step[:] = 0.0
            if moving.all():
                step[:] = -np.linalg.solve(matrix, gradient)
            elif moving.any():
                step[moving] = -np.linalg.solve(matrix[np.ix_(moving, moving)], gradient[moving])
            outward = ((at <= low) & (step < 0.0)) | ((at >= high) & (step > 0.0))
            if not np.any(outward & ~held):
                break
            held = held | outward
        return step

    def _with_own(
        self, common: Array, dampings: Array, scale: DampingScale, *, follow: bool = False
    ) -> list[ParameterStep]:
        """Steps including each trial's own unknowns, from the common steps (n_step, p)."""
        count = sum(len(group.trials) for group in self.groups)
        own: list[list[Array]] = [[np.zeros(0)] * count for _ in common]
        for group, width in zip(self.groups, scale.own, strict=True):
            for made, steps in zip(own, group.steps(common, dampings, width, follow=follow), strict=True):
                for trial, step in zip(group.trials, steps, strict=True):
                    made[trial] = step
        return [ParameterStep(one, tuple(made)) for one, made in zip(common, own, strict=True)]


def _share(step: Array, longest: Array | float) -> float:
    """Factor, at most 1, that keeps every part of a step within its limit."""
    return float(min(1.0, np.min(longest / np.maximum(np.abs(step), 1e-300), initial=1.0)))


@dataclass(frozen=True)
class ArrowNormal(NormalEquations):
    """Normal matrix of all unknowns and gradient of the common ones; damped before the elimination."""

    information: Information
    gradient: Array

    @classmethod
    def of(cls, information: Information, gradient: Array, own_gradient: Sequence[Array]) -> ArrowNormal:
        """From the matrix and gradients (l,) per trial."""
        return cls(
            stacked_by_size(information.own, own_gradient, [c.T for c in information.cross]), information, gradient
        )

    @property
    def scale(self) -> DampingScale:
        """The diagonals."""
        return DampingScale(
            np.diag(self.information.common).copy(), tuple(group.diagonal.copy() for group in self.groups)
        )

    def damped(self, damping: float, scale: DampingScale) -> tuple[Array, Array]:
        """Schur complement of the damped matrix."""
        matrix = self.information.common + np.diag((damping + LEAST_DAMPING) * scale.common + LEAST_DIAGONAL)
        gradient = self.gradient.copy()
        for group, width in zip(self.groups, scale.own, strict=True):
            added = (damping + LEAST_DAMPING) * width + LEAST_DIAGONAL
            damped = group.matrix + added[:, :, None] * np.eye(group.matrix.shape[1])
            both = np.linalg.solve(damped, np.concatenate([group.cross, group.gradient[:, :, None]], axis=2))
            eliminated = np.tensordot(group.cross, both, axes=((0, 1), (0, 1)))
            matrix -= eliminated[:, :-1]
            gradient -= eliminated[:, -1]
        return matrix, gradient

    def predicted_fall(self, step: ParameterStep) -> float:
        """Half the gradient along the step, -g.h/2: the quadratic model's fall of an undamped step.

        Of a damped step at least half of the model's: a rule that takes it for the model's lowers the damping sooner.
        """
        fall = -0.5 * float(self.gradient @ step.common)
        for group in self.groups:
            for trial, gradient in zip(group.trials, group.gradient, strict=True):
                fall -= 0.5 * float(gradient @ step.own[trial])
        return fall


@dataclass(frozen=True)
class ReducedNormal(NormalEquations):
    """``matrix`` (p, p) and ``gradient`` (p,) with the trials' own unknowns eliminated; damped afterwards.

    ``parts`` : each trial's contribution to both; ``weight`` of half its squares in the cost, against the priors.
    """

    matrix: Array
    gradient: Array
    parts: tuple[tuple[Array, Array], ...]
    weight: float

    @classmethod
    def of(cls, information: Sequence[TrialNormal], prior: Array, prior_gradient: Array) -> ReducedNormal:
        """From each trial's normal equations and the prior's information (p, p) and gradient (p,)."""
        parts = tuple(trial.reduced() for trial in information)
        groups = stacked_by_size(
            [trial.own for trial in information],
            [trial.own_gradient for trial in information],
            [trial.cross.T for trial in information],
        )
        matrix = sum((part for part, _ in parts), prior.copy())
        gradient = sum((part for _, part in parts), prior_gradient.copy())
        return cls(groups, matrix, gradient, parts, 1.0)

    @property
    def scale(self) -> DampingScale:
        """The diagonals: of the reduced matrix, and of the trials' own."""
        return DampingScale(np.diag(self.matrix), tuple(group.diagonal for group in self.groups))

    def covariance(self, variance: float) -> Array:
        """(p, p) covariance of the errors of the common unknowns at the cost's least, of residuals of this variance.

        The inverse information where the cost weighs squares by the inverse of their variance. Where it weighs them
        otherwise, ``H^-1 V H^-1`` with the cost's curvature ``H`` and the covariance ``V`` of its gradient (Huber, 5th
        Berkeley Symp. Math. Stat. Prob. 1 (1967) 221). Priors hold as stated.
        """
        trials = sum((part for part, _ in self.parts), np.zeros_like(self.matrix))
        spread = self.weight * variance * trials + (self.matrix - trials)
        inverse = np.linalg.inv(self.matrix)
        found = inverse @ spread @ inverse
        return np.asarray(0.5 * (found + found.T))

    def damped(self, damping: float, scale: DampingScale) -> tuple[Array, Array]:
        """The reduced matrix with its damping."""
        added = (damping + LEAST_DAMPING) * scale.common + LEAST_DIAGONAL
        return self.matrix + np.diag(added), self.gradient

    def predicted_fall(self, step: ParameterStep) -> float:
        """Half the gradient along the common step: of an undamped one that the trials' own unknowns follow."""
        return -0.5 * float(self.gradient @ step.common)

    def without(self, trial: int) -> Array:
        """(p,) Gauss-Newton step to the fit of all trials but one, in closed form."""
        matrix, gradient = self.parts[trial]
        return -np.asarray(np.linalg.solve(self.matrix - matrix, self.gradient - gradient))


@dataclass(frozen=True)
class TrialNormal:
    """One trial's normal equations: ``common`` (p, p), ``cross`` (p, l), ``own`` (l, l), and both gradients."""

    common: Array
    cross: Array
    own: Array
    gradient: Array
    own_gradient: Array

    def reduced(self) -> tuple[Array, Array]:
        """Matrix (p, p) and gradient (p,) with the trial's own unknowns eliminated."""
        both = np.linalg.solve(self.own, np.column_stack([self.cross.T, self.own_gradient]))
        return self.common - self.cross @ both[:, :-1], self.gradient - self.cross @ both[:, -1]


def stacked_by_size(own: Sequence[Array], gradient: Sequence[Array], cross: Sequence[Array]) -> tuple[OwnGroup, ...]:
    """Trials with the same number of own unknowns, stacked; ``cross`` (l, p) per trial."""
    trials: dict[int, list[int]] = {}
    for index, matrix in enumerate(own):
        trials.setdefault(len(matrix), []).append(index)
    return tuple(
        OwnGroup(
            group,
            np.array([own[i] for i in group]),
            np.array([gradient[i] for i in group]),
            np.array([cross[i] for i in group]),
        )
        for group in trials.values()
    )
