"""The plan of the house, held to: who imports whom, and what a kernel may be."""

from __future__ import annotations

import ast
import functools
import gc
import graphlib
import pathlib
import re
import sys
from collections.abc import Iterator

import pytest

from tools.house import MAPPED, MODULES, ROOMS, readme_map
from warprock.case.keys import KEYS
from warprock.engines import ENGINES

ROOT = pathlib.Path(__file__).resolve().parent.parent
FRONT = ("warprock/__init__.py", "warprock/__main__.py")
"""Where users come in: names for `import warprock`, each brought from its room when it is first
asked for, and `python -m warprock`."""
MOST_ARGUMENTS, MOST_VALUES = 8, 4
KERNEL_MARKS = {"wp.kernel", "kernel"}
"""Decorators of kernels: `kernel` writes rows of structs out first, see kernels/launch/rows.py."""

SOURCES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("warprock", "kernels", "cases", "tools")
    for path in (ROOT / folder).rglob("*.py")
)


def _room_of(file: str) -> str:
    """The room of a source file: its folder, or its own name at the top of `warprock/`."""
    top, *inner = pathlib.PurePosixPath(file).with_suffix("").parts
    return top if top in MAPPED else inner[0]


@pytest.fixture(scope="module", autouse=True)
def trees_stay() -> Iterator[None]:
    """A million nodes are made and stay: to look for garbage among them takes as long again."""
    gc.disable()
    yield
    gc.enable()


@functools.cache
def _tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text(encoding="utf-8"), file)


@functools.cache
def _nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    """Every node of a source file, as `ast.walk` has them, in half the time."""
    found: list[ast.AST] = [tree]
    for node in found:
        for value in map(functools.partial(getattr, node), node._fields):
            if isinstance(value, ast.AST):
                found.append(value)
            elif isinstance(value, list):
                found += [each for each in value if isinstance(each, ast.AST)]
    return tuple(found)


@functools.cache
def _file_of(module: str) -> str | None:
    """The source file of a module of ours, as a path from the root."""
    stem = module.replace(".", "/")
    for mapped in ("kernels", "cases"):
        if stem == f"warprock/{mapped}" or stem.startswith(f"warprock/{mapped}/"):
            stem = stem.removeprefix("warprock/")
    for file in (f"{stem}.py", f"{stem}/__init__.py"):
        if (ROOT / file).is_file():
            return file
    return None


@functools.cache
def _imports(file: str) -> tuple[str, ...]:
    """Every module that a file imports, wherever in the file it does."""
    found = []
    for node in _nodes(_tree(file)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno}: relative import"
            assert node.module is not None
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                found.append(inner if _file_of(inner) else node.module)
    return tuple(found)


@functools.cache
def _functions(tree: ast.Module) -> tuple[ast.FunctionDef, ...]:
    return tuple(node for node in _nodes(tree) if isinstance(node, ast.FunctionDef))


def _decorators(function: ast.FunctionDef) -> list[str]:
    calls = [d.func if isinstance(d, ast.Call) else d for d in function.decorator_list]
    return [ast.unparse(call) for call in calls]


def test_there_are_sources():
    assert {
        "kernels/impulse/block.py",
        "warprock/cli/main.py",
        "warprock/engines/housner.py",
    } <= set(SOURCES)


def test_rooms_are_listed_from_the_ground_up():
    names = [room.name for room in ROOMS]
    for index, room in enumerate(ROOMS):
        assert set(room.imports) <= set(names[:index]), f"{room.name} imports what is above it"
    modules = {path.stem for path in (ROOT / "warprock").glob("*.py")} - {"__init__", "__main__"}
    folders = {path.parent.name for path in (ROOT / "warprock").glob("*/__init__.py")}
    assert modules == set(MODULES)
    assert modules | folders | set(MAPPED) == set(names)
    assert all(room.holds for room in ROOMS)


def test_the_readme_shows_the_plan():
    assert f"```\n{readme_map()}\n```" in (ROOT / "README.md").read_text(encoding="utf-8")


HELD = [file for file in SOURCES if not file.startswith("tools/") and file not in FRONT]


def test_a_room_imports_only_what_the_plan_allows():
    for file in HELD:
        room = next(room for room in ROOMS if room.name == _room_of(file))
        for module in _imports(file):
            top = module.split(".")[0]
            if top != "warprock":
                allowed = top in sys.stdlib_module_names or top in room.packages
                assert allowed, f"{file} ({room.name}) imports {module}"
                continue
            target = _file_of(module)
            assert target is not None, f"{file} imports {module}, which is no file of ours"
            if target not in FRONT:
                own = _room_of(target)
                assert own in (room.name, *room.imports), f"{file} ({room.name}) imports {module}"


def test_no_module_imports_itself_by_way_of_others():
    graph = {}
    for file in HELD:
        targets = {_file_of(module) for module in _imports(file)}
        graph[file] = {each for each in targets if each is not None} - {file, *FRONT}
    assert tuple(graphlib.TopologicalSorter(graph).static_order())


def test_no_engine_imports_another_engine():
    engines = {target.partition(":")[0] for target in ENGINES.values()}
    for module in engines:
        file = _file_of(module)
        assert file is not None, f"{module} is no file of ours"
        others = engines - {module}
        assert not others & set(_imports(file)), file


@pytest.mark.parametrize(
    ("package", "only_in"),
    [
        ("matplotlib", ("warprock/figures/",)),
        ("newton", ("warprock/programs/newton", "warprock/scenes/viewers")),
        ("mujoco", ("warprock/programs/mujoco",)),
        ("pybullet", ("warprock/programs/bullet",)),
        ("bpy", ("warprock/programs/blender",)),
        ("numba", ("warprock/programs/loops",)),
        (
            "scipy",
            (
                *("warprock/oracle/", "warprock/recordings/", "warprock/programs/"),
                *("warprock/case/sampling", "warprock/running/cells"),
                *("warprock/analysis/", "warprock/bodies/", "warprock/model/hull"),
                "warprock/drawings/",
                *("warprock/model/base_path", "warprock/model/floor", "warprock/model/solids"),
            ),
        ),
        ("tables", ("warprock/recordings/fema_p695",)),
        ("trimesh", ("warprock/bodies/",)),
        ("ezdxf", ("warprock/drawings/dxf",)),
        ("click", ("warprock/cli/",)),
    ],
)
def test_a_heavy_package_is_imported_in_one_room(package: str, only_in: tuple[str, ...]):
    for file in SOURCES:
        if package in {module.split(".")[0] for module in _imports(file)}:
            assert file.startswith((*only_in, "tools/")), f"{file} imports {package}"


def test_nothing_imports_tests_or_tools():
    for file in SOURCES:
        tops = {module.split(".")[0] for module in _imports(file)}
        assert not tops & {"tests", "tools", "kernels", "cases"}, file


REFERENCE = re.compile(r"`((?:[a-z_]+\.)+[A-Za-z_]+)(?:\(\))?`")
"""What a comment or docstring names in another file: `running.results.write_results`."""


ENDINGS = ("csv", "json", "mplstyle", "parquet", "png", "py", "toml")


def test_names_of_other_modules_in_comments_are_true():
    modules = {
        ".".join(pathlib.PurePosixPath(file).with_suffix("").parts[1:]): _tree(file)
        for file in SOURCES
        if file.startswith("warprock/")
    }
    bound = {
        name: _constants(tree)
        | {each.name for each in tree.body if isinstance(each, ast.FunctionDef | ast.ClassDef)}
        for name, tree in modules.items()
    }
    leaves = {name.rpartition(".")[2] for name in modules}
    for file in SOURCES:
        room = _room_of(file)
        for reference in REFERENCE.findall((ROOT / file).read_text(encoding="utf-8")):
            plain = reference.removeprefix("warprock.")
            module, _, name = plain.rpartition(".")
            if module.rpartition(".")[2] not in leaves or name in ENDINGS or plain in KEYS:
                continue
            known = [each for each in (module, f"{room}.{module}") if each in modules]
            true = plain in modules or any(name in bound[each] for each in known)
            assert true, f"{file}: `{reference}` is nowhere"


def test_which_outcomes_and_statuses_count_is_said_once():
    again = re.compile(
        r"OVERTURNED, Outcome\.SLID_OFF\)|\"overturned\", \"slid_off\"[\])]"
        r"|name\.lower\(\) for \w+ in (?:USABLE|SOUND|FALLEN)"
    )
    found = [file for file in SOURCES if again.search((ROOT / file).read_text(encoding="utf-8"))]
    assert found == ["warprock/model/response.py"]


def test_names_say_something():
    for file in SOURCES:
        stem = pathlib.PurePosixPath(file).stem
        assert not {"utils", "util", "helper", "helpers", "manager", "misc"} & set(stem.split("_"))


KERNEL_FILES = [file for file in SOURCES if file.startswith("kernels/")]


READ = {"pool", "motions"}
"""Arrays that a func may take, to read the motion of the base; others come in structs."""


def test_functions_of_kernels_are_no_lone_participles():
    for file in KERNEL_FILES:
        for function in _functions(_tree(file)):
            name = function.name
            lone = "_" not in name and name.endswith(("ed", "known", "gone", "taken"))
            assert not lone or name == "fused", f"{file}: {name}"


def test_kernels_have_few_arguments_and_funcs_take_few_arrays():
    for file in KERNEL_FILES:
        for function in _functions(_tree(file)):
            names = _decorators(function)
            arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
            if KERNEL_MARKS & set(names):
                assert len(arguments) <= MOST_ARGUMENTS, f"{file}: {function.name}"
            if "wp.func" in names:
                for argument in arguments:
                    note = "" if argument.annotation is None else ast.unparse(argument.annotation)
                    assert note, f"{file}: {function.name}: {argument.arg} has no type"
                    array = "array" in note and argument.arg not in READ
                    assert not array, f"{file}: {function.name} takes an array"


WIDE: dict[str, str] = {}
"""Funcs that keep more arguments or values than others, `FILE: NAME` -> what a struct would cost:
the ratio of speeds in paired runs."""


def test_funcs_take_few_arguments_and_give_few_values_back():
    found = set()
    for file in KERNEL_FILES:
        for function in _functions(_tree(file)):
            if "wp.func" not in _decorators(function):
                continue
            taken = len(function.args.posonlyargs + function.args.args + function.args.kwonlyargs)
            values = (node.value for node in ast.walk(function) if isinstance(node, ast.Return))
            given = max((len(v.elts) for v in values if isinstance(v, ast.Tuple)), default=1)
            if taken > MOST_ARGUMENTS or given > MOST_VALUES:
                found.add(f"{file}: {function.name}")
    assert found == set(WIDE)


COEFFICIENTS = {"Series", "Curve", "Curves", "Terms"}
"""Types of power series: the number is the order of a coefficient."""
LISTS = {"blocks", "leaves", "scratch", "lever", "ru"}
"""What may have the number 0, its first: the only block of a lane, the first corner of a polygon
that is being cut, the first of the contacts of a lane."""
SMALL = 4
"""Components of a vector, a quaternion and a small matrix need no names: x, y, z and w."""


@functools.cache
def _declarations(file: str) -> dict[str, ast.stmt]:
    """Types and funcs of a kernel file, and those that it imports, by name."""
    found: dict[str, ast.stmt] = {}
    for node in _nodes(_tree(file)):
        if isinstance(node, ast.ImportFrom):
            found |= {each.name: node for each in node.names}
        elif isinstance(node, ast.ClassDef | ast.FunctionDef):
            found[node.name] = node
        elif isinstance(node, ast.Assign) and ast.unparse(node.value).startswith("wp.types."):
            found[ast.unparse(node.targets[0])] = node
    return found


def _declared(file: str, name: str) -> tuple[str, ast.stmt | None]:
    """Where a type, or what a func gives back, is declared: the file, and the statement if any.

    Args:
        file: A kernel file.
        name: What the type or the func is called there.
    """
    node = _declarations(file).get(name)
    if isinstance(node, ast.FunctionDef):
        return _declared(file, ast.unparse(node.returns)) if node.returns else (file, None)
    if not isinstance(node, ast.ImportFrom):
        return file, node
    source = (node.module or "").removeprefix("warprock.").replace(".", "/") + ".py"
    return _declared(source, name) if source in KERNEL_FILES else (file, None)


def _sizes(node: ast.stmt | None) -> list[int]:
    """Rows and columns of a vector or matrix; 0 if a case decides them; none if it is neither."""
    if not (isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)):
        return []
    shape = node.value.keywords[0].value
    numbers = shape.elts if isinstance(shape, ast.Tuple) else [shape]
    return [int(ast.unparse(n)) if isinstance(n, ast.Constant) else 0 for n in numbers]


def _types(function: ast.FunctionDef) -> dict[str, str]:
    """Types of arguments, and of locals that a constructor or a func makes."""
    found = {}
    for each in function.args.args:
        note = each.annotation
        if note is not None:  # of wp.ref[Struct] the struct
            found[each.arg] = ast.unparse(note.slice if isinstance(note, ast.Subscript) else note)
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            made, value = node.targets[0], node.value
            several = isinstance(made, ast.Tuple) and isinstance(value, ast.Tuple)
            pairs = zip(made.elts, value.elts, strict=True) if several else [(made, value)]  # type: ignore[attr-defined]
            for target, source in pairs:
                if isinstance(target, ast.Name) and isinstance(source, ast.Call):
                    found[target.id] = ast.unparse(source.func)
                elif isinstance(target, ast.Name) and isinstance(source, ast.Name):
                    found.setdefault(target.id, found.get(source.id, ""))
    return found


def _kind(file: str, held: ast.expr, types: dict[str, str]) -> tuple[str, str]:
    """The type of an expression, and the file that calls it so; no name if nothing tells it."""
    if not isinstance(held, ast.Attribute):
        return file, types.get(held.id, "") if isinstance(held, ast.Name) else ""
    where, struct = _declared(*_kind(file, held.value, types))
    for field in struct.body if isinstance(struct, ast.ClassDef) else []:
        if isinstance(field, ast.AnnAssign) and ast.unparse(field.target) == held.attr:
            return where, ast.unparse(field.annotation)
    return file, ""


def _is_number_of_row(
    file: str, held: ast.expr, numbers: list[object], types: dict[str, str]
) -> bool:
    """Whether one of two places, or a single one, is the number of a row of `held`."""
    kind = _kind(file, held, types)
    _, node = _declared(*kind)
    if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in COEFFICIENTS:
        return False
    name = held.attr if isinstance(held, ast.Attribute) else ast.unparse(held)
    if name in LISTS and 0 in numbers:
        return False
    # Of a row that has no number a component may have one.
    sizes = _sizes(node)[len(numbers) - 1 if numbers[0] is None else 0 :]
    if sizes:
        return not all(0 < size <= SMALL for size in sizes)
    large = any(isinstance(n, int) and n >= SMALL for n in numbers)
    return large or (bool(kind[1]) and len(numbers) == 2 and None in numbers)


def _numbered(file: str, tree: ast.Module) -> Iterator[str]:
    """Rows of matrices, arrays and long vectors that a kernel file numbers by hand."""
    for function in _functions(tree):
        types: dict[str, str] = {}
        for node in ast.walk(function):
            if not isinstance(node, ast.Subscript):
                continue
            places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
            numbers = [p.value if isinstance(p, ast.Constant) else None for p in places]
            if any(isinstance(n, int) for n in numbers):
                types = types or _types(function)
                # What has three or four indices is an array: [sample, block, direction, lane].
                if len(places) > 2 or _is_number_of_row(file, node.value, numbers, types):
                    yield f"{file}:{node.lineno}: {ast.unparse(node)}"


def test_no_row_has_a_number_given_by_hand():
    assert not [row for file in KERNEL_FILES for row in _numbered(file, _tree(file))]


def _moved(file: str, tree: ast.Module) -> Iterator[str]:
    """Rows that a kernel file names by another row and a number: `x[GROUND + 1]`, `x[2 * LANES]`.

    A number may be taken from a count of blocks or degrees, as in `p[DEGREE - 1]`.
    """
    for function in _functions(tree):
        for held in ast.walk(function):
            for part in ast.walk(held.slice) if isinstance(held, ast.Subscript) else ():
                if isinstance(part, ast.BinOp) and isinstance(part.op, ast.Add | ast.Mult):
                    sides = {type(side): side for side in (part.left, part.right)}
                    name, number = sides.get(ast.Name), sides.get(ast.Constant)
                    lanes = isinstance(name, ast.Name) and name.id in ("LANES", "WIDTH")
                    moves = lanes or isinstance(part.op, ast.Add)
                    if isinstance(name, ast.Name) and name.id.isupper() and number and moves:
                        yield f"{file}:{held.lineno}: {ast.unparse(held)}"


def test_no_row_is_named_by_another_and_a_number():
    assert not [row for file in KERNEL_FILES for row in _moved(file, _tree(file))]


@pytest.mark.parametrize(
    ("line", "row"),
    [
        ("x = load[GROUND + 1, i]", "load[GROUND + 1, i]"),
        ("x = held[i + 3 * LANES]", "held[i + 3 * LANES]"),
        ("x = numbers[at + (CONTACT + 2) * WIDTH]", "numbers[at + (CONTACT + 2) * WIDTH]"),
        ("x = p[DEGREE - 1]", ""),
        ("x = laid.graph[pack, NODES + 2 * m]", ""),
        ("x = pairs[p * LANES + i]", ""),
    ],
)
def test_a_row_named_by_another_and_a_number_is_found(line: str, row: str):
    found = [each.split(": ")[1] for each in _moved("kernels", ast.parse(f"def f():\n    {line}"))]
    assert found == ([row] if row else [])


@pytest.mark.parametrize(
    ("file", "line", "row"),
    [
        ("shape_space/contact", "x = gains[4]", "gains[4]"),
        ("event/held/path", "p = Series()\n    x = p[4]", ""),
        ("event_space/lane", "v = Vector()\n    x = v[2]", ""),
        ("event_space/lane", "x = pool[2, place]", "pool[2, place]"),
        ("dem/stack_run", "pose = rows(Pose, BLOCKS + 1)\n    pose[0, i].c = x", "pose[0, i]"),
        ("event_space/stack/step", "x = pose.axes[3, 1]", "pose.axes[3, 1]"),
        ("event_space/stack/step", "x = pose.axes[3 * k, 1]", ""),
        ("impulse/block_run", "leaves[0, lane] = leaf", ""),
        ("impulse/block_run", "leaves[1, lane] = leaf", "leaves[1, lane]"),
        ("impulse/block_run", "places[s, ONLY, 1, lane] = x", "places[s, ONLY, 1, lane]"),
        ("impulse/block_run", "rotations[s, 0, lane] = x", "rotations[s, 0, lane]"),
        ("impulse/block_run", "places[s, ONLY, UPWARDS, lane] = x", ""),
    ],
)
def test_a_number_of_a_row_is_found(file: str, line: str, row: str):
    arguments = "gains: Gains, pool: wp.array2d(dtype=real), pose: Pose, leaves: wp.array2d()"
    tree = ast.parse(f"def f({arguments}):\n    {line}")
    found = [each.split(": ")[1] for each in _numbered(f"kernels/{file}.py", tree)]
    assert found == ([row] if row else [])


def test_no_kernel_file_asks_for_an_adjoint():
    from warprock.kernels.launch import instance

    assert instance.module_options()["enable_backward"] is False
    for file in KERNEL_FILES:
        if file != "kernels/launch/instance.py":
            assert "enable_backward" not in (ROOT / file).read_text(encoding="utf-8"), file


@pytest.mark.thorough
def test_every_kernel_module_is_built_without_its_adjoint():
    """As Warp sees it: the option of each module that holds a kernel, once it is imported."""
    from warprock.kernels.launch.instance import kernel_module

    for file in KERNEL_FILES:
        kernels = [f.name for f in _functions(_tree(file)) if KERNEL_MARKS & set(_decorators(f))]
        if not kernels:
            continue
        module = kernel_module(
            file.removeprefix("kernels/").removesuffix(".py"), precision="float64", motion="still"
        )
        for name in kernels:
            options = getattr(module, name).module.options
            assert options["enable_backward"] is False, f"{file}: {name}"


def test_no_kernel_divides_literals():
    for file in KERNEL_FILES:
        # In a kernel real(1.0 / 3.0) is the quotient of two float32, off by 1e-8, whatever real is.
        for function in _functions(_tree(file)):
            for call in ast.walk(function):
                if isinstance(call, ast.Call) and ast.unparse(call.func) == "real":
                    for part in call.args:
                        names = [node for node in ast.walk(part) if isinstance(node, ast.Name)]
                        plain = isinstance(part, ast.BinOp) and not names
                        assert not plain, f"{file}: real({ast.unparse(part)}) is a float32 quotient"


def _constants(tree: ast.Module) -> set[str]:
    """Names that a file is given, or binds at its top level, by assignment or import."""
    from warprock.kernels.launch.instance import PARAMETERS, SCALAR, kernel_module, public

    names = {*PARAMETERS, *public(kernel_module(SCALAR, precision="float64"))}
    for statement in tree.body:
        if isinstance(statement, ast.Assign):
            stored = [node for target in statement.targets for node in ast.walk(target)]
            names |= {node.id for node in stored if isinstance(node, ast.Name)}
        elif isinstance(statement, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in statement.names}
    return names


def _counted(loop: ast.For) -> bool:
    """Whether Warp may write a loop out, with a constant for its index: its range is constant."""
    call = loop.iter
    if not isinstance(call, ast.Call) or ast.unparse(call.func) != "range":
        return False
    names = [node for part in call.args for node in ast.walk(part) if isinstance(node, ast.Name)]
    return all(name.id.isupper() for name in names)


def _writes(function: ast.FunctionDef) -> dict[str, int]:
    """How often each name is written in a function, or a part of what it holds."""
    count: dict[str, int] = {}
    for node in ast.walk(function):
        if not isinstance(getattr(node, "ctx", None), ast.Store):
            continue
        while isinstance(node, ast.Attribute | ast.Subscript):
            node = node.value
        if isinstance(node, ast.Name):
            count[node.id] = count.get(node.id, 0) + 1
    return count


def _aliases(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Assignments that give one variable of Warp's code two names: line and text.

    Warp 1.19 copies in `a = b`, and nowhere else. A cast of a constant to a 64-bit type turns the
    constant itself into the variable that the cast returns: one that is not set before the cast,
    and that changes with every later write. A tuple is taken apart without a copy: `a, b = c, d.e`
    makes `a` another name of `c` and `b` a pointer into `d`. Of a conditional expression with a
    constant condition its chosen side is all that is left.
    """
    known = _constants(tree)
    for function in _functions(tree):
        if not {"wp.func", *KERNEL_MARKS} & set(_decorators(function)):
            continue
        writes, arguments = _writes(function), {each.arg for each in function.args.args}
        fixed = known - set(writes) - arguments
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
                fixed |= {each.id for each in node.targets if isinstance(each, ast.Name)}
            elif isinstance(node, ast.For) and _counted(node):
                fixed.add(ast.unparse(node.target))
        for node in ast.walk(function):
            if isinstance(node, ast.IfExp):
                yield node.lineno, ast.unparse(node)
            elif isinstance(node, ast.Call) and len(node.args) == 1:
                wide = ast.unparse(node.func) in ("real", "wp.float64", "wp.int64", "wp.uint64")
                if wide and isinstance(node.args[0], ast.Name) and node.args[0].id in fixed:
                    yield node.lineno, ast.unparse(node)
            elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
                assert isinstance(node.targets[0], ast.Tuple)
                for target, value in zip(node.targets[0].elts, node.value.elts, strict=True):
                    source = value
                    while isinstance(source, ast.Attribute | ast.Subscript):
                        source = source.value
                    if not isinstance(target, ast.Name) or not isinstance(source, ast.Name):
                        continue
                    # What an argument holds is there before the function; a local has one write.
                    settled = 0 if source.id in arguments else 1
                    # An element of a local vector is a value, not a pointer.
                    value_of_local = isinstance(value, ast.Subscript) and settled
                    moves = writes.get(source.id, 0) > settled and not value_of_local
                    whole = isinstance(value, ast.Name | ast.Attribute)
                    if moves or (whole and writes[target.id] > 1):
                        yield node.lineno, f"{target.id} = {ast.unparse(value)}"


def test_no_kernel_gives_a_variable_two_names():
    found = [
        f"{file}:{line}: {text}" for file in KERNEL_FILES for line, text in _aliases(_tree(file))
    ]
    assert not found, found


@pytest.mark.parametrize(
    ("body", "alias"),
    [
        ("cap = real(NEVER)", "real(NEVER)"),
        ("cap = real(HALF)", "real(HALF)"),
        ("x = y * wp.float64(COUNT)", "wp.float64(COUNT)"),
        ("n = 3\n    x = real(n)", "real(n)"),
        ("for k in range(3):\n        x = real(k)", "real(k)"),
        ("x = y if MOVES else y * y", "y if MOVES else y * y"),
        ("a, b = y, y * y\n    a = a + b", "a = y"),
        ("n, d = s, y * y\n    n.x = d", "n = s"),
        ("a, b = s.x, y * y\n    s.x = b", "a = s.x"),
        ("a, b = out[0], y * y\n    out[0] = b", "a = out[0]"),
        ("cap = NEVER", None),
        ("for k in range(n):\n        x = real(k)", None),
        ("a, b = y, s.x", None),
        ("v = Lane()\n    a, b = v[0], v[1]\n    v[0] = a + b", None),
        ("first, second = int(COUNT), real(COUNT + 1)", None),
    ],
)
def test_the_rule_on_names_finds_every_form(body: str, alias: str | None):
    text = f"""
MOVES, NEVER, COUNT = True, real(1e30), 3
@wp.kernel
def kernel(y: real, s: Shape, n: int, out: wp.array(dtype=real)):
    {body}
"""
    assert [text for _, text in _aliases(ast.parse(text))] == ([] if alias is None else [alias])
