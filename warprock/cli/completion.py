"""Shell completion: the command `completion`, and what may be typed where.

Nothing here is imported by the completers until a shell asks for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import click
from click.shell_completion import CompletionItem, get_completion_class

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]

SHELLS = ("bash", "zsh", "fish")


def _starting(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


def cases(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of shipped cases, and files."""
    from warprock.case.text import case_names

    return [*_starting(case_names(), incomplete), CompletionItem(incomplete, type="file")]


def engines(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of engines."""
    from warprock.settings.engines import SETTINGS

    return _starting(SETTINGS, incomplete)


def compared(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of engines and of programs of others."""
    from warprock.settings.engines import SETTINGS
    from warprock.settings.programs import PEER_SETTINGS

    return _starting([*SETTINGS, "oracle", *PEER_SETTINGS], incomplete)


def overrides(
    _ctx: click.Context, _param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Keys of a case, up to the equals sign."""
    from warprock.case.keys import KEYS
    from warprock.settings.engines import SETTINGS, declared_settings

    names = [key.replace("block.N.", "block.1.") for key in KEYS]
    names += [
        f"engines.{engine}.{name}"
        for engine, settings in SETTINGS.items()
        for name in declared_settings(settings)
    ]
    return _starting((f"{name}=" for name in names), incomplete)


def tables(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Tables and keys of a case file."""
    from warprock.case.reference import find_sections

    keys = [row.key for section in find_sections(None) for row in section.keys]
    return _starting(dict.fromkeys((*(key.rpartition(".")[0] for key in keys), *keys)), incomplete)


def kinds(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Kinds of templates."""
    from warprock.case.text import template_kinds

    return _starting(template_kinds(), incomplete)


def bodies(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Bodies that a case may begin with."""
    from warprock.case.template import bodies as known

    return _starting(known(), incomplete)


def targets(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """What `reproduce` takes."""
    from warprock.paper.reproduce import TARGETS

    return _starting(TARGETS, incomplete)


def records(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of shipped records, and files."""
    from warprock.recordings import record_names

    return [*_starting(record_names(), incomplete), CompletionItem(incomplete, type="file")]


def hazards(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of shipped hazard curves, and files."""
    from warprock.analysis.hazard_files import hazard_names

    return [*_starting(hazard_names(), incomplete), CompletionItem(incomplete, type="file")]


def files(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Files."""
    return [CompletionItem(incomplete, type="file")]


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> None:
    """Print the script by which a SHELL completes commands, cases, engines and keys.

    For the shell at hand: eval "$(warprock completion bash)"; for every new one: the same line in
    ~/.bashrc (zsh: ~/.zshrc). For fish: warprock completion fish >
    ~/.config/fish/completions/warprock.fish.
    """
    made = get_completion_class(shell)
    assert made is not None
    click.echo(made(ctx.find_root().command, {}, "warprock", "_WARPROCK_COMPLETE").source())


COMMANDS = (completion,)
