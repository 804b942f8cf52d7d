"""`sjdsl list`: lists the games in short, or everything that can be set in one of them."""

import json
from collections.abc import Callable, Sequence
from typing import Any

import click

from sjdsl.cli.describe import describe, outline
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.games_folder import OURS, by_release, game_problems, melting_pot_games


@click.command("list")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option("--json", "as_json", is_flag=True, help="Print everything as JSON.")
def command(games: tuple[str, ...], as_json: bool) -> int:
    """Lists the games in short, or all about the GAMEs named: bundled ones, those of installed packages, and `.sj` files.

    Each package with games has lines of its own. What is wrong with one of them is said at the end, and the exit status is then 1.
    """
    problems = [] if games else game_problems()
    if as_json and games:
        click.echo(_json([describe(name) for name in games]))
    elif as_json:
        click.echo(
            _json(
                [
                    described
                    for names in by_release().values()
                    for name in names
                    if (described := _tried(describe, name, problems)) is not None
                ]
            )
        )
    elif games:
        click.echo("\n\n".join(page(describe(name)) for name in games))
    else:
        for line in _groups(problems):
            click.echo(line)
        click.echo("\n`sjdsl list GAME` shows actions, parameters, sizes, metrics and kinds")
    for problem in problems:
        click.echo(f"error: {problem}", err=True)
    return int(bool(problems))


def _json(games: list[dict[str, Any]]) -> str:
    return json.dumps(games, indent=2, ensure_ascii=False)


def _tried(describe: Callable[[str], dict[str, Any]], name: str, problems: list[str]) -> dict[str, Any] | None:
    """Returns what is known of a game; None for one that does not compile, which is added to the problems."""
    try:
        return describe(name)
    except CompileError as error:
        count = f"{len(error.diagnostics)} error{'s' * (len(error.diagnostics) > 1)}"
        problems.append(f"the game `{name}` has {count}; `sjdsl check {name}` shows what to change")
        return None


def _groups(problems: list[str]) -> list[str]:
    """Returns the table of all games, with a line above those of each release; what does not compile is added to the problems."""
    own, *others = by_release().items()
    further = set(melting_pot_games())
    groups = {f"of {own[0]}": [name for name in own[1] if name.removeprefix(f"{OURS}:") not in further]}
    groups |= {f"of {own[0]}, further families of Melting Pot": [name for name in own[1] if name.removeprefix(f"{OURS}:") in further]}
    groups |= {f"of {release}": names for release, names in others}
    rows = {
        title: [(name, *_row(found)) for name in names if (found := _tried(outline, name, problems)) is not None]
        for title, names in groups.items()
    }
    head, *lines = align([("game", "title", "agents", "map", "actions", "variants"), *(row for found in rows.values() for row in found)])
    table, below = [head], iter(lines)
    for title, lines_below in rows.items():
        table += ["", title, *(next(below) for _ in lines_below)] if lines_below else []
    return table


def _row(game: dict[str, Any]) -> tuple[str, ...]:
    variants = ", ".join(v["name"] for v in game["variants"])
    return game["title"], str(game["agents"]), _map(game), str(len(game["actions"])), variants


def _map(game: dict[str, Any]) -> str:
    return f"{game['map']['rows']} x {game['map']['columns']}"


def _window(window: dict[str, Any]) -> str:
    sides = f"{window['ahead']} ahead, {window['behind']} behind, {window['left']} left, {window['right']} right"
    return sides + (f" when {window['when']}" if window.get("when") else "")


def page(game: dict[str, Any]) -> str:
    """Returns all about one game, as a person reads it."""
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
    kinds = [(k["name"], "; ".join(f"{name}: {_words(v)}" for name, v in k["fields"].items())) for k in game["kinds"]]
    lines += _section("kinds", kinds)
    for title in ("params", "sizes"):
        lines += _section(title, [(n["name"], n["unit"], *_default(n)) for n in game[title]])
    lines += _section("policies", [(p["name"], p["title"]) for p in game["policies"]])
    lines += _section("scenarios", [(s["name"], ", ".join(map(_slots, s["slots"])), s["title"]) for s in game["scenarios"]])
    lines += _section("variants", [(v["name"], v["title"]) for v in game["variants"]])
    return "\n".join(lines)


def _slots(slots: dict[str, Any]) -> str:
    return f"{slots['number']} {slots['policy'] or 'focal'}"


def _section(title: str, rows: Sequence[tuple[str, ...]]) -> list[str]:
    return [f"  {title}", *("    " + line for line in align(rows))] if rows else []


def _default(number: dict[str, Any]) -> tuple[str, str]:
    low, high = number["low"], number["high"]
    limits = "" if low is None and high is None else f"{_plain(low)} .. {_plain(high)}"
    return _plain(number["default"]), limits


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


def _words(values: str | list[str]) -> str:
    return values if isinstance(values, str) else ", ".join(values)


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Returns rows as lines with their columns under one another; a wide column does not push the others away."""
    widest = [min(48, max(len(cell) for cell in column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widest, strict=True)).rstrip() for row in rows]
