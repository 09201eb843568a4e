"""Options of a command, made of the Python function of the same name: each is declared once.

An argument that a function takes by its name alone is an option. Its default and its kind are those
of the signature, and its help is what the docstring says of it. The file of the function is read
and not imported: what it computes with takes seconds to import, and `--help` answers at once.
"""

from __future__ import annotations

import ast
import functools
import inspect
import pathlib
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple, TypeVar

import click

import warprock.api
from warprock.cli.completion import Completer

Command = TypeVar("Command", bound=Callable[..., Any])

ROOM = pathlib.Path(warprock.api.__path__[0])
SHARED = {"overrides", "precision", "device", "workers", "progress", "folder"}
"""Arguments of many functions, whose options are those of `warprock.cli.options`."""

_TYPES = {"int": int, "float": float, "bool": bool}
_SECTION = re.compile(r"\n\n(?:Args|Returns):\n")
_ARGUMENT = re.compile(r"^    (\w+): (.+(?:\n     +.+)*)", re.MULTILINE)


class Argument(NamedTuple):
    """An argument of a function.

    Attributes:
        name: Its name.
        kind: The first name of its annotation: `float`, or an alias such as `Column`.
        default: Its default.
        text: What the docstring says of it.
        required: Whether it has none.
    """

    name: str
    kind: str
    default: Any
    text: str
    required: bool

    @property
    def option(self) -> str:
        """Its name on the command line."""
        return _option_name(self.name)


class Function(NamedTuple):
    """A public function, as its file declares it.

    Attributes:
        text: What its docstring says before the arguments.
        arguments: Those that become options.
        told: What its docstring says of every argument, by name.
        held: Whether its lanes are held to a tolerance.
    """

    text: str
    arguments: tuple[Argument, ...]
    told: Mapping[str, str]
    held: bool


@functools.cache
def read_function(module: str, name: str) -> Function:
    """Reads a function of `warprock.api`.

    Args:
        module: Its file there, without the ending: `analyses/map`.
        name: Its name.
    """
    tree = ast.parse((ROOM / f"{module}.py").read_text(encoding="utf-8"))
    node = next(n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == name)
    doc = inspect.cleandoc(ast.get_docstring(node) or "")
    text = _SECTION.split(doc, maxsplit=1)[0]
    rest = doc.partition("\n\nArgs:\n")[2]
    told = {found[1]: " ".join(found[2].split()) for found in _ARGUMENT.finditer(rest)}
    pairs = zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
    arguments = tuple(
        Argument(
            a.arg,
            _kind(a.annotation),
            ast.literal_eval(default or "None"),
            told[a.arg],
            default is None,
        )
        for a, default in pairs
        if a.arg not in SHARED and not isinstance(default, ast.Name)
    )
    rest_of = node.args.kwarg
    held = rest_of is not None and "HowHeld" in ast.unparse(rest_of.annotation or rest_of)
    return Function(text, arguments, told, held)


def _kind(annotation: ast.expr | None) -> str:
    """The first name in an annotation."""
    assert annotation is not None
    return ast.unparse(annotation).partition(" ")[0]


def own_options(
    module: str, name: str, only: Collection[str] = (), **complete: Completer
) -> Callable[[Command], Command]:
    """The options of the arguments of a function, each under the name of its argument.

    Args:
        module: Its file in `warprock.api`, without the ending: `analyses/map`.
        name: Its name.
        only: Names of the arguments that the command takes; empty is all of them.
        **complete: What a shell completes an option with, by the name of its argument.
    """

    def add(command: Command) -> Command:
        function = read_function(module, name)
        taken = [each for each in function.arguments if not only or each.name in only]
        for argument in reversed(taken):
            text = _help(function, argument.text)
            command = _option(argument, text, complete.get(argument.name))(command)
        return command

    return add


def help_of(module: str, name: str, argument: str) -> str:
    """What the docstring of a function says of an argument, as the help of an option.

    Args:
        module: Its file in `warprock.api`, without the ending.
        name: Its name.
        argument: That of the argument.
    """
    function = read_function(module, name)
    return _help(function, function.told[argument])


def _help(function: Function, text: str) -> str:
    """A text of a docstring, with options in the place of arguments."""
    text = text.replace(" [-]", "").replace("; or several", "; repeat for each")
    for name in function.told:
        text = text.replace(f"`{name}`", _option_name(name))
    return text


def _option_name(argument: str) -> str:
    return "--" + argument.strip("_").replace("_", "-")


def _option(
    argument: Argument, text: str, complete: Completer | None
) -> Callable[[Command], Command]:
    """An option: () as a default takes it several times, an alias of a type is its placeholder."""
    default, several = argument.default, argument.default == ()
    kind = _TYPES.get(argument.kind, str) if several or default is None else type(default)
    known = {"str", *_TYPES}
    return click.option(
        argument.option,
        argument.name,
        multiple=several,
        **({"required": True} if argument.required else {"default": None if several else default}),
        show_default=not several and default is not None,
        type=kind,
        metavar=None if argument.kind in known else argument.kind.upper(),
        help=text,
        shell_complete=complete,
    )
