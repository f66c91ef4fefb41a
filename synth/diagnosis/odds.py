"""Odds of hypotheses: by what they leave of the trials they were fitted to, and of trials that they were not.

Where the best explanation reaches the sensor's noise, its residuals are white and the fits themselves tell most: the
evidence is the cost with the tolerances' priors (200 simulated cases with a cause of known form: top-1 100 against 85 %
by trials left out). Where it stays far above the noise, what is left is the model's own remainder: it is correlated, it
differs from trial to trial, and its size is not known. There the trials left out decide. A trial with errors of mean
square ``s`` counts ``m/2 log(1 + s)``, the log-likelihood of ``m`` independent errors of unknown size; the trials are
weighed anew by a Bayesian bootstrap (pseudo-BMA+: Yao, Vehtari, Simpson & Gelman, Bayesian Analysis 13 (2018) 917), so
that a difference that hangs on one trial is no certainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessed, F, HeldOutError

# RMS over the noise floor that the best explanation leaves on unseen trials: below the first it is at the floor, from
# the second on it is a remainder. Explanations of another form than the truth leave up to 3 on clean simulated cases.
AT_FLOOR, FAR = 3.0, 9.0
# Errors of a trial that count as independent at most: what a model of this kind misses is shared by neighbouring
# swings, and causes that do nearly the same (a reading shifted or scaled, a shifted torque) are tied, not told apart.
MOST_INDEPENDENT = 8.0
DRAWS = 400  # of the bootstrap: a probability of 0.05 is known to 0.01


@dataclass(frozen=True)
class Calibration:
    """What turns costs into probabilities; tuned on simulated cases (``tests/blind``, seeds 1000, 1001 and 2000).

    ``temperature`` : of the softmax over costs, for forms that do not get their cause quite right. ``per_parameter`` :
    what an unknown more must earn. ``none``, ``single``, ``pair``, ``triple`` : prior probabilities that nothing, one
    cause, two or three are missing, shared evenly among their hypotheses. ``left`` : share of the squared gap that the
    best explanation may leave for an unknown cause to be as likely as not, ``left_by_several`` that of several causes,
    ``misfit`` how fast that probability grows with its logarithm, ``doubt`` its least where something is missing: now
    and then what is in no list does the same as what is in it; ``doubt_of_several`` where it takes several causes to do
    the same, of which one may be any other's; ``clean`` : RMS over the noise floor up to which nothing is taken to be
    left; ``far`` : RMS over the floor beyond which less may be left, by the root of it: what is right leaves little
    that a good sensor still sees far above its noise. ``tie_odds`` : odds below which explanations are said to be tied.
    ``pays`` : share of what fewer causes leave of the squared gap that one more must take away; form errors of a cause
    that is right are taken up by others by a tenth.

    For a remainder far above the noise, by unseen trials: ``most`` : share of the gap's RMS that the best explanation
    must take for an unknown cause to be less likely than not; ``steep`` : how fast that probability falls with the
    share; ``free_leads`` : share that a free torque may take more than it; ``doubt_far`` : the least doubt there: of
    twelve dirty rigs of seed 4100 with one main cause ten got it first.
    """

    temperature: float = 3.0
    per_parameter: float = 4.0
    none: float = 0.3
    single: float = 0.5
    pair: float = 0.19
    triple: float = 0.01
    misfit: float = 2.0
    left: float = 0.2
    left_by_several: float = 0.07
    pays: float = 0.4
    doubt: float = 0.05
    doubt_of_several: float = 0.25
    clean: float = 1.25
    far: float = 5.0
    tie_odds: float = 6.0
    most: float = 0.35
    steep: float = 10.0
    free_leads: float = 0.15
    doubt_far: float = 0.2


CALIBRATED = Calibration()


def far_share(hypotheses: Sequence[Assessed[F]]) -> float:
    """How far the best explanation is from the noise: 0 at the floor, 1 where its remainder is the model's own."""
    known = [h.unseen.typical for h in hypotheses if h.unseen is not None]
    if not known:
        return 0.0
    place = np.log(max(min(known), 1e-9) / AT_FLOOR) / np.log(FAR / AT_FLOOR)
    return float(np.clip(place, 0.0, 1.0))


def weigh(hypotheses: Sequence[Assessed[F]], calibration: Calibration, singles: int = 0) -> Array:
    """(n,) posterior weights: prior times exp(-cost / temperature), costs with what their unknowns must earn.

    Far from the noise by unseen trials instead, see above; between the two by both in proportion.
    ``singles`` : how many single causes there are, where they are not all among the hypotheses.
    """
    counts = np.array([len(h.keys) for h in hypotheses])
    unknowns = np.array([h.n_unknown for h in hypotheses])
    singles = max(int(np.sum(counts == 1)), singles, 1)
    together = [calibration.none, calibration.single, calibration.pair, calibration.triple]
    prior = np.array([np.log(together[k] * factorial(k) / singles**k) for k in counts])
    cost = np.array([h.cost for h in hypotheses]) + calibration.per_parameter * unknowns
    share = far_share(hypotheses)
    told = prior - (1.0 - share) * (cost - cost.min()) / calibration.temperature
    draws = told[:, None] - share * _drawn(hypotheses) if share > 0.0 else told[:, None]
    weights = np.exp(draws - draws.max(axis=0))
    return np.asarray((weights / weights.sum(axis=0)).mean(axis=1))


def _drawn(hypotheses: Sequence[Assessed[F]]) -> Array:
    """(n, DRAWS) negative log-likelihood of unseen trials, these weighed anew in each draw.

    A hypothesis without unseen errors has the nominal leg's, less what it gained on the trials that it was fitted to.
    """
    best = min((h.unseen for h in hypotheses if h.unseen is not None), key=lambda unseen: unseen.typical)
    independent = np.minimum(best.independent, MOST_INDEPENDENT)
    first = hypotheses[0]
    rows = []
    for item in hypotheses:
        known = item.unseen or first.unseen
        assert known is not None
        gained = 0.0 if item.unseen is not None else 2.0 * np.log(item.ratio / first.ratio)
        rows.append(0.5 * independent * (np.log1p(known.by_trial) + gained))
    count = len(independent)
    picks = np.random.default_rng(0).dirichlet(np.ones(count), DRAWS) * count
    return np.asarray(np.array(rows) @ picks.T)


def taken(item: Assessed[F], none: Assessed[F]) -> float:
    """Share of the gap's RMS that a hypothesis takes: on unseen trials where they are known."""
    if item.unseen is None or none.unseen is None:
        left, gap = (np.sqrt(max(each.ratio**2 - 1.0, 0.0)) for each in (item, none))
        return float(1.0 - left / gap) if gap > 0.0 else 0.0
    return taken_of(item.unseen, none.unseen)


def taken_of(left: HeldOutError, before: HeldOutError) -> float:
    """Share of the RMS above the noise that is taken in a typical trial."""
    above = [float(np.sqrt(max(each.typical**2 - 1.0, 0.0))) for each in (left, before)]
    return 1.0 - above[0] / above[1] if above[1] > 0.0 else 0.0
