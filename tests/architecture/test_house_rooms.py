"""What the house asks of its rooms: few files, names that mean one thing, declared state."""

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from tests.architecture.test_house_style import tracked
from tests.paths import ROOT

FILES_PER_FOLDER = 16
BOTH_SIDES = {  # the same idea on both sides of the wire, which share no code
    "Camera",
    "CourseEvent",
    "Endpoint",
    "Image",
    "Link",
    "LinkError",
    "Signing",
    "StatusText",
    "TlogWriter",
    "UsageError",
}
METHODS = (ast.FunctionDef, ast.AsyncFunctionDef)


def source() -> Iterator[tuple[Path, ast.Module]]:
    for path in (*tracked("flightstack/*.py"), *tracked("sitl/*.py")):
        yield path.relative_to(ROOT), ast.parse(path.read_text())


def stored_attributes(method: ast.AST) -> set[str]:
    return {
        node.attr
        for node in ast.walk(method)
        if isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
        and node.value.id == "self"
    }


def born_late(definition: ast.ClassDef) -> set[str]:
    """Attributes that a class declares nowhere and gives first outside of its constructor."""
    methods = [node for node in definition.body if isinstance(node, METHODS)]
    constructors = [m for m in methods if m.name in ("__init__", "__post_init__")]
    declared = {
        node.target.id
        for node in definition.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
    born = declared.union(*map(stored_attributes, constructors))
    return set().union(*map(stored_attributes, methods)) - born


def test_a_folder_holds_few_files() -> None:
    code = [path for top in ("flightstack", "sitl", "tests", "scripts") for path in tracked(top)]
    counts = Counter(path.relative_to(ROOT).parent for path in code)
    crowded = {str(folder): n for folder, n in counts.items() if n > FILES_PER_FOLDER}
    assert not crowded


def test_a_class_name_means_one_thing() -> None:
    homes: dict[str, list[Path]] = defaultdict(list)
    for path, tree in source():
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                homes[node.name].append(path)
    twice = {name: paths for name, paths in homes.items() if len(paths) > 1}
    assert set(twice) <= BOTH_SIDES, twice
    for name, paths in twice.items():
        assert sorted(path.parts[0] for path in paths) == ["flightstack", "sitl"], name


def test_attributes_are_born_in_the_constructor() -> None:
    late = [
        f"{path}:{node.lineno} {node.name}: {', '.join(sorted(attributes))}"
        for path, tree in source()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and (attributes := born_late(node))
    ]
    assert not late, "\n".join(late)
