"""Local arrays of structs in a kernel, kept a row a field.

    state = rows(State)               LANES structs, one local vector a field
    slab = rows(Slab, BLOCKS + 1)     so many times LANES structs, one local matrix a field
    state = rows(State, lanes=PLACES) PLACES structs instead of LANES
    state = rows(State, within=numbers, first=3)
                                      LANES structs in an array of numbers, after three other fields
    state[i], slab[k, i]              the struct of a lane
    state[i].theta                    a field of it: to read, to set, or as a `wp.ref`
    state[i] = after                  sets all fields
    state[i] = wp.where(live, after, state[i])    sets them where `live` holds

A field that is a vector has one local variable a component: `state[i].place` reads or sets all of
them, `state[i].place[2]` one, whose index must be a literal. A field that is a bool is kept as an
integer. Of an `if` on a parameter that is true or false, such as CHAINS, only the branch that
is taken is written: the other one may mention structs that its instance does not have.
What lies within an array, which a kernel may set anew, has a row of `lanes` numbers a field:
`state[i].theta` becomes `numbers[i + 3 * lanes]`. All fields are numbers there.

The compiler makes vector code of a loop over lanes only if every field is a local variable of its
own. An array of structs takes nine times as long, a struct of vectors up to 3.6 times. So `@kernel`
rewrites the kernel with such variables before Warp reads it: `state[i].theta` becomes
`state_theta[i]`. `python -m tools.kernel_text FILE` prints what Warp reads. The line numbers in
Warp's error messages are those of that text.

Rows exist only in kernels. A func takes structs by value and returns one, or changes one that it
takes as `wp.ref`. Two rules keep loops over lanes vector code: read a struct from its rows on the
line that uses it, not at the head of a loop; and no struct has a field that nobody reads.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import textwrap
from collections.abc import Callable
from typing import Any

import warp as wp

TEXTS: dict[str, str] = {}
"""The text of every kernel as Warp reads it, by the name of its module."""


def rows(
    struct: Any,
    count: int | None = None,
    *,
    lanes: int | None = None,
    within: Any = None,
    first: int = 0,
) -> Any:
    """Declares LANES structs, or `lanes`, or `count` times as many; only inside `@kernel`.

    Args:
        struct: The struct.
        count: How many times as many.
        lanes: Lanes, in place of LANES.
        within: The array of numbers in which they lie, shape [field * lanes]; local without it.
        first: Fields of other structs that come before there.
    """
    raise TypeError("rows() stands for local variables of a kernel that @kernel writes out")


def kernel(function: Callable[..., None]) -> Any:
    """`wp.kernel` of a function, after its rows are replaced by local variables.

    Raises:
        SyntaxError: A row is used in a way that has no meaning; with its line.
    """
    names = function.__globals__
    module = names["__name__"]
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    definition = tree.body[0]
    assert isinstance(definition, ast.FunctionDef)
    definition.decorator_list = []
    text = ast.unparse(_WriteOut(names).visit(tree)) + "\n"
    file = f"<rows of {module}>"
    linecache.cache[file] = (len(text), None, text.splitlines(True), file)
    TEXTS[module] = text
    exec(compile(text, file, "exec"), names)
    return wp.kernel(names[function.__name__], module=wp.get_module(module))


def _length(kind: Any) -> int:
    """Number of components of a vector type; 0 for any other type."""
    return int(kind._length_) if len(getattr(kind, "_shape_", ())) == 1 else 0


def _is_bool(kind: Any) -> bool:
    """Whether a type is bool."""
    return kind in (bool, wp.bool)


def _columns(field: str, kind: Any) -> list[str]:
    """Names of the local variables of a field, without the name of the row before them."""
    return [f"{field}_{part}" for part in range(_length(kind))] or [field]


class _WriteOut(ast.NodeTransformer):
    """Replaces every row by one local variable a field."""

    def __init__(self, names: dict[str, Any]) -> None:
        self.names = names
        self.structs: dict[str, tuple[str, dict[str, Any]]] = {}
        """The name of the struct of each row, and its fields with their types."""
        self.within: dict[str, tuple[str, int, int]] = {}
        """Of rows in an array: its name, the fields that come before, and the lanes."""

    def _is_row(self, node: ast.AST) -> bool:
        return (
            isinstance(node, ast.Subscript)
            and isinstance(node.value, ast.Name)
            and node.value.id in self.structs
        )

    def _entry(self, row: ast.Subscript, field: str) -> ast.Subscript:
        """`state_theta[i]` of `state[i]` and theta, or its number in an array."""
        assert isinstance(row.value, ast.Name)
        if row.value.id in self.within:
            array, first, lanes = self.within[row.value.id]
            number = first + list(self.structs[row.value.id][1]).index(field)
            place = ast.BinOp(row.slice, ast.Add(), ast.Constant(number * lanes))
            return ast.Subscript(ast.Name(array), place if number else row.slice, ast.Load())
        name = ast.Name(f"{row.value.id}_{field}", ast.Load())
        return ast.Subscript(name, row.slice, ast.Load())

    def _parts(self, row: ast.Subscript, field: str) -> list[ast.Subscript]:
        """The entries of a field: one, or one for each component of a vector."""
        assert isinstance(row.value, ast.Name)
        kind = self.structs[row.value.id][1][field]
        return [self._entry(row, part) for part in _columns(field, kind)]

    def _value(self, row: ast.Subscript, field: str) -> ast.expr:
        """An expression for one field of the struct of a lane."""
        assert isinstance(row.value, ast.Name)
        kind, parts = self.structs[row.value.id][1][field], self._parts(row, field)
        if _length(kind):
            name = f"Rows{row.value.id.title()}{field.title()}"
            self.names[name] = kind
            return ast.Call(ast.Name(name, ast.Load()), list(parts), [])
        if _is_bool(kind):
            return ast.Compare(parts[0], [ast.NotEq()], [ast.Constant(0)])
        return parts[0]

    def _stores(self, row: ast.Subscript, field: str, new: str, condition: str = "") -> list[str]:
        """Lines that set a field of the struct of a lane, if a condition holds."""
        assert isinstance(row.value, ast.Name)
        kind, lines = self.structs[row.value.id][1][field], []
        for number, part in enumerate(self._parts(row, field)):
            entry, taken = ast.unparse(part), f"{new}[{number}]" if _length(kind) else new
            taken = f"wp.where({taken}, 1, 0)" if _is_bool(kind) else taken
            taken = f"wp.where({condition}, {taken}, {entry})" if condition else taken
            lines.append(f"{entry} = {taken}")
        return lines

    def _type(self, kind: Any, count: int | None, lanes: int | None) -> str:
        """The name of the type of a field's variable; a new type is created."""
        scalar = kind._wp_scalar_type_ if _length(kind) else kind
        integer = scalar in (int, wp.int32) or _is_bool(scalar)
        name = f"{'Int' if integer else 'Real'}Rows{count or ''}{f'Of{lanes}' if lanes else ''}"
        dtype, lanes = (int if integer else self.names["real"]), lanes or self.names["LANES"]
        if name not in self.names:
            self.names[name] = (
                wp.types.vector(length=lanes, dtype=dtype)
                if count is None
                else wp.types.matrix(shape=(count, lanes), dtype=dtype)
            )
        return name

    def _number(self, value: ast.expr) -> int:
        """The value of a number in a declaration."""
        return int(eval(ast.unparse(value), self.names))

    def visit_Assign(self, node: ast.Assign) -> Any:
        """Rewrites a declaration of rows or an assignment to a row; leaves any other."""
        target, value = node.targets[0], node.value
        if (
            isinstance(value, ast.Call)
            and isinstance(value.func, ast.Name)
            and value.func.id == "rows"
        ):
            return self._declared(target, value)
        if self._is_row(target):
            assert isinstance(target, ast.Subscript)
            return self._set(target, value)
        if isinstance(target, ast.Attribute) and self._is_row(target.value):
            assert isinstance(target.value, ast.Subscript)
            return self._set_field(target.value, target.attr, value) or self.generic_visit(node)
        return self.generic_visit(node)

    def visit_If(self, node: ast.If) -> Any:
        """Keeps the branch that is taken of an `if` on a parameter, such as CHAINS."""
        taken = self.names.get(node.test.id) if isinstance(node.test, ast.Name) else None
        if not isinstance(taken, bool):
            return self.generic_visit(node)
        branch = ast.Module(node.body if taken else node.orelse, [])
        return self.generic_visit(branch).body

    def _set_field(self, row: ast.Subscript, field: str, value: ast.expr) -> list[ast.stmt]:
        """Lines that set a field that is not one number; empty for a number."""
        assert isinstance(row.value, ast.Name)
        kind = self.structs[row.value.id][1].get(field)
        if not _length(kind) and not _is_bool(kind):
            return []
        new = f"{row.value.id}_{field}_after"
        before = f"{new} = {ast.unparse(self.visit(value))}"
        return ast.parse("\n".join([before, *self._stores(row, field, new)])).body

    def _declared(self, target: ast.expr, value: ast.Call) -> list[ast.stmt]:
        if not (isinstance(target, ast.Name) and isinstance(value.args[0], ast.Name)):
            raise SyntaxError(f"line {value.lineno}: rows are declared as `name = rows(Struct)`")
        count = self._number(value.args[1]) if len(value.args) > 1 else None
        lanes = next((self._number(k.value) for k in value.keywords if k.arg == "lanes"), None)
        struct = value.args[0].id
        fields = self.names[struct].vars
        given = {each.arg: each.value for each in value.keywords}
        if "within" in given:
            kinds = {variable.type for variable in fields.values()}
            if count is not None or kinds != {self.names["real"]}:
                raise SyntaxError(f"line {value.lineno}: all fields within an array are numbers")
            self.structs[target.id] = struct, {name: each.type for name, each in fields.items()}
            first = self._number(given["first"]) if "first" in given else 0
            array = ast.unparse(given["within"])
            self.within[target.id] = array, first, lanes or self._number(ast.Name("LANES"))
            return []
        columns = {
            column: variable.type
            for field, variable in fields.items()
            for column in _columns(field, variable.type)
        }
        hidden = {f"{target.id}_{part}" for part in (*columns, "after")} & set(self.names)
        if hidden:
            raise SyntaxError(f"line {value.lineno}: {target.id} hides {', '.join(sorted(hidden))}")
        self.structs[target.id] = struct, {name: field.type for name, field in fields.items()}
        lines = [
            f"{target.id}_{column} = {self._type(kind, count, lanes)}()"
            for column, kind in columns.items()
        ]
        return ast.parse("\n".join(lines)).body

    def _set(self, row: ast.Subscript, value: ast.expr) -> list[ast.stmt]:
        assert isinstance(row.value, ast.Name)
        rows_name, condition = row.value.id, ""
        if isinstance(value, ast.Call) and ast.unparse(value.func) == "wp.where":
            kept = ast.unparse(row)
            if ast.unparse(value.args[2]) != kept:
                raise SyntaxError(f"line {row.lineno}: a row keeps itself: wp.where(..., {kept})")
            condition, value = ast.unparse(self.visit(value.args[0])), value.args[1]
        if isinstance(value, ast.Name):
            before, new = "", value.id
        else:
            new = f"{rows_name}_after"
            before = f"{new} = {ast.unparse(self.visit(value))}\n"
        lines = []
        for field in self.structs[rows_name][1]:
            lines += self._stores(row, field, f"{new}.{field}", condition)
        return ast.parse(before + "\n".join(lines)).body

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        """Rewrites a field of a row; leaves any other attribute."""
        if self._is_row(node.value):
            row = self.generic_visit(node.value)
            assert isinstance(row, ast.Subscript)
            assert isinstance(row.value, ast.Name)
            if node.attr not in self.structs[row.value.id][1]:
                raise SyntaxError(f"line {node.lineno}: {row.value.id} has no field {node.attr}")
            return ast.copy_location(self._value(row, node.attr), node)
        return self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        """Rewrites the struct of a lane or a component of one of its vectors."""
        held, number = node.value, node.slice
        if (
            isinstance(held, ast.Attribute)
            and self._is_row(held.value)
            and isinstance(number, ast.Constant)
        ):
            assert isinstance(held.value, ast.Subscript)
            row = self.visit(held.value.slice)
            at = ast.Subscript(held.value.value, row, ast.Load())
            return self._parts(at, held.attr)[number.value]
        node = self.generic_visit(node)  # type: ignore[assignment]
        if not self._is_row(node):
            return node
        assert isinstance(node.value, ast.Name)
        struct, fields = self.structs[node.value.id]
        parts = [self._value(node, field) for field in fields]
        return ast.Call(ast.Name(struct, ast.Load()), parts, [])
