# SPDX-License-Identifier: GPL-3.0-or-later
"""Neither files nor packages import in circles, data flows one way, and all state lies in one place."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PARTS = ("prt_addon", "operators", "ui")
FLOORS = {"prt_addon", "prt_addon.core", "prt_addon.scene"}
"""Packages whose own files are each a room of its own."""


def modules():
    """Every module of the extension by its dotted name."""
    found = {}
    for part in PARTS:
        for path in (ROOT / part).rglob("*.py"):
            names = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(names[:-1] if names[-1] == "__init__" else names)] = path
    return found


MODULES = modules()


def imports(name):
    """The modules that one imports when it is imported: not those for type checkers alone."""
    path = MODULES[name]
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    pending, found = [ast.parse(path.read_text(encoding="utf-8"))], set()
    while pending:
        for node in ast.iter_child_nodes(pending.pop()):
            if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
                continue
            if isinstance(node, ast.ImportFrom) and node.level:
                base = ".".join([*package[: len(package) - node.level + 1], *filter(None, [node.module])])
                found |= {full if (full := f"{base}.{alias.name}") in MODULES else base for alias in node.names}
            pending.append(node)
    return (found & MODULES.keys()) - {name}


def room(name):
    """The package of a module; the module itself where it stands in a hall."""
    package = name.rpartition(".")[0]
    return name if package in FLOORS or not package else package


def circles(graph):
    """Groups of nodes that lead to each other: what is left when nodes without ways in or out are taken away."""
    left = {node: set(ways) for node, ways in graph.items()}
    while True:
        reached = set().union(*left.values())
        dead = {node for node, ways in left.items() if not ways & left.keys() or node not in reached}
        if not dead:
            return left
        left = {node: ways - dead for node, ways in left.items() if node not in dead}


def test_the_check_itself():
    assert circles({"a": {"b"}, "b": {"a"}, "c": {"a"}, "d": set()}).keys() == {"a", "b"}
    assert not circles({"a": {"b", "c"}, "b": {"c"}, "c": set()})
    assert "prt_addon.core.problem" in imports("prt_addon.core.bake.bake")


def test_no_circles_between_files():
    assert not circles({name: imports(name) for name in MODULES})


def test_no_circles_between_packages():
    graph: dict[str, set[str]] = {}
    for name in MODULES:
        graph.setdefault(room(name), set()).update({room(other) for other in imports(name)} - {room(name)})
    assert not circles(graph)


@pytest.mark.parametrize(
    ("above", "below"),
    [
        ("prt_addon.scene", "prt_addon.core"),
        ("prt_addon.scene", "prt_addon.worker"),
        ("prt_addon.worker", "prt_addon.core"),
        ("operators", "prt_addon"),
        ("ui", "operators"),
    ],
)
def test_what_lies_below_knows_nothing_of_what_lies_above(above, below):
    lower = [name for name in MODULES if name == below or name.startswith(f"{below}.")]
    assert lower and not [name for name in lower for other in imports(name) if other.split(".")[:2] == above.split(".")]


MEMOS = {
    "core.exchange.games202.course_matrix",
    "core.microfacet.table.energy_table",
    "core.sky.cube_map._triple_products",
    "core.sky.truncation._wall",
    "core.sphere.rotation._sample_band",
    "core.transport.direct._sums_of_eight",
    "scene.sky.identity._ends",
    "scene.sky.studio.studio_skies",
    "ui.report._lines",
}
"""Functions of nothing but their arguments whose results are remembered: that is no state, whatever file is open."""


def states(source):
    """What a module could hold from one call to the next: globals, containers that begin empty, remembered results."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            yield from node.names
        if isinstance(node, ast.FunctionDef):
            yield from (node.name for one in node.decorator_list if re.match(r"(lru_)?cache\b", ast.unparse(one)))
    bodies = [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]
    for node in (node for body in bodies for node in body.body):
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if re.fullmatch(r"\[\]|\{\}|\w*([sS]et|[dD]ict|list|deque|Counter)\(\)", ast.unparse(node.value)):
                yield ast.unparse(target)


def test_all_state_lies_in_the_session():
    """`session.py` keeps it, so that one call clears it."""
    source = "A = {}\nB = {1}\nclass C:\n    d: list = []\n@lru_cache(4)\ndef e():\n    global f"
    assert set(states(source)) == {"A", "d", "e", "f"}
    found = {f"{name}.{one}" for name, path in MODULES.items() for one in states(path.read_text(encoding="utf-8"))}
    assert {name.removeprefix("prt_addon.") for name in found} == MEMOS
