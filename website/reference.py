"""The pages of the reference that are made from the code: the public names of Python, the commands, and the messages of the compiler."""

from collections.abc import Iterator
from pathlib import Path

import click

from sjdsl.cli import COMMANDS
from sjdsl.cli import commands as group
from website.chapters import raised
from website.links import plain_fences

FOLDER = "reference"
MODULES = {  # what has names that users import -> what the page is about
    "sjdsl": "Environments",
    "sjdsl.trainers": "Training",
    "sjdsl.experiments": "Experiments",
    "sjdsl.sweeps": "Sweeps",
    "sjdsl.results": "Results",
    "sjdsl.render": "Pictures",
    "sjdsl.replay": "Recorded episodes",
    "sjdsl.testing": "Scenes",
    "sjdsl.trace": "Traces",
    "sjdsl.properties": "Checks",
    "sjdsl.doc": "Rules on a page",
    "sjdsl.told": "What players are told",
    "sjdsl.models": "Language models",
    "sjdsl.bench": "Benchmarks",
    "sjdsl.interop.jaxmarl": "JaxMARL",
    "sjdsl.interop.socialjax": "SocialJax",
    "sjdsl.interop.pettingzoo": "PettingZoo",
    "sjdsl.interop.gymnasium": "Gymnasium",
    "sjdsl.interop.stable_baselines3": "Stable-Baselines3",
    "sjdsl.interop.dm_env": "dm_env",
}
INDEX = """# Reference

* [Commands](commands.md): every command of `sjdsl` with its options.
* [Messages](messages.md): every error and warning of the compiler, with what to write instead.
* Python, by module:

"""


def reference_pages(root: Path) -> dict[str, str]:
    """Returns all pages of the reference, by their place on the site."""
    listed = "".join(
        f"    * [`{module}`]({module}.md): {_first_line(root, module)}\n" for module in MODULES
    )
    modules = {f"{FOLDER}/{module}.md": _module(module) for module in MODULES}
    return {
        f"{FOLDER}/index.md": INDEX + listed,
        f"{FOLDER}/commands.md": commands(),
        f"{FOLDER}/messages.md": messages(root),
        **modules,
    }


def _module(module: str) -> str:
    return f"# `{module}`\n\n::: {module}\n"


def _first_line(root: Path, module: str) -> str:
    """Returns the first line of a module, whose packages need not be installed."""
    path = root.joinpath(*module.split(".")) if module != "sjdsl.trainers" else root / "trainers"
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return file.read_text("utf-8").split('"""')[1].split("\n")[0]


def commands() -> str:
    """Returns the page of all commands: what `--help` prints."""
    parent = click.Context(group, info_name="sjdsl")
    return "\n".join(
        ["# Commands", "", *(line for name in COMMANDS for line in _command(parent, name))]
    )


def _command(parent: click.Context, name: str) -> Iterator[str]:
    command = group.get_command(parent, name)
    if command is None:
        raise LookupError(f"there is no command `{name}`")
    context = click.Context(
        command, info_name=name, parent=parent, terminal_width=100, max_content_width=100
    )
    yield from (
        f"## `sjdsl {name}`",
        "",
        COMMANDS[name],
        "",
        "``` { .text }",
        command.get_help(context).replace("`", ""),  # nothing on the page would take them away
        "```",
        "",
    )


def messages(root: Path) -> str:
    """Returns the page of all messages: what `sjdsl explain` prints."""
    folder = root / "sjdsl" / "compiler" / "diagnostics" / "explain"
    texts = (
        plain_fences(raised(path.read_text("utf-8"), -1)).rstrip()
        for path in sorted(folder.glob("*.md"))
    )
    head = "# Messages\n\nEvery error and warning has a code; `sjdsl explain SJ204` prints the same text.\n\n"
    return head + "\n\n".join(texts) + "\n"
