"""The score: the methods' diagnoses joined with the answers, and the levels to reach."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind.chance import Array, bootstrap, calibrated_by_chance, calibration_error, wilson
from blind.views import Key, View

CLEAR = 3.0  # gap over floor from which an effect must be named
CONFIDENT = 0.8
LEAST_TO_GAIN = 0.05  # least best-possible shrink for which a share of it is meaningful
Answer = Mapping[str, Any]


@dataclass(frozen=True)
class Level:
    """Plain, strong and goal; ``most``: the value may be at most that, instead of at least."""

    plain: float
    strong: float
    goal: float
    most: bool = False

    @property
    def least(self) -> str:
        """The lowest level."""
        return next(name for name in ("plain", "strong", "goal") if math.isfinite(getattr(self, name)))

    def reached(self, value: float) -> str:
        """The highest level that the value reaches."""
        met = ""
        for name in ("plain", "strong", "goal"):
            level = getattr(self, name)
            if (value <= level) if self.most else (value >= level):
                met = name
        return met


@dataclass(frozen=True)
class Score:
    """One line of the table: ``value`` (a share, or in ``unit``) with its 90 % interval over ``count`` cases."""

    key: str
    what: str
    value: float
    interval: tuple[float, float]
    count: int
    unit: str = "%"
    level: Level | None = None

    @property
    def reached(self) -> str:
        """Level of the value; empty where there is none or no case."""
        return "" if self.level is None or not self.count else self.level.reached(self.value)

    def as_json(self) -> dict[str, Any]:
        """The entry of ``blind.json``; shares as fractions of 1."""
        level = None if self.level is None else {k: v for k, v in vars(self.level).items() if v == v}
        value = self.value if self.count else None
        interval = list(self.interval) if self.count else None
        return {
            "what": self.what, "value": value, "interval90": interval, "unit": "1" if self.unit == "%" else self.unit,
            "cases": self.count, "level": level, "reached": self.reached,
        }  # fmt: skip


LEVELS = {  # FACTS of the field: plain, strong, goal
    "top1": Level(0.45, 0.75, 0.92),
    "top3": Level(math.nan, math.nan, 0.98),
    "joint": Level(0.70, 0.90, 0.97),
    "shrink_median": Level(0.6, 0.85, 0.97),
    "shrink_p10": Level(0.1, 0.5, 0.85),
    "false_alarm": Level(0.30, 0.08, 0.02, most=True),
    "calibration": Level(0.20, 0.08, 0.03, most=True),
    "unknown_flagged": Level(0.10, 0.60, 0.90),
    "unknown_wrong": Level(0.60, 0.20, 0.03, most=True),
    "tie_reported": Level(0.0, 0.50, 0.90),
    "tie_gain": Level(0.0, 15.0, 35.0),
    "two_named": Level(0.15, 0.50, 0.80),
}


def true_keys(answer: Answer) -> list[Key]:
    """Effects and joints that are in the case."""
    return [(effect["effect"], effect["joint"]) for effect in answer["effects"]]


def strength(answer: Answer) -> float:
    """Of the first effect, in floors; 0 without one."""
    return float(answer["effects"][0]["strength"]) if answer["effects"] else 0.0


def clear_single(answer: Answer) -> bool:
    """One effect of the library without a rival, whose gap is well above the floor."""
    return answer["kind"] == "single" and strength(answer) >= CLEAR


def scores(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Every line of the table for one method that gives verdicts and probabilities."""
    return [*naming(answers, views), *shrinking(answers, views), *verdicts(answers, views), *ties(answers, views)]


def _share(key: str, what: str, hits: Iterable[bool]) -> Score:
    found = list(hits)
    right, count = sum(found), len(found)
    return Score(key, what, right / count if count else math.nan, wilson(right, count), count, "%", LEVELS.get(key))


def naming(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Which effect and which joint: for every method that ranks causes."""
    clear = [name for name, answer in answers.items() if clear_single(answer)]
    faint = [n for n, a in answers.items() if a["kind"] == "single" and strength(a) < CLEAR]
    two = [name for name, answer in answers.items() if answer["kind"] == "two"]

    def effect(name: str) -> str:
        return str(true_keys(answers[name])[0][0])

    def joint(name: str) -> str:
        return str(true_keys(answers[name])[0][1])

    return [
        _share("top1", "effect named first (gap/floor ≥ 3)", (views[n].first[0][0] == effect(n) for n in clear)),
        _share("top3", "effect among the first three", (effect(n) in [e for e, _ in views[n].keys[:3]] for n in clear)),
        _share("joint", "joint named first", (views[n].first[0][1] == joint(n) for n in clear)),
        _share("both", "effect and joint named first", (views[n].first[0] == true_keys(answers[n])[0] for n in clear)),
        _share("faint", "effect named first, gap/floor 1.5", (views[n].first[0][0] == effect(n) for n in faint)),
        _share("two_named", "two effects, both named", (_both(answers[n], views[n], 0) for n in two)),
        _share(
            "two_placed", "two effects, both named at their joints", (_both(answers[n], views[n], None) for n in two)
        ),
    ]


def _both(answer: Answer, view: View, part: int | None) -> bool:
    """Whether the explanation holds both effects: by name (part 0), or name and joint."""

    def seen(keys: Iterable[Key]) -> list[Any]:
        return sorted(key if part is None else key[part] for key in keys)

    return seen(view.explanation) == seen(true_keys(answer))


def shares_of_best(answers: Mapping[str, Answer], views: Mapping[str, View], best: str) -> Array:
    """(n,) shrink of each clear case of one or two effects over the shrink of the best possible.

    ``best`` : the answer's key, ``best_possible_deg`` (effect and leg known to the letter) or ``best_fitted_deg`` (the
    effect known, the leg as the given trials tell it). Both of the same gap and floor, the generator's. Cases whose
    best is no gain are left out.
    """
    found = []
    for name, answer in answers.items():
        if not answer["effects"] or strength(answer) < CLEAR or answer["kind"] not in ("single", "two"):
            continue
        before, floor = answer["before_deg"], answer["noise_floor_deg"]
        possible = shrink_of(answer[best], before, floor)
        if possible > LEAST_TO_GAIN:
            after = views[name].after
            found.append(shrink_of(after if math.isfinite(after) else before, before, floor) / possible)
    return np.array(found)


def shrink_of(after: float, before: float, floor: float) -> float:
    """1 - after / before of RMS errors, the floor taken off in squares."""

    def above(rms: float) -> float:
        return math.sqrt(max(rms**2 - floor**2, 0.0))

    return 1.0 - above(after) / above(before) if before > floor else 0.0


def shrinking(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Reduction of the gap on held-out trials relative to the best possible, for every method that predicts."""
    made = []
    wanted: list[tuple[str, Callable[[Array], float]]] = [
        ("median", lambda x: float(np.median(x))),
        ("p10", lambda x: float(np.percentile(x, 10))),
    ]
    for best, suffix, words in (
        ("best_possible_deg", "", "best possible"),
        ("best_fitted_deg", "_fitted", "best that the given trials allow"),
    ):
        found = shares_of_best(answers, views, best)
        for name, statistic in wanted:
            key, what = f"shrink_{name}{suffix}", f"shrink of the {words}, {_WORDS[name]}"
            if len(found):
                interval = bootstrap(found, statistic)
                made.append(Score(key, what, statistic(found), interval, len(found), "1", LEVELS[f"shrink_{name}"]))
            else:
                made.append(Score(key, what, math.nan, (math.nan, math.nan), 0, "1", LEVELS[f"shrink_{name}"]))
    return made


_WORDS = {"median": "median", "p10": "10th percentile"}


def odds(answers: Mapping[str, Answer], views: Mapping[str, View]) -> Array:
    """(n, 2) of every case: the probability of the first-ranked cause, and whether it is one (effect and joint)."""
    return np.array([[views[n].first[1], float(views[n].first[0] in true_keys(a))] for n, a in answers.items()])


def outcome_odds(answers: Mapping[str, Answer], views: Mapping[str, View]) -> Array:
    """(n, 2) of every case: the probability of the likeliest of all causes, none and unknown, and if it was right."""
    rows = []
    for name, answer in answers.items():
        view = views[name]
        said = [(view.first[1], view.first[0] in true_keys(answer))]
        said += [(view.none, answer["kind"] == "none"), (view.unknown, answer["kind"] == "unknown")]
        probability, right = max((p, r) for p, r in said if math.isfinite(p))
        rows.append([min(probability, 1.0), float(right)])
    return np.array(rows)


def calibration(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Calibration of the probabilities, for every method that gives any."""
    made = []
    for key, what, rows in (
        ("calibration", "calibration error of the first-ranked's probability", odds(answers, views)),
        ("outcome_calibration", "the same, none and unknown counted as outcomes", outcome_odds(answers, views)),
    ):
        if len(rows):
            made.append(Score(key, what, calibration_error(rows), bootstrap(rows, calibration_error), len(rows), "1",
                              LEVELS.get(key)))  # fmt: skip
    if made:
        chance = calibrated_by_chance(odds(answers, views)[:, 0].tolist())
        made.append(Score("calibration_by_chance", "what perfect odds would show on as many cases", chance,
                          (chance, chance), len(answers), "1"))  # fmt: skip
    return made


def alarms(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Diagnoses of cases without a cause."""
    nothing = [name for name, answer in answers.items() if answer["kind"] == "none"]
    return [_share("false_alarm", "false alarm on “none”", (views[n].verdict != "none" for n in nothing))]


def verdicts(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """False alarms, calibration, and diagnoses of effects outside the library."""
    strange = [name for name, answer in answers.items() if answer["kind"] == "unknown"]
    known = [name for name, answer in answers.items() if clear_single(answer)]
    return [
        *alarms(answers, views),
        *calibration(answers, views),
        _share("unknown_flagged", "not in the library: flagged", (views[n].verdict == "unknown" for n in strange)),
        _share(
            "unknown_wrong",
            f"not in the library: wrong name with more than {CONFIDENT:.0%}",
            (views[n].first[1] > CONFIDENT for n in strange),
        ),
        _share("known_unknown", "in the library, yet called unknown", (views[n].verdict == "unknown" for n in known)),
        _share("known_none", "in the library, yet called none", (views[n].verdict == "none" for n in known)),
    ]


def ties(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Whether ties are reported."""
    tied = [name for name, answer in answers.items() if answer["kind"] == "tie"]
    clear = [name for name, answer in answers.items() if clear_single(answer)]
    return [
        _share("tie_reported", "ties reported, the true cause and a true rival named",
               (reported(answers[n], views[n]) for n in tied)),
        _share("tie_in_top", "ties: the true cause and a true rival on top of the list",
               (_on_top(answers[n], views[n]) for n in tied)),
        _share("tie_invented", "one cause only, yet called a tie", (views[n].verdict == "tie" for n in clear)),
    ]  # fmt: skip


def reported(answer: Answer, view: View) -> bool:
    """Verdict tie, with the truth and at least one of its true rivals among the explanations named."""
    named = {view.explanation, *view.tied}
    return view.verdict == "tie" and _pair_in(answer, [keys[0] for keys in named if len(keys) == 1])


def _on_top(answer: Answer, view: View) -> bool:
    """The truth and a true rival are among the first-ranked, of which as many count as there are equal explanations."""
    return _pair_in(answer, view.keys[: len(answer["cannot_be_told_apart"])])


def _pair_in(answer: Answer, keys: Sequence[Key]) -> bool:
    true = true_keys(answer)[0]
    rivals = {(e, j) for e, j in answer["cannot_be_told_apart"]} - {true}
    return true in keys and bool(rivals & set(keys))


def gain(before: Sequence[bool], after: Sequence[bool]) -> list[Score]:
    """Gain of the suggested trial in tied cases: first-ranked right before and with that trial added."""
    what, level = "what the suggested trial gains", LEVELS["tie_gain"]
    if not before:
        return [Score("tie_gain", what, math.nan, (math.nan, math.nan), 0, "points", level)]
    rows = np.stack([np.array(before, dtype=float), np.array(after, dtype=float)], axis=1)

    def points(pairs: Array) -> float:
        return 100.0 * float(pairs[:, 1].mean() - pairs[:, 0].mean())

    return [
        Score("tie_gain", what, points(rows), bootstrap(rows, points), len(rows), "points", level),
        _share("tie_before", "ties: first-ranked right", before),
        _share("tie_after", "ties: first-ranked right with the suggested trial", after),
    ]


def right(answer: Answer, view: View) -> bool:
    """Whether the verdict as a whole is right: for the list of failures."""
    kind, true = answer["kind"], true_keys(answer)
    if kind in ("none", "unknown"):
        return bool(view.verdict == kind)
    if kind == "tie":
        return reported(answer, view) or (view.verdict in ("effect", "tie") and view.first[0] == true[0])
    if kind == "two":
        return _both(answer, view, None)
    return view.verdict in ("effect", "tie") and view.first[0] == true[0]


def confusion(answers: Mapping[str, Answer], views: Mapping[str, View]) -> dict[tuple[str, str], int]:
    """(true, named) -> cases, of clear single effects and of cases with none or an unknown one; by the verdict."""
    found: dict[tuple[str, str], int] = {}
    for name, answer in answers.items():
        if not (clear_single(answer) or answer["kind"] in ("none", "unknown")):
            continue
        true = true_keys(answer)[0][0] if answer["kind"] == "single" else answer["kind"]
        view = views[name]
        said = view.first[0][0] if view.verdict in ("effect", "tie") else view.verdict
        found[true, said] = found.get((true, said), 0) + 1
    return found
