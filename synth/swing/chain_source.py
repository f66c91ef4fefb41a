"""Source text of the compiled chain: straight-line code for a given number of links inside one loop over lanes.

A loop over links inside the lane loop would keep numba from vectorising it. The loops over links are therefore
unrolled when the text is written. ``synth.compiling.code_cache`` makes a module of the text.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from synth.compiling.elimination import factorise, solve, substitute
from synth.swing.lane_layout import (
    CURVE_POINTS,
    DUTY,
    FIRST_LAW,
    INTEGRAL,
    INTEGRAL_LAW,
    LANES,
    MOST_LINKS,
    SOURCE,
    WINDING,
    LaneLaw,
    Layout,
)

HEADER = '''"""Written by synth.swing.chain_source."""
from math import sqrt

from synth.compiling.compiled import compiled
from synth.compiling.trigonometry import sine_cosine
'''
DECORATOR = "@compiled('{signature}', fastmath=True, error_model='numpy', nogil=True)"

# Of Newton's method for the drop of a common source, whose equation has a bend at each limit of a current: with two
# joints two turns leave a part in 1e6 unless a limit is passed (tests/drives/test_shared_source.py).
SOURCE_TURNS = 4
LEAST_VOLTS = 1e-3  # behind a drop: no division by zero at joints without a supply
OF_WORKSPACE = DECORATOR.format(signature="void(float64[::1])")


def right_hand_side(layout: Layout) -> str:
    """Source of ``right_hand_side(workspace)``: joint accelerations of a chain of ``layout.n`` links.

    Absolute rotations give mass matrix and velocity terms in closed form; suffix sums turn them into joint
    coordinates, where a locked joint is a row and column of the identity; ``elimination`` solves. The workspace is
    passed as a flat array (n_row * 16,): all indices are then constants, and no loop needs a check whether its stores
    and loads overlap.
    """
    n, lines = layout.n, equations_of_motion(layout)
    lines += solve(n, ("x", [f"r{i}" for i in range(n)]))
    lines += [f"{at_row(layout.row('acceleration', i))} = x{i}" for i in range(n)]
    return HEADER + lane_loop("right_hand_side", lines, before=link_directions(layout))


def lane_loop(
    name: str, lines: list[str], arguments: str = "Z", decorator: str = OF_WORKSPACE, before: Sequence[str] = ()
) -> str:
    """Source of a function of flat arrays that executes these lines for each lane ``l``, after the lines ``before``."""
    body = "".join(f"    {line}\n" for line in [*before, f"for l in range({LANES}):"])
    body += "".join(f"        {line}\n" for line in lines)
    return f"\n\n{decorator}\ndef {name}({arguments}):\n{body}"


def at_row(row: int) -> str:
    """Source of a row's entry of lane ``l``."""
    return f"Z[{row * LANES} + l]"


def link_directions(layout: Layout) -> list[str]:
    """Lines that write sine and cosine of each link's angle to their rows, in loops of their own.

    A processor starts on the next lanes while it waits for results of these, as far as its window of some hundred
    instructions reaches. Here an iteration is short: three links' right-hand side takes a sixth less time than with
    sine and cosine in the long iteration of the equations.
    """
    sine, cosine = (layout.row(block) * LANES for block in ("sine", "cosine"))
    lines = [f"for l in range({LANES}):"]
    for i in range(layout.n):
        inboard = at_row(layout.row("tilt")) if i == 0 else f"phi{i - 1}"
        lines += [f"    phi{i} = {inboard} + {at_row(layout.row('rotation', i))}"]
        lines += [f"    {at_row(layout.row('cosine', i))} = phi{i}"]
    lines += [f"for e in range({layout.n * LANES}):", f"    s, c = sine_cosine(Z[{cosine} + e])"]
    return [*lines, f"    Z[{sine} + e] = s", f"    Z[{cosine} + e] = c"]


def equations_of_motion(layout: Layout) -> list[str]:
    """Lines that set ``J{i}{j}`` to the mass matrix and ``r{i}`` to the torques in joint coordinates.

    They take the links' directions from their rows, see ``link_directions``.
    """
    n, at = layout.n, at_row
    lines: list[str] = []
    put = lines.append
    for i in range(n):
        put(f"q{i} = {at(layout.row('rotation', i))}")
        put(f"w{i} = {at(layout.row('rate', i))}")
        put("omega0 = w0" if i == 0 else f"omega{i} = omega{i - 1} + w{i}")
        put(f"s{i}, c{i} = {at(layout.row('sine', i))}, {at(layout.row('cosine', i))}")
        put(f"square{i} = omega{i} * omega{i}")
    for i in range(n):
        put(f"m{i}{i} = {at(layout.inertia_row(i, i))}")
        for j in range(i + 1, n):
            put(f"a = {at(layout.inertia_row(i, j))}")
            put(f"b = {at(layout.across_row(i, j))}")
            put(f"cosine = c{i} * c{j} + s{i} * s{j}")
            put(f"sine = s{i} * c{j} - c{i} * s{j}")
            put(f"m{i}{j} = a * cosine + b * sine")
            put(f"h{i}{j} = a * sine - b * cosine")
    for i in range(n):
        terms = [f"{at(layout.row('gravity', i))} * s{i} + {at(layout.row('gravity_across', i))} * c{i}"]
        terms += [f"h{i}{j} * square{j}" for j in range(i + 1, n)]
        put(f"bias{i} = {' + '.join(terms)}" + "".join(f" - h{j}{i} * square{j}" for j in range(i)))
    lines += _joint_coordinates(n)
    for i in range(n):
        spring = f"{at(layout.row('spring_rate', i))} * (q{i} - {at(layout.row('rest', i))})"
        damper = f"{at(layout.row('damper_rate', i))} * w{i}"
        put(f"free{i} = {at(layout.row('free', i))}")
        put(f"known{i} = {spring} + {damper} + bias{i}")
        put(f"r{i} = free{i} * ({at(layout.row('extra_torque', i))} - known{i})")
    for i in range(n):
        for j in range(i, n):
            own = at(layout.row("own_inertia", i))
            masked = f"J{i}{i} * free{i} + {own}" if i == j else f"J{i}{j} * free{i} * free{j}"
            put(f"J{i}{j} = {masked}")
    return lines


def _joint_coordinates(n: int) -> list[str]:
    """Lines of the sums over outboard links: bias_i += bias_{i+1}; J = T' M T with T the lower triangle of ones."""
    lines = [f"bias{i} = bias{i} + bias{i + 1}" for i in range(n - 2, -1, -1)]
    for j in range(n - 1, -1, -1):
        for i in range(n):
            entry = f"m{i}{j}" if i <= j else f"m{j}{i}"
            lines.append(f"B{i}{j} = {entry}" if j == n - 1 else f"B{i}{j} = B{i}{j + 1} + {entry}")
    for j in range(n):
        for i in range(n - 1, -1, -1):
            lines.append(f"J{i}{j} = B{i}{j}" if i == n - 1 else f"J{i}{j} = J{i + 1}{j} + B{i}{j}")
    return lines


def extra_torques(layout: Layout, imports: dict[str, str]) -> str:
    """Source of ``extra_torques(workspace, n, active)``: damper curves, servos and effects, one lane loop each.

    ``active`` : (2 + n_law,) int64, for curves, servos and ``layout.laws`` in this order. Zero skips the loop, so an
    effect that is off costs nothing. A negative first entry means that the dampers' torques are given in their rows.
    ``imports`` : name of a law -> module with its compiled ``torque(rotation, rate, deflection, spring_rate,
    damper_rate, damper_torque, bearing_force, memory, *parameters)``, which returns the torque on q and the rate of
    change of the memory. n is a run-time argument, so one compilation serves every leg.
    """

    def at(block: str, parameter: int = 0) -> str:
        return f"Z[{layout.row(block, parameter * MOST_LINKS) * LANES} + e]"

    header = (
        HEADER
        + "from synth.drives.servo_law import integral_change, limited, servo_duty, unlimited_torque\n"
        + "".join(f"from {module} import torque as {name}\n" for name, module in imports.items())
    )
    each = f"for e in range((n & {MOST_LINKS}) * {LANES}):"  # the mask excludes negative indices
    lines = [each, *(f"    {at(block)} = 0.0" for block in ("extra_torque", "spring_laws", "damper_laws"))]
    lines += [
        "if active[0] >= 0:",
        f"    {each}",
        f"        {at('damper_torque')} = {at('damper_rate')} * {at('rate')}",
        "if active[0] > 0:",
        *_curves(layout, at),
    ]
    lines += ["if active[1] != 0:", *_servos(layout, at, each)]
    # A play last: it passes on what spring and damper give with their own laws.
    for index, law in sorted(enumerate(layout.laws), key=lambda item: item[1].play >= 0):
        lines += [f"if active[{index + FIRST_LAW}] != 0:", f"    {each}", *_law_torque(layout, law, at)]
    decorator = DECORATOR.format(signature="void(float64[::1], int64, int64[::1])")
    body = "\n".join(f"    {line}" for line in lines)
    return f"{header}\n\n{decorator}\ndef extra_torques(Z, n, active):\n{body}\n"


def _law_torque(layout: Layout, law: LaneLaw, at: Callable[..., str]) -> list[str]:
    """Lines of one law's loop; a spring's law takes the deflection behind the joint's play, if it has one."""
    lines = [f"        u = {at('rotation')} - {at('rest')}"]
    if law.part == "spring":
        for play in (each for each in layout.laws if each.play >= 0):
            lines += [f"        u = {at(f'{play.name} memory')} if {at(play.name, play.play)} > 0.0 else u"]
    damper, force = (at(block) for block in forces_of(law))
    if law.play >= 0:
        damper, force = f"{damper} - {at('damper_laws')}", at("spring_laws")
    given = [at("rotation"), at("rate"), "u", at("spring_rate"), at("damper_rate"), damper, force]
    given += [at(f"{law.name} memory") if law.memory else "0.0"]
    given += [at(law.name, p) for p in range(law.n_parameter)]
    lines += [f"        value, change = {law.name}({', '.join(given)})", f"        {at('extra_torque')} += value"]
    lines += [f"        {at(f'{law.part}_laws')} += value"] if law.part else []
    return lines + ([f"        {at(f'{law.name} memory rate')} = change"] if law.memory else [])


def forces_of(law: LaneLaw) -> tuple[str, str]:
    """Blocks of the two forces that a law is given, see ``effects.definition.Effect``."""
    return "damper_torque", "drive_torque" if law.uses_drive else "bearing_force"


def _curves(layout: Layout, at: Callable[[str], str]) -> list[str]:
    """Lines of ``extra_torques`` for torque-speed curves, with the sum over the points written out.

    A loop over points outside that over lanes would load and store both torques at each point.
    """

    def point(block: str, m: int) -> str:
        return f"Z[{(layout.row(block) + m) * LANES} + c]"

    terms = [f"{point('curve_slope', m)} * min({point('curve_speed', m)}, speed)" for m in range(CURVE_POINTS)]
    return [
        f"    for j in range(n & {MOST_LINKS}):",
        f"        for l in range({LANES}):",
        f"            e = j * {LANES} + l",
        f"            c = j * {CURVE_POINTS * LANES} + l",
        f"            speed = abs({at('rate')})",
        f"            size = {' + '.join(terms)}",
        f"            resisting = size if {at('rate')} > 0.0 else -size",
        f"            {at('extra_torque')} -= resisting",
        f"            {at('damper_torque')} += resisting",
    ]


def _servos(layout: Layout, at: Callable[[str], str], each: str) -> list[str]:
    """Lines of ``extra_torques`` for servos, see ``lane_layout.SERVOS``."""

    def beyond(block: str) -> str:
        return f"Z[{(layout.row(block) + 1) * LANES} + e]"

    duty, winding, law = (", ".join(at(name) for name in names) for names in (DUTY, WINDING, INTEGRAL_LAW))
    # Behind a gear's play the controller reads the hinge of the play too, which is the next one; of the last joint the
    # row after its block is read, times zero.
    rotation, rate = (f"{at(name)} + {at('controlled_beyond')} * {beyond(name)}" for name in ("rotation", "rate"))
    seen = [
        f"            scale = 1.0 + {at('controlled_scale')}",
        f"            error = {at('command')} - (scale * ({rotation}) + {at('controlled_offset')})",
        f"            turning = scale * ({rate})",
        f"            integral, most = {at(f'{INTEGRAL} memory')}, {at('servo_integral_limit')}",
        "            integral = max(-most, min(most, integral))",  # a step may end a little beyond it
        f"            duty = servo_duty(error, turning, {duty}, integral) + {at('servo_open_duty')}",
        f"            change = integral_change(error, {at(f'{INTEGRAL} memory')}, {law})",
        f"            {at(f'{INTEGRAL} memory rate')} = {at('enabled')} * change",
    ]
    warm = _warm(layout, at)
    free = f"free = unlimited_torque(duty, {at('rate')}, {{}}, {winding}, {warm})"
    put = [
        f"            {free.format(at('supply'))}",
        f"            value = limited(free, {at('enabled')}, {at('servo_torque_limit')})",
        f"            {at('drive_torque')} = {at('known_torque')} + value",
        f"            {at('extra_torque')} += value",
    ]
    held = f"            duty = {at('held_duty')} if {at('servo_period')} > 0.0 else duty"
    drop = f"Z[{layout.row('source_drop') * LANES} + (e & {LANES - 1})]"
    lowered = at("supply") + " - " + drop
    sagging = [f"            duty = {at('duty')}", f"            {free.format(lowered)}", *put[1:]]
    return [
        "    if active[1] == 1:", f"        {each}", *seen, *put,
        "    elif active[1] == 2:", f"        {each}", *seen, held, *put,
        "    else:", f"        {each}", *seen, held, f"            {at('duty')} = duty",
        *_common_source(layout, at, free, warm), f"        {each}", *sagging,
    ]  # fmt: skip


def _warm(layout: Layout, at: Callable[[str], str]) -> str:
    """Resistance of a joint's winding over the stated one: the memories of the effects that warm it are its growth."""
    growth = [at(f"{law.name} memory") for law in layout.laws if law.uses_drive == "warms its winding"]
    return " + ".join(["1.0", *(f"max({each}, 0.0)" for each in growth)])


def _common_source(layout: Layout, at: Callable[[str], str], free: str, warm: str) -> list[str]:
    """Lines that set the drop (V) of the source that feeds several windings, by Newton's method from no drop.

    The source carries each winding's current times the share of its voltage that the winding sees: the duty, or less
    where a limit of the current lowers it. At a given drop the currents are those of ``unlimited_torque`` and
    ``limited``, of which each is linear in the drop or constant.
    """
    ohms, drop, drawn, slope = (f"Z[{layout.row(name) * LANES} + l]" for name in SOURCE)
    lanes = f"for l in range({LANES}):"
    return [
        f"        {lanes}",
        f"            {drop} = 0.0",
        f"        for turn in range({SOURCE_TURNS}):",
        f"            {lanes}",
        f"                {drawn} = 0.0",
        f"                {slope} = 1.0",
        f"            for j in range(n & {MOST_LINKS}):",
        f"                {lanes}",
        f"                    e = j * {LANES} + l",
        f"                    duty = {at('duty')}",
        f"                    volts = max({at('supply')} - {drop}, {LEAST_VOLTS})",
        f"                    {free.format('volts')}",
        f"                    value = limited(free, {at('enabled')}, {at('servo_torque_limit')})",
        f"                    fed = {ohms} * {at('servo_conductance')}",
        f"                    strength = {at('servo_strength')} if {at('servo_strength')} > 0.0 else 1.0",
        f"                    steady = ({warm}) * value + {at('servo_back_emf')} * {at('rate')}",
        "                    lowered = steady / (strength * volts)",
        f"                    inside = abs(free) <= {at('servo_torque_limit')}",
        "                    seen = duty if inside else lowered",
        f"                    {drawn} += fed * seen * value / strength",
        f"                    own = duty * duty / ({warm} + {at('servo_sag')} * duty * duty)",
        f"                    {slope} += fed * {at('enabled')} * own if inside else 0.0",
        f"            {lanes}",
        f"                {drop} -= ({drop} - {drawn}) / {slope}",
    ]


def bearing_forces(layout: Layout) -> str:
    """Source of ``bearing_forces(workspace)`` and of ``again(workspace)``.

    ``bearing_forces`` evaluates the right-hand side and from its accelerations the force (N) in each hinge. ``again``
    gives the accelerations for other extra torques at the same state, with the factorisation of ``bearing_forces``.

    Newton's second law for all links outboard of a joint: link k contributes to the acceleration, per unit length,
    ``p_k = (cos phi_k ddphi_k - sin phi_k dphi_k^2, sin phi_k ddphi_k + cos phi_k dphi_k^2)`` along it and
    ``n_k = (-p_kz, p_kx)`` across it, so the force on joint j is ``sum_{k<j} length_k carried_j p_k +
    sum_{k>=j} (moment_k p_k + moment_across_k n_k) + carried_j g (0, 1)``.
    """
    n, row = layout.n, layout.row
    first = equations_of_motion(layout)
    first += factorise(n) + substitute(n, "x", [f"r{i}" for i in range(n)])
    first += [f"{at_row(row('acceleration', i))} = x{i}" for i in range(n)]
    kept = [f"known{i}" for i in range(n)] + [f"inverse{i}" for i in range(n)]
    kept += [f"l{j}{i}" for i in range(n) for j in range(i + 1, n)]
    places = {name: at_row(row("factors", k)) for k, name in enumerate(kept)}
    first += [f"{place} = {name}" for name, place in places.items()]
    for i in range(n):
        first += [
            f"alpha{i} = x{i}" + (f" + alpha{i - 1}" if i else ""),
            f"px{i} = c{i} * alpha{i} - s{i} * square{i}",
            f"pz{i} = s{i} * alpha{i} + c{i} * square{i}",
        ]
    for i in range(n - 1, -1, -1):  # the links outboard of the joint, and gravity
        along, across = at_row(row("first_moment", i)), at_row(row("moment_across", i))
        own = {"x": f"{along} * px{i} - {across} * pz{i}", "z": f"{along} * pz{i} + {across} * px{i}"}
        first += [f"out{d}{i} = {own[d]}" + (f" + out{d}{i + 1}" if i < n - 1 else "") for d in "xz"]
    first += ["inx = 0.0", f"inz = {at_row(row('weight'))}"]  # the links inboard of it
    for i in range(n):
        first += [
            f"carried = {at_row(row('carried_mass', i))}",
            f"fx = carried * inx + outx{i}",
            f"fz = carried * inz + outz{i}",
            f"{at_row(row('bearing_force', i))} = sqrt(fx * fx + fz * fz)",
        ]
        first += [f"in{d} = in{d} + {at_row(row('length', i))} * p{d}{i}" for d in "xz"]
    second = [f"{name} = {place}" for name, place in places.items()]
    torque = [f"{at_row(row('free', i))} * ({at_row(row('extra_torque', i))} - known{i})" for i in range(n)]
    second += substitute(n, "x", torque)
    second += [f"{at_row(row('acceleration', i))} = x{i}" for i in range(n)]
    return HEADER + lane_loop("bearing_forces", first, before=link_directions(layout)) + lane_loop("again", second)
