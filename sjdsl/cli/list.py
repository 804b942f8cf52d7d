"""`sjdsl list`: lists the games in short, or everything that can be set in one of them."""

import json
from collections.abc import Callable, Sequence
from textwrap import wrap
from typing import Any

import click

from sjdsl.cli.describe import describe, outline
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.games_folder import OURS, by_release, game_problems, melting_pot_games

WIDTH = 80  # columns of a terminal


@click.command("list")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def command(games: tuple[str, ...], as_json: bool) -> int:
    """Lists all games in short, or everything about GAMEs: bundled ones, those of installed packages, and `.sj` files.

    Each package with games has a section of its own. Games with errors are reported at the end, and the exit status is then 1.
    """
    problems = [] if games else game_problems()
    if as_json:
        names = games or [name for names in by_release().values() for name in names]
        described = [describe(name) if games else _tried(describe, name, problems) for name in names]
        click.echo(json.dumps([game for game in described if game is not None], indent=2, ensure_ascii=False))
    elif games:
        click.echo("\n\n".join(page(describe(name)) for name in games))
    else:
        for line in _groups(problems):
            click.echo(line)
        click.echo("\n`sjdsl list GAME` shows actions, parameters, sizes, metrics and kinds")
    for problem in problems:
        click.echo(f"error: {problem}", err=True)
    return int(bool(problems))


def _tried(describe: Callable[[str], dict[str, Any]], name: str, problems: list[str]) -> dict[str, Any] | None:
    """Returns the description of a game; None for one that doesn't compile, which is added to the problems."""
    try:
        return describe(name)
    except CompileError as error:
        count = f"{len(error.diagnostics)} error{'s' * (len(error.diagnostics) > 1)}"
        problems.append(f"the game `{name}` has {count}; `sjdsl check {name}` shows what to change")
        return None


def _groups(problems: list[str]) -> list[str]:
    """Returns the table of all games, with a heading for each release, no line wider than a terminal.

    Games that don't compile are added to the problems.
    """
    own, *others = by_release().items()
    further = set(melting_pot_games())
    groups = {f"of {own[0]}": [name for name in own[1] if name.removeprefix(f"{OURS}:") not in further]}
    groups |= {f"of {own[0]}, further families of Melting Pot": [name for name in own[1] if name.removeprefix(f"{OURS}:") in further]}
    groups |= {f"of {release}": names for release, names in others}
    rows: dict[str, list[tuple[str, ...]]] = {title: [] for title in groups}
    variants: list[list[str]] = []  # of each game, below its row
    for title, names in groups.items():
        for name in names:
            game = _tried(outline, name, problems)
            if game is not None:
                rows[title].append((name, str(game["agents"]), _map(game), str(len(game["actions"]))))
                named = ", ".join(v["name"] for v in game["variants"])
                variants.append(wrap(named, WIDTH, initial_indent="    variants ", subsequent_indent=" " * 13))
    head, *lines = align([("game", "agents", "map", "actions"), *(row for found in rows.values() for row in found)])
    table, below = [head], zip(lines, variants, strict=True)
    for title, found in rows.items():
        table += ["", title] if found else []
        for _ in found:
            line, own_variants = next(below)
            table += [line, *own_variants]
    return table


def _map(game: dict[str, Any]) -> str:
    return f"{game['map']['rows']} x {game['map']['columns']}"


def _window(window: dict[str, Any]) -> str:
    sides = f"{window['ahead']} ahead, {window['behind']} behind, {window['left']} left, {window['right']} right"
    return sides + (f" when {window['when']}" if window.get("when") else "")


def page(game: dict[str, Any]) -> str:
    """Returns everything about a game, as text."""
    view = "; ".join(map(_window, game.get("windows", [game["window"]])))
    facts = [
        ("file", game["file"]),
        *([("from", game["from"])] if game["from"] else []),
        ("agents", str(game["agents"])),
        ("map", _map(game)),
        ("episode", f"{game['episode']} steps"),
        ("window", view),
        ("actions", ", ".join(game["actions"])),
        ("metrics", ", ".join(map(_metric, game["metrics"]))),
    ]
    facts += [(key.replace("_", " "), text) for key, text in game["about"].items()]
    facts += [("cite", cite) for cite in game["cites"]]
    lines = [f"{game['game']}: {game['title']}", *("  " + line for line in align(facts))]

    def fields(kind: dict[str, Any]) -> str:
        return "; ".join(f"{name}: {words if isinstance(words, str) else ', '.join(words)}" for name, words in kind["fields"].items())

    def number(n: dict[str, Any]) -> tuple[str, ...]:
        limits = "" if n["low"] is None and n["high"] is None else f"{_plain(n['low'])} .. {_plain(n['high'])}"
        return n["name"], n["unit"], _plain(n["default"]), limits

    def slots(scenario: dict[str, Any]) -> str:
        return ", ".join(f"{part['number']} {part['policy'] or 'focal'}" for part in scenario["slots"])

    sections: dict[str, list[tuple[str, ...]]] = {
        "kinds": [(k["name"], fields(k)) for k in game["kinds"]],
        "params": list(map(number, game["params"])),
        "sizes": list(map(number, game["sizes"])),
        "policies": [(p["name"], p["title"]) for p in game["policies"]],
        "scenarios": [(s["name"], slots(s), s["title"]) for s in game["scenarios"]],
        "variants": [(v["name"], v["title"]) for v in game["variants"]],
    }
    for title, rows in sections.items():
        lines += [f"  {title}", *("    " + line for line in align(rows))] if rows else []
    return "\n".join(lines)


def _plain(value: Any) -> str:
    match value:
        case None:
            return ""
        case dict():
            return "{ " + ", ".join(f"{word}: {_plain(v)}" for word, v in value.items()) + " }"
        case float():
            return f"{value:g}"
        case _:
            return str(value)


def _metric(metric: dict[str, Any]) -> str:
    by = f" by {{ {', '.join(metric['by'])} }}" if metric.get("by") else ""
    return f"{metric['sort']} {metric['name']}{by}"


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Returns rows as lines with aligned columns; a very wide cell doesn't push the next column away."""
    widest = [min(48, max(len(cell) for cell in column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widest, strict=True)).rstrip() for row in rows]
