"""Choice of dampers: each with the spring rate and free angle tuned to it, by the response of the whole leg."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf

import numpy as np

from synth.design.drawable_dampers import Against
from synth.design.response import WantedResponse
from synth.design.spring_tuning import tuned_legs
from synth.files.project_options import DamperChoice, JointChoice, PartsOptions
from synth.fit.damper_laws import DamperLaw
from synth.parts.arrangement import Arrangement, arrangements
from synth.parts.catalogs import Catalogue
from synth.parts.damper_law import TABLE, LowSpeedLaw, low_speed_law
from synth.parts.part_candidates import ANY, damper_candidates, damper_reason, of_family
from synth.parts.rows import DamperRow
from synth.parts.usable import offers
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Damper, DamperCurve, Leg, Spring

DAMPERS_KEPT = 2  # dampers per joint in the combined choice for all joints
ALONE = 16  # dampers per joint that are simulated, nearest torque first
ALONE_ON_THE_JOINT = Arrangement()


@dataclass(frozen=True)
class DamperLimits:
    """What holds for the dampers of all joints: ``parts``, and why one cannot be drawn (None: none is drawn)."""

    parts: PartsOptions = ANY
    against: Against | None = None

    def at(self, joint: int) -> Callable[[DamperRow], str | None] | None:
        """Why a damper cannot be drawn at one joint."""
        against = self.against
        return None if against is None else lambda row: against(joint, row)


ANY_DAMPER = DamperLimits()
FAR = 8.0  # ratio to the wanted damper's torque, above or below, beyond which a damper is left out


@dataclass(frozen=True)
class MeasuredCurve:
    """A measured damper curve of a joint: its part number (None: not stated) and its source.

    ``upto``: the highest measured speed of the damper, rad/s. ``table``: whether it is the user's own table, which
    ``below`` continues under its lowest point (None: it need not). ``at``:
    the joint whose damper was measured, where it is used at another one for a damper of the same part; else empty.
    """

    part: str | None
    curve: DamperCurve
    source: str
    upto: float = inf
    table: bool = False
    at: str = ""
    below: LowSpeedLaw | None = None

    @property
    def words(self) -> str:
        """Where and how it was measured."""
        return f"measured{f' at the {self.at}' if self.at else ''}: {self.source}"


@dataclass(frozen=True)
class DamperOption:
    """The dampers of a joint, as they act together.

    ``error``, ``expected`` (rad): response error of the whole leg with them, nominal and with tolerances. ``partner``
    is the spring of that leg if it is not the chosen one, ``partner_rate`` (N m/rad) its rate. ``single`` is one of
    them on its own shaft. The default arrangement is one damper on the joint's axis. ``measured``: the curve of
    a measured one.
    """

    row: DamperRow | None
    damper: Damper
    law: str
    why: str
    error: float = float("nan")
    expected: float = float("nan")
    spring: Spring | None = None  # tuned to this damper, with the other joints as wanted
    arrangement: Arrangement = ALONE_ON_THE_JOINT
    single: Damper | None = None
    partner: str = ""
    partner_rate: float | None = None
    measured: MeasuredCurve | None = None

    @property
    def turns(self) -> float | None:
        """How far it lets the joint turn, rad; None: without end, or unknown."""
        if self.row is None or self.row.continuous == "yes" or self.row.travel is None:
            return None
        return self.row.travel / self.arrangement.ratio

    def with_exponent(self, exponent: float) -> Damper:
        """The damper at the joint with another exponent of the assumed law, or of that below its measured table."""
        if self.measured is not None and self.measured.below is not None:
            return self.arrangement.at_joint(Damper(curve=self.measured.below.curve(exponent), part=self.damper.part))
        assert self.row is not None
        return self.arrangement.at_joint(self.row.damper(self.law, exponent))

    @property
    def below(self) -> LowSpeedLaw | None:
        """The law below its measured table, at the damper's own speed; None: it has none."""
        if self.measured is not None:
            return self.measured.below
        tabled = self.row is not None and self.law == TABLE == self.row.default_law
        return self.row.below_table if self.row is not None and tabled else None

    @property
    def known_from(self) -> float | None:
        """Speed of the joint (rad/s) from which upwards its table is measured; None: it has none, or down to rest."""
        return None if self.below is None else self.below.speed / self.arrangement.ratio

    @property
    def label(self) -> str:
        """Part as ordered, and arrangement."""
        return self.arrangement.words(self.row.order if self.row is not None else self.part)

    @property
    def part(self) -> str:
        """Part number, or ``measured damper`` without one."""
        return self.row.part if self.row is not None else "measured damper"


@dataclass(frozen=True)
class DamperSet:
    """A damper for each joint, the leg with them and the springs tuned to them, and its response error (rad)."""

    options: tuple[DamperOption, ...]
    leg: Leg
    error: float


@dataclass(frozen=True)
class DamperChoiceMade:
    """The chosen damper of each joint, the ranking at each joint, the excluded rows by reason, the next best sets."""

    chosen: tuple[DamperOption, ...]
    ranked: tuple[tuple[DamperOption, ...], ...]
    left_out: tuple[Mapping[str, int], ...]
    leg: Leg  # the wanted leg with these dampers and the springs tuned to them
    sets: tuple[DamperSet, ...]  # all simulated sets, best first

    @property
    def labels(self) -> tuple[str, ...]:
        """The chosen dampers as text."""
        return tuple(option.label for option in self.chosen)


def measured_curves(
    laws: Mapping[str, DamperLaw], tables: Mapping[str, tuple[str | None, DamperCurve]], parts: Mapping[str, str | None]
) -> dict[str, MeasuredCurve]:
    """Measured curves by joint: from drop tests (``laws``) or from the user's torque-speed tables."""
    found = {joint: _measured_table(part, curve) for joint, (part, curve) in tables.items()}
    for joint, law in laws.items():
        low, high = law.speeds.low, law.speeds.high
        source = f"drops, {law.used.law.name} law, {low:.3g} to {high:.3g} rad/s"
        found[joint] = MeasuredCurve(parts.get(joint), law.used.curve, source, high)
    return found


def _measured_table(part: str | None, table: DamperCurve) -> MeasuredCurve:
    below = low_speed_law(table)
    if below is None:
        return MeasuredCurve(part, table, "torque-speed table", table.speed[-1], table=True)
    source = f"torque-speed table, {below.words}"
    return MeasuredCurve(part, below.curve(), source, table.speed[-1], table=True, below=below)


def choose_dampers(
    wanted: WantedResponse,
    choices: Mapping[str, JointChoice],
    catalogue: Catalogue,
    measured: Mapping[str, MeasuredCurve],
    travel: Sequence[float],
    law: str | None = None,
    leg: Leg | None = None,
    limits: DamperLimits = ANY_DAMPER,
) -> DamperChoiceMade:
    """Rank every damper that meets the constraints and choose the set with the lowest response error.

    Each candidate is evaluated with the spring rate and free angle tuned to it, because these are fitted again after
    the choice. ``law`` forces a torque-speed law on the catalogue's dampers (``linear``: the vendor's secant). ``leg``:
    the leg in which they are simulated; default the wanted leg, else one with the same springs and effects of its own.
    ``travel``: (n,) rad, each joint's from stop to stop. ``limits``: dampers that cannot be drawn are left out, except
    one that is named by its part.

    Raises
    ------
    UserError : a joint has no damper that meets its constraints.
    """
    leg = wanted.leg if leg is None else leg
    candidates, left_out = [], []
    for j, joint in enumerate(leg.joints):
        choice, parts, own = choices[joint.name].damper, limits.parts, measured.get(joint.name)
        is_own = law is None and own is not None and own.part is None and choice.part is None
        against = None if is_own else limits.at(j)  # the measured one is drawn in any case
        found = damper_candidates(catalogue, choice, travel[j], joint.name, parts, against)
        options = _options(list(found.rows), curves_at(joint.name, choices, measured) if law is None else {}, law)
        if own is not None and is_own:
            options = [DamperOption(None, Damper(curve=own.curve), "curve", own.words, measured=own)]
        options = _arrangements(options, choice, travel[j], of_family(parts, catalogue.dampers))
        options, far = _nearest_options(options, joint.damper.rate if joint.damper and joint.damper.rate else 0.0)
        left_out.append({**found.left_out, **far})
        candidates.append(options)
    ranked = _ranked(wanted, leg, candidates)
    joints = tuple(range(len(leg.joints)))
    sets = list(product(*(options[:DAMPERS_KEPT] for options in ranked)))
    legs = tuned_legs(wanted, [_with(leg, dict(enumerate(each))) for each in sets], [joints] * len(sets))
    errors = wanted.overall(legs)
    order = np.argsort(errors, kind="stable")
    tried = tuple(DamperSet(sets[k], legs[k], float(errors[k])) for k in order)
    return DamperChoiceMade(tried[0].options, tuple(ranked), tuple(left_out), tried[0].leg, tried)


def _ranked(
    wanted: WantedResponse, leg: Leg, candidates: Sequence[Sequence[DamperOption]]
) -> list[tuple[DamperOption, ...]]:
    """Each joint's candidates, best first, with their errors and the springs tuned to them."""
    places = [(j, k) for j, options in enumerate(candidates) for k in range(len(options))]
    legs = tuned_legs(wanted, [_with(leg, {j: candidates[j][k]}) for j, k in places], [(j,) for j, _ in places])
    of_place = dict(zip(places, legs, strict=True))
    ranked = []
    for j, options in enumerate(candidates):
        tuned = [of_place[j, k] for k in range(len(options))]
        errors = wanted.overall(tuned)
        order = np.argsort(errors, kind="stable")
        ranked.append(
            tuple(replace(options[k], error=float(errors[k]), spring=tuned[k].joints[j].spring) for k in order)
        )
    return ranked


def curves_at(
    joint: str, choices: Mapping[str, JointChoice], measured: Mapping[str, MeasuredCurve]
) -> dict[str, MeasuredCurve]:
    """Measured curves by part number (in lower case) that hold at a joint: its own, else those of other joints.

    A curve belongs to its part, which may be a candidate anywhere. Of several joints' curves of one part the first
    counts. One without a part number is of the part that its joint's choice names. Part numbers that several vendors
    sell are refused before.
    """
    found: dict[str, MeasuredCurve] = {}
    for name in (joint, *(name for name in measured if name != joint)):
        each = measured.get(name)
        part = None if each is None else each.part or choices[name].damper.part
        if each is not None and part is not None:
            found.setdefault(part.casefold(), each if name == joint else replace(each, at=name))
    return found


def _options(rows: list[DamperRow], curves: Mapping[str, MeasuredCurve], law: str | None) -> list[DamperOption]:
    options = []
    for row in rows:
        known, offered = curves.get(row.part.casefold()), offers(row)
        # Of a part that is ordered by its torque the number alone does not tell which of them was measured elsewhere.
        if known is not None and not (known.at and len(offered) > 1):
            damper = Damper(curve=known.curve, part=row.part)
            options.append(DamperOption(row, damper, "curve", known.words, measured=known))
            continue
        chosen = law or row.default_law
        reasons = {
            "table": "the catalogue's torque-speed points" + (f", {row.below_table.words}" if row.below_table else ""),
            "concave": "assumed: T = T_max (w/w_max)^0.47 through the vendor's one point, see catalogs/README.md",
            "linear": "the secant through the vendor's one point",
        }
        why = "; ".join([reasons[chosen], *row.derived])
        options += [DamperOption(offer, offer.damper(chosen), chosen, why) for offer in offered]
    return options


def _arrangements(
    options: list[DamperOption], choice: DamperChoice, travel: float, parts: PartsOptions
) -> list[DamperOption]:
    """Each damper in every arrangement that the choice allows and in which it turns far enough (``travel`` rad).

    Of a damper named by part there are as many as ``parallel`` says. One that turns too little in all arrangements is
    kept, for ``travel_warnings`` to tell.
    """
    made = []
    wanted = choice.travel if choice.travel is not None else travel
    for option in options:
        allowed = arrangements(option.row, choice.parallel, choice.ratios, choice.direction)
        if choice.part is not None and option.row is not None:
            row, allowed = option.row, [each for each in allowed if each.pieces == choice.parallel]
            allowed = [each for each in allowed if row.allows_travel(wanted * each.ratio) is not False] or allowed
        for arrangement in allowed:
            turned = replace(choice, travel=wanted * arrangement.ratio, ratios=(1.0,))
            if choice.part is None and option.row is not None and damper_reason(option.row, turned, 0.0, parts):
                continue
            damper = arrangement.at_joint(option.damper)
            made.append(replace(option, damper=damper, arrangement=arrangement, single=option.damper))
    return made


def _nearest_options(options: list[DamperOption], rate: float) -> tuple[list[DamperOption], dict[str, int]]:
    """Options whose torque at 1 rad/s is near that of the wanted rate, nearest first, and the number of others.

    No spring can compensate for a damper that is off by a factor of ten, and a damper far too strong for its link is
    the slowest to simulate. Two are kept in any case.
    """

    def distance(option: DamperOption) -> float:
        curve, damper = option.damper.curve, option.damper
        torque = float(torque_at(curve, np.array([1.0]))[0]) if curve is not None else (damper.rate or 0.0)
        return abs(float(np.log(max(torque, 1e-12) / max(rate, 1e-12))))

    ordered = sorted(options, key=distance)
    kept = [o for k, o in enumerate(ordered) if k < 2 or (k < ALONE and distance(o) <= np.log(FAR))]
    far = len(ordered) - len(kept)
    return kept, {f"torque at 1 rad/s more than {FAR:g} times off the wanted damper's": far} if far else {}


def _with(leg: Leg, options: Mapping[int, DamperOption]) -> Leg:
    """The leg with these dampers and the springs tuned to them."""
    joints = tuple(
        replace(joint, damper=options[j].damper, spring=options[j].spring or joint.spring) if j in options else joint
        for j, joint in enumerate(leg.joints)
    )
    return replace(leg, joints=joints)
