"""The opening of a fit's page: the estimates, and whether the model explains the recordings."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, estimate, joined_names
from synth.reports.quantities import brief, interval_of, interval_text, with_unit
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections import motion

EXPLAINED = 1.5  # times the scatter of the samples: largest residual of a model that explains them
# By the key of their size.
LAWS = {"torque": "Dry friction", "coefficient": "Quadratic damping", "stiffening": "Cubic stiffness"}
OTHER_LEGS = (
    "Fit a recording of the motion, which tells which of these legs it is; or build fitted.leg.yaml, if any leg of "
    "these characteristics will do."
)
CERTAIN_SHARE = 0.25  # half an interval over its value, above which a rate is called uncertain


def fit_opening(result: Result) -> Opening:
    """Verdict, the trial with the worst fit, and a row of estimates per joint."""
    document = result.content
    joints = mapping(document, "joints")
    trials = [trial for trial in sequence(document, "trials") if isinstance(trial, Mapping)]
    # A wanted motion is computed: what a fit to it leaves is rounding, and no effect is missing.
    lacking, unsure = [] if "wanted" in document else _unexplained_joints(document), _unsure(joints)
    figure = motion.worst_figure(result)
    what = f"Springs, dampers and free angles of {joined_names(list(joints))}" if joints else "Nothing"
    held = sum(bool(trial.get("held_out")) for trial in trials)
    used = len(trials) - held
    count = f"{used} trial{'s' if used != 1 else ''}" + (f" ({held} held out)" if held else "")
    if "wanted" in document:
        one = "one of many legs that show" if unsure else "the leg that shows"
        verdict = f"{what} of {one} the wanted characteristics."
    elif lacking:
        verdict = f"{what} from {count}, but the model does not explain the motion of the {joined_names(lacking)}."
    else:
        law = _law(document)
        beside = f"with {law[0].lower()} at the {joined_names(list(law[1]))} " if law else ""
        verdict = f"{what} from {count}; {beside}the model explains the motion."
    return Opening(
        verdict,
        _trust(document, lacking, unsure),
        _steps(document, lacking, unsure),
        figure.drawing if figure else Markup(""),
        figure.caption if figure else "",
        _figures(document),
        False if lacking else True if not unsure and joints else None,
        wide=True,
        beside=figure.pose if figure else Markup(""),
    )


def _law(document: Json) -> tuple[str, Json] | None:
    """What the law beside springs and linear dampers is called, and its size by joint; None without one."""
    found = mapping(document, "law")
    for key, words in LAWS.items():
        if key in found:
            return words, mapping(found, key)
    return None


def _unexplained_joints(document: Json) -> list[str]:
    """Joints whose residual exceeds the samples' scatter."""
    left, noise = mapping(document, "rms"), mapping(document, "noise")
    found = []
    for name in mapping(document, "joints"):
        rms, scatter = value_of(left.get(name)), value_of(noise.get(name))
        if rms is not None and scatter is not None and rms > EXPLAINED * scatter:
            found.append(name)
    return found


def _unsure(joints: Json) -> list[tuple[float, str]]:
    """(half width over value, joint and rate with its interval) of the uncertain rates, the widest first."""
    found = []
    for name, joint in joints.items():
        for key, words in (("spring_rate", "spring rate"), ("damper_rate", "damper rate")):
            quantity = mapping(joint).get(key)
            value, ends = value_of(quantity), interval_of(quantity)
            if not value or ends is None or None in ends:
                continue
            low, high = ends
            assert low is not None
            assert high is not None
            if (share := (high - low) / 2 / abs(value)) > CERTAIN_SHARE:
                shown = with_unit(interval_text(quantity), quantity)
                found.append((share, f"{name}'s {words}, {shown} (90\u00a0%)"))
    return sorted(found, reverse=True)


def _trust(document: Json, lacking: list[str], unsure: list[tuple[float, str]]) -> str:
    left, noise = mapping(document, "rms"), mapping(document, "noise")
    names = lacking or list(mapping(document, "joints"))
    residuals = [f"{name} {brief(left.get(name))} (samples' scatter {brief(noise.get(name))})"
            for name in names if left.get(name) and noise.get(name)]  # fmt: skip
    words = f"Residual (RMS): {'; '.join(residuals)}." if residuals and "wanted" not in document else ""
    if unsure:
        words += f" Least certain: the {unsure[0][1]}."
    return words.strip()


def _steps(document: Json, lacking: list[str], unsure: list[tuple[float, str]]) -> list[str]:
    if lacking:
        return [
            "Find the missing effect with `synth gap`, fitted.leg.yaml and these trials; until then rates are biased."
        ]
    if unsure and "wanted" in document:
        return [OTHER_LEGS]
    proposals = [str(mapping(item).get("text")) for item in sequence(document, "proposals")]
    if unsure and proposals:
        return [f"To measure next: {proposals[0]}"]
    return ["Use fitted.leg.yaml, for example as the source of `synth leg`."] if mapping(document, "joints") else []


def _damper(joint: Json) -> Cell:
    if joint.get("damper_rate"):
        return estimate(joint["damper_rate"])
    return Cell("none" if mapping(joint, "damper").get("law") == "none" else "curve given")


def _figures(document: Json) -> Figures | None:
    joints = mapping(document, "joints")
    if not joints:
        return None
    rms = mapping(document, "rms")
    law = _law(document)
    rows = [
        [
            Cell(name),
            estimate(joint.get("spring_rate")),
            _damper(joint),
            estimate(joint.get("free_angle")),
            *([estimate(law[1].get(name)) if law[1].get(name) else Cell("none")] if law else []),
            Cell(brief(rms.get(name))),
        ]
        for name, joint in ((name, mapping(found)) for name, found in joints.items())
    ]
    heads = ("Joint", "Spring rate", "Damper rate", "Free angle", *([law[0]] if law else []), "Residual, RMS")
    return Figures(heads, rows, "Small print: 90 % intervals.")
