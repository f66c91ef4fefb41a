"""The score of dirty rigs: the main cause must be named; present small causes may be, absent ones must not.

Right of a rig with a main cause: that cause first (or one that explains it as well), whatever small ones stand beside
it. Wrong: a small one in its place, or anything that is not there. Right where nothing dominates: none, unknown, or
small causes that are there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from blind.chance import bootstrap, calibrated_by_chance, calibration_error, wilson
from blind.score import CONFIDENT, LEAST_TO_GAIN, Answer, Level, Score, shrink_of
from blind.views import Key, View

LEVELS = {  # required for real rigs: one level each
    "top1": Level(math.nan, math.nan, 0.85),
    "joint": Level(math.nan, math.nan, 0.95),
    "false_alarm": Level(math.nan, math.nan, 0.05, most=True),
    "unknown_flagged": Level(math.nan, math.nan, 0.80),
    "unknown_wrong": Level(math.nan, math.nan, 0.03, most=True),
    "two_named": Level(math.nan, math.nan, 0.65),
    "calibration": Level(math.nan, math.nan, 0.06, most=True),
    "shrink_median": Level(math.nan, math.nan, 0.9),
}


def main_keys(answer: Answer) -> list[Key]:
    """Effects and joints of the main causes."""
    return [(effect["effect"], effect["joint"]) for effect in answer["effects"]]


def as_right(answer: Answer) -> set[Key]:
    """Causes that may be named first if one dominates: it, or one that explains it as well."""
    return {*main_keys(answer), *((effect, joint) for effect, joint in answer["alike"])}


def there(answer: Answer) -> set[Key]:
    """All causes in the rig: main and small ones, wrong parameters by the name of their effect."""
    small = {(effect["effect"], effect["joint"]) for effect in answer["small"]}
    return as_right(answer) | small | {(effect, joint) for effect, joint in answer["numbers_called"]}


def named_causes(view: View) -> set[Key]:
    """Causes that the verdict names."""
    if view.verdict not in ("effect", "tie"):
        return set()
    return {key for keys in (view.explanation, *view.tied) for key in keys}


def best_named(answer: Answer, view: View) -> set[Key]:
    """Of an effect its causes; of a tie, which says "this or that", the alternative with the fewest that are absent."""
    alternatives = [set(view.explanation), *map(set, view.tied)]
    return min(alternatives, key=lambda keys: len(keys - there(answer))) if named_causes(view) else set()


def right_first(answer: Answer, view: View) -> bool:
    """Whether the first-ranked cause is right for the main one: for calibration."""
    return view.first[0] in (there(answer) if answer["kind"] == "none" else as_right(answer))


def right(answer: Answer, view: View) -> bool:
    """Whether the verdict as a whole is right: for the list of failures."""
    if answer["kind"] == "none":
        return named_causes(view) <= there(answer) and view.verdict != "failed"
    if answer["kind"] == "unknown":
        return view.verdict == "unknown"
    if answer["kind"] == "two":
        return set(main_keys(answer)) <= named_causes(view) <= there(answer)
    named = named_causes(view)
    return view.verdict in ("effect", "tie") and view.first[0] in as_right(answer) and named <= there(answer)


def _share(key: str, what: str, hits: Iterable[bool]) -> Score:
    found = list(hits)
    count, good = len(found), sum(found)
    return Score(key, what, good / count if count else math.nan, wilson(good, count), count, "%", LEVELS.get(key))


def scores(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Every line of the table."""
    of = {kind: [n for n, a in answers.items() if a["kind"] == kind] for kind in ("single", "none", "two", "unknown")}
    joints = {n: {joint for _, joint in as_right(a)} for n, a in answers.items()}
    return [
        _share("top1", "main cause named first", (views[n].first[0] in as_right(answers[n]) for n in of["single"])),
        _share("joint", "its joint named first", (views[n].first[0][1] in joints[n] for n in of["single"])),
        _share("top3", "main cause among the first three",
               (bool(as_right(answers[n]) & set(views[n].keys[:3])) for n in of["single"])),
        _share("said", "main cause named first, and the verdict says so",
               (views[n].verdict in ("effect", "tie") and views[n].first[0] in as_right(answers[n])
                for n in of["single"])),
        _share("false_alarm", "no main cause: one named that is not there",
               (not named_causes(views[n]) <= there(answers[n]) for n in of["none"])),
        _share("false_alarm_of_all", "the same, where of a tie no alternative is all there",
               (not best_named(answers[n], views[n]) <= there(answers[n]) for n in of["none"])),
        _share("invented", "any rig: a cause named that is not there",
               (not named_causes(views[n]) <= there(answers[n]) for n in answers if answers[n]["kind"] != "unknown")),
        _share("invented_in_all", "the same, where of a tie no alternative is all there",
               (not best_named(answers[n], views[n]) <= there(answers[n])
                for n in answers if answers[n]["kind"] != "unknown")),
        _share("unknown_flagged", "main cause outside the list: flagged",
               (views[n].verdict == "unknown" for n in of["unknown"])),
        _share("unknown_wrong", f"main cause outside the list: another name with more than {CONFIDENT:.0%}",
               (views[n].first[1] > CONFIDENT and views[n].first[0] not in there(answers[n]) for n in of["unknown"])),
        _share("two_named", "two main causes, both named",
               ({e for e, _ in main_keys(answers[n])} <= {e for e, _ in named_causes(views[n])} for n in of["two"])),
        *_calibration(answers, views),
        *_shrink(answers, views),
    ]  # fmt: skip


def _calibration(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """How far the first-ranked's probability is off, and of the rigs with a main cause by themselves.

    Where nothing dominates a small cause may be first, is there, and rightly has a low probability of dominating.
    """
    what, level = "calibration error of the first-ranked's probability", LEVELS["calibration"]
    with_main = {n: a for n, a in answers.items() if a["kind"] != "none"}
    found = []
    for key, text, of, limit in (
        ("calibration", what, answers, level),
        ("calibration_main", "the same, of rigs with a main cause", with_main, None),
    ):
        rows = np.array([[views[n].first[1], float(right_first(a, views[n]))] for n, a in of.items()])
        if not len(rows):
            continue
        chance = calibrated_by_chance(rows[:, 0].tolist())
        found += [
            Score(key, text, calibration_error(rows), bootstrap(rows, calibration_error), len(rows), "1", limit),
            Score(f"{key}_by_chance", "what perfect odds would show on as many cases", chance, (chance, chance),
                  len(rows), "1"),
        ]  # fmt: skip
    return found


def _shrink(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[Score]:
    """Of the shrink that the main causes' removal would be: ``best_possible_deg`` holds what the small ones leave."""
    found = []
    for name, answer in answers.items():
        before, floor, after = answer["before_deg"], answer["noise_floor_deg"], views[name].after
        possible = shrink_of(answer["best_possible_deg"], before, floor)
        if answer["kind"] in ("single", "two") and possible > LEAST_TO_GAIN:
            found.append(shrink_of(after if math.isfinite(after) else before, before, floor) / possible)
    made, values = [], np.array(found)
    for key, what, share in (("shrink_median", "median", 50.0), ("shrink_p10", "10th percentile", 10.0)):
        text, level = f"shrink over that of the best possible, {what}", LEVELS.get(key)

        def statistic(x: np.ndarray, share: float = share) -> float:
            return float(np.percentile(x, share))

        if len(values):
            made.append(Score(key, text, statistic(values), bootstrap(values, statistic), len(values), "1", level))
        else:
            made.append(Score(key, text, math.nan, (math.nan, math.nan), 0, "1", level))
    return made
