"""Draw the packages and their imports: ``docs/architecture.svg``.

``python tools/architecture.py`` writes it, and a test compares the file with the imports. A package stands above all
packages that it imports. Transitive arrows are not drawn. Imports in functions and for type checking count too.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "architecture.svg"
TREES = ("synth", "cad", "reports")
INSIDE = ("cad", "reports")  # imported as synth.cad and synth.reports, by links in `synth`
SKIPPED = ("examples",)  # data that `synth init` copies
# Group in the picture of each module directly in `synth`.
GATHERED = {
    "synth": "synth",
    "synth.__main__": "command line",
    "synth.cli": "command line",
    "synth.commands": "command line",
    "synth.arrays": "basics",
    "synth.noise": "basics",
    "synth.pace": "basics",
    "synth.sampling": "basics",
    "synth.cache": "basics",
    "synth.errors": "basics",
    "synth.threads": "basics",
    "synth.remarks": "basics",
    "synth.units": "basics",
    "synth.units_often": "basics",
    "synth.units_spelling": "basics",
}
WIDTH, BOX, HEIGHT, FLOOR, MARGIN = 1180, 118, 34, 84, 24  # px
Graph = dict[str, set[str]]


def modules(root: Path = ROOT) -> dict[str, Path]:
    """Dotted name -> file, for every module."""
    found = {}
    for tree in TREES:
        for path in sorted((root / tree).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            if not {*parts} & {*SKIPPED}:
                inside = ("synth",) if tree in INSIDE else ()
                found[".".join((*inside, *(parts[:-1] if parts[-1] == "__init__" else parts)))] = path
    return found


def imports(found: Mapping[str, Path]) -> Graph:
    """Module -> the modules that it imports, at any place in its text."""
    graph: Graph = {name: set() for name in found}
    for name, path in found.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            wanted: list[str] = []
            if isinstance(node, ast.Import):
                wanted = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                below = [f"{node.module}.{alias.name}" for alias in node.names]
                inner = [item for item in below if item in found]
                wanted = inner if len(inner) == len(below) else [node.module, *inner]
            # Every module may import the root for its version; the root's own imports are lazy.
            graph[name] |= {item for item in wanted if item in found and item not in (name, "synth")}
    return graph


def package(module: str) -> str:
    """The package of a module in the picture."""
    if module in GATHERED:
        return GATHERED[module]
    parts = module.split(".")
    return GATHERED.get(".".join(parts[:2]), parts[1])


def packages(graph: Graph) -> Graph:
    """Package -> the other packages that it imports."""
    gathered: Graph = {}
    for module, wanted in graph.items():
        own = gathered.setdefault(package(module), set())
        own |= {package(item) for item in wanted} - {package(module)}
    return gathered


def cycles(graph: Graph) -> list[list[str]]:
    """Import cycles: strongly connected components of more than one node (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            members = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(members) > 1:
                found.append(sorted(members))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(found)


def floors(graph: Graph) -> list[list[str]]:
    """Packages by level from the bottom up; each is one level above the highest package that it imports."""
    level: dict[str, int] = {}

    def height(node: str) -> int:
        if node not in level:
            level[node] = max((height(other) + 1 for other in graph[node]), default=0)
        return level[node]

    top = max(map(height, graph))
    return [sorted(node for node in graph if level[node] == floor) for floor in range(top + 1)]


def reduced(graph: Graph) -> Graph:
    """The transitive reduction: arrows that do not follow from others."""
    reach: Graph = {}

    def below(node: str) -> set[str]:
        if node not in reach:
            reach[node] = set().union(*({other} | below(other) for other in graph[node]))
        return reach[node]

    return {
        node: {other for other in wanted if not any(other in below(third) for third in wanted - {other})}
        for node, wanted in graph.items()
    }


def places(levels: Sequence[Sequence[str]], graph: Graph) -> dict[str, tuple[float, float]]:
    """Centre (x, y) px of each box; within a level ordered by the positions of their imports (barycentre method)."""
    found: dict[str, tuple[float, float]] = {}
    for floor, names in enumerate(levels):
        middle = {n: sum(found[o][0] for o in graph[n]) / len(graph[n]) if graph[n] else WIDTH / 2 for n in names}
        ordered = sorted(names, key=lambda name: (middle[name], name))
        step = (WIDTH - 2 * MARGIN) / len(ordered)
        y = MARGIN + HEIGHT / 2 + FLOOR * (len(levels) - 1 - floor)
        shift = step / 4 if floor % 2 else 0.0  # so that arrows across two levels pass between boxes
        for k, name in enumerate(ordered):
            x = MARGIN + step * (k + 0.5) + (shift if len(ordered) > 1 else 0.0)
            found[name] = (min(x, WIDTH - MARGIN - BOX / 2), y)
    return found


def draw(graph: Graph) -> str:
    """The picture as SVG."""
    arrows, levels = reduced(graph), floors(graph)
    at = places(levels, arrows)
    height = 2 * MARGIN + FLOOR * (len(levels) - 1) + HEIGHT
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" role="img">',
        "<title>Packages of synth: each stands above all that it imports</title>",
        '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#666"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
    ]
    for name in sorted(arrows):
        for other in sorted(arrows[name]):
            (x1, y1), (x2, y2) = at[name], at[other]
            y1, y2 = y1 + HEIGHT / 2, y2 - HEIGHT / 2
            bend = (y2 - y1) / 2
            path = f"M{x1:.0f} {y1:.0f}C{x1:.0f} {y1 + bend:.0f} {x2:.0f} {y2 - bend:.0f} {x2:.0f} {y2:.0f}"
            lines.append(f'<path d="{path}" fill="none" stroke="#888" marker-end="url(#head)"/>')
    for name, (x, y) in sorted(at.items()):
        lines.append(
            f'<rect x="{x - BOX / 2:.0f}" y="{y - HEIGHT / 2:.0f}" width="{BOX}" height="{HEIGHT}" rx="5" '
            'fill="#e8f1fa" stroke="#20507a"/>'
            f'<text x="{x:.0f}" y="{y + 5:.0f}" text-anchor="middle" font-size="15" fill="#111">{escape(name)}</text>'
        )
    return "\n".join([*lines, "</svg>", ""])


def main() -> int:
    graph = packages(imports(modules()))
    circles = cycles(graph)
    if circles:
        print("packages that import each other in a circle:", *map(" ".join, circles), sep="\n  ", file=sys.stderr)
        return 1
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.write_text(draw(graph), encoding="utf-8")
    print(PICTURE.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
