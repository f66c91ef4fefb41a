"""The opening of a jumping leg's page: motor, ratio and length, jump height, and its limits."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.quantities import brief, in_length_unit, interval_text, text
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, mapping, sequence
from synth.reports.sections import hopper_choice, hopper_jump

_RISES = {
    "clearance": "the foot clears the ground by",
    "total_height": "the centre of mass rises over the crouch by",
}


def study_opening(result: Result) -> Opening:
    """The chosen design, its jump as poses, and its figures beside its neighbours."""
    document = result.content
    best, counts = mapping(document, "best"), mapping(document, "counts")
    if not best:
        why, jump = str(document.get("none_because") or "no design was chosen"), counts.get("jump")
        way_out = "Use stronger `motors:` or shorter links" if not jump else (
            "Use motors with a stronger gearbox or a lower `supply:`, or write `motors: {gearbox: warn}` to have such "
            "designs chosen with a warning"
        )  # fmt: skip
        steps = [f"{way_out}; designs.csv gives the limit of each design."]
        return Opening(f"{why[0].upper()}{why[1:]}.", steps=steps, good=False)
    key, limit = hopper_choice.shown_height(document), str(best.get("limit") or "")
    how = str(mapping(document, "settings").get("choose") or "").replace("_", " ")
    verdict = (
        f"{best.get('motor')} with upper links of {_millimetres(best.get('leg_length'))}: as simulated {_RISES[key]} "
        f"{_centimetres(best.get(key))}{_interval_text(best.get(key))}, the best {how} of {_number(counts)}."
        f"{_as_drawn(document)}"
    )
    figure, caption = _picture(result)
    good = not (limit or _after_takeoff(best) or _missing(document))
    steps = _steps(document, limit)
    return Opening(verdict, _trust(document, limit), steps, figure, caption, _figures(document), good)


def truth_opening(result: Result) -> Opening:
    """The number of reproduced findings."""
    claims = [item for item in sequence(result.content, "claims") if isinstance(item, Mapping)]
    out = sum(bool(item.get("comes_out")) for item in claims)
    every = {str(item.get("claim")) for item in claims}
    always = {name for name in every if all(i.get("comes_out") for i in claims if str(i.get("claim")) == name)}
    rows = []
    for key in dict.fromkeys(f"{item.get('pose')}, {item.get('measure')}".replace("_", " ") for item in claims):
        found = [i for i in claims if f"{i.get('pose')}, {i.get('measure')}".replace("_", " ") == key]
        rows.append([Cell(key), Cell(f"{sum(bool(i.get('comes_out')) for i in found)} of {len(found)}")])
    return Opening(
        f"{len(always)} of {len(every)} published findings are reproduced in every pose and measure.",
        f"Over all poses and measures {out} of {len(claims)}; the others depend on a pose and a height that "
        "were not published." if claims else "",
        ["See below for unpublished numbers and their influence."],
        figures=Figures(("Pose and measure", "Reproduced"), rows) if rows else None,
    )  # fmt: skip


def _number(counts: Json) -> str:
    """How many designs the chosen one was compared with."""
    feasible, tried = counts.get("feasible"), counts.get("designs")
    if feasible is None or feasible == tried:  # an older result does not say how many are feasible
        return f"{tried} designs"
    return f"{feasible} feasible designs, of {tried} that were simulated"


def _millimetres(quantity: object) -> str:
    value = value_of(quantity)
    return "–" if value is None else f"{1e3 * value:.4g}\u00a0mm"


def _centimetres(quantity: object) -> str:
    value = value_of(in_length_unit(quantity, "cm"))
    return "–" if value is None else f"{value:.3g}\u00a0cm"


def _interval_text(quantity: object) -> str:
    ends = mapping(quantity).get("interval90")
    if not isinstance(ends, list) or None in ends:
        return ""
    return f" (90 %: {100 * ends[0]:.1f} to {100 * ends[1]:.1f}\u00a0cm)"


def _trust(document: Json, limit: str) -> str:
    key = hopper_choice.shown_height(document)
    models = {name: value_of(mapping(item).get(key)) for name, item in mapping(document, "models").items()}
    heights = [value for value in models.values() if value is not None]
    words = f"But: {limit}. " if limit else ""
    words += _after_takeoff(mapping(document, "best"))
    if len(heights) > 1:
        used = mapping(document, "settings").get("model")
        words += (
            f"The interval reflects the tolerances of motor and materials in model {used}; the models range "
            f"from {100 * min(heights):.1f} to {100 * max(heights):.1f}\u00a0cm."
        )
    return words


def _after_takeoff(best: Json) -> str:
    """That the gear carries more than its maker allows at the leg's stop; empty if it does not."""
    torque, limit = best.get("gear_torque_after_takeoff"), mapping(best, "motor_constants").get("torque_limit")
    carried, allowed = value_of(torque), value_of(limit)
    if carried is None or allowed is None or carried <= allowed:
        return ""
    return (
        f"At the leg's stop, after takeoff, the gear carries {text(torque)}; its maker allows {text(limit)}. "
        "Designs are judged by the push alone. "
    )


def _missing(document: Json) -> list[str]:
    """What keeps the drawn parts from being the simulated leg."""
    return [str(what) for what in sequence(document, "parts", "missing")]


def _as_drawn(document: Json) -> str:
    """How high the leg jumps with flexures and links as drawn, and that its parts are not the simulated leg."""
    drawn, missing = mapping(document, "parts", "as_drawn"), _missing(document)
    words = ""
    if drawn:
        height, simulated = (_centimetres(drawn.get(key)) for key in ("clearance", "clearance_simulated"))
        words = f" With flexures and links as drawn the foot clears {height} instead of {simulated}."
    return words + (f" Not ready to build: {joined_names(missing)}." if missing else "")


def _steps(document: Json, limit: str) -> list[str]:
    if limit:
        return ["To leave such designs out, write `motors: {gearbox: stop}`; otherwise expect wear of the gear."]
    record = "record jumps on a force plate; `synth gap` then shows what the model lacks."
    if not mapping(document, "parts"):
        return [f"Run without `--no-cad` for the parts, cut them and {record}"]
    if not sequence(document, "parts", "layers"):
        return [f"Mend what keeps the parts from being drawn (see the notes on the parts) and run again. Then {record}"]
    if not _missing(document):
        return [f"Cut the parts of `parts/` and {record}"]
    drawn = mapping(document, "parts", "as_drawn")
    again = ""
    if rate := mapping(drawn, "rate_for_all_joints").get("value"):
        again = (
            f"enter the drawn flexures' rate under `flexures:` ({rate:.3g} N*m/rad fits every joint) and run again, "
        )
    return [f"Decide on the warnings of the parts: {again}complete the rest by hand. Then cut `parts/` and {record}"]


def _picture(result: Result) -> tuple[Markup, str]:
    jump = hopper_jump.content(result)
    if not isinstance(jump, AbsentResult):
        strip = Markup('<div id="jump-player"><div class="poster">{}</div></div>').format(jump["strip"])
        return strip, "The jump of the chosen leg, from the crouch to the top."
    found = hopper_choice.map_content(result)
    return (
        (Markup(""), "")
        if isinstance(found, AbsentResult)
        else (found["svg"], f"{found['height']} over ratio and length.")
    )


def _figures(document: Json) -> Figures:
    best = mapping(document, "best")
    limit, after = mapping(best, "motor_constants").get("torque_limit"), best.get("gear_torque_after_takeoff")
    rows = [
        [Cell("Motor"), Cell(str(best.get("motor")))],
        [Cell("Gear ratio"), Cell(f"{best.get('gear_ratio')}:1")],
        [Cell("Upper link"), Cell(_millimetres(best.get("leg_length")))],
        *(
            [Cell(name), Cell(_centimetres(best.get(key)), _interval_text(best.get(key)).strip(" ()"))]
            for name, key in (("Clearance", "clearance"), ("Total height", "total_height"))
        ),
        [Cell("Relative height"), Cell(brief(best.get("relative_height")), interval_text(best.get("relative_height")))],
        [Cell("Peak gear torque, push"), Cell(brief(best.get("peak_gear_torque")), _torque_ends(best, limit))],
        *([[Cell("Peak gear torque, at the stop"), Cell(brief(after), _bears(limit))]] if after else []),
        [Cell("Peak current, both motors"), Cell(brief(best.get("peak_current")))],
        [Cell("Energy of a jump"), Cell(brief(best.get("energy")))],
    ]
    return Figures(("Chosen leg", ""), rows)


def _torque_ends(best: Json, limit: object) -> str:
    ends = interval_text(best.get("peak_gear_torque"))
    return "; ".join(part for part in (f"90 %: {ends}" if ends else "", _bears(limit)) if part)


def _bears(limit: object) -> str:
    return f"the gearbox bears {text(limit)}" if value_of(limit) is not None else ""
