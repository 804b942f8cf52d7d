"""The `result` blocks of the manual: read, performed on a play, compared.

A block is a list of lines; the manual explains them under "How to read the examples".
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sjdsl.action_names import split_actions
from sjdsl.compiler import ir

from . import pictures
from .blocks import Block
from .plays import Play, View, plane_names

_TEXT = re.compile(r'"([^"]*)"')
_COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
_STEP = re.compile(r"(?:(\d+) steps|step)\b\s*(.*)")
_MEAN = re.compile(r"mean (.+?) = (.+) within ([\d.]+)")
_SHARE = re.compile(r"share (.+?) is (\w+) = (.+) within ([\d.]+)")
_COUNT = re.compile(r"count (.+?) is (\w+) = (\d+)")
_EQUAL = re.compile(r"(equal|unequal) (\w+): (.+)")
_SEES = re.compile(r"agent (\d+) sees (.+?)(?: (\d+) (ahead|behind))?(?: (\d+) (left|right))? = (.+)")
_LABELS = re.compile(r"labels (.+?) = (.+)")


@dataclass(frozen=True)
class Script:
    """One `result` block. lines: (its line of the manual, text), a picture's rows joined to the line they begin on."""

    lines: tuple[tuple[int, str], ...]
    seed: int
    runs: int
    variants: tuple[str, ...]
    params: dict[str, str] = field(default_factory=dict)


def read_script(block: Block) -> Script:
    """Returns a block with the lines that concern the whole run taken out."""
    lines: list[tuple[int, str]] = []
    seed, runs, variants, params = 0, 1, (), {}
    for number, raw in enumerate(block.text.splitlines(), block.line):
        text = _COMMENT.sub(r"\1", raw).strip()
        word, _, rest = text.partition(" ")
        if text.startswith('"'):
            lines[-1] = (lines[-1][0], f"{lines[-1][1]} {text}")
        elif word == "seed":
            seed = int(rest)
        elif word == "runs":
            runs = int(rest)
        elif word == "variant":
            variants = tuple(rest.split("+"))
        elif word == "param":
            name, _, value = rest.partition(" = ")
            params[name] = value
        elif text:
            lines.append((number, text))
    return Script(tuple(lines), seed, runs, variants, params)


def given_params(game: ir.Game, given: dict[str, str]) -> dict[str, Any]:
    """Returns the parameters a script changes, whole tables nested as the state keeps them."""
    values: dict[str, Any] = {}
    for path, text in given.items():
        name, *words = re.findall(r"\w+", path)
        declared = next(p for p in game.params if p.name == name)
        value = text if declared.type.kind == "word" else np.float32(text) if declared.type.kind == "real" else int(text)
        values[name] = _replaced(
            values.get(name, declared.value), [by.place_of(w) for by, w in zip(declared.type.by, words, strict=True)], value
        )
    return values


def _replaced(whole: Any, path: list[int], value: Any) -> Any:
    if not path:
        return value
    first, *rest = path
    return (*whole[:first], _replaced(whole[first], rest, value), *whole[first + 1 :])


@dataclass
class Gathered:
    """What `mean` and `share` lines have seen over the runs: line of the manual -> (wanted, allowance, seen)."""

    seen: dict[int, tuple[list[float], float, list[list[float]]]] = field(default_factory=dict)

    def add(self, line: int, wanted: list[float], allowance: float, values: list[float]) -> None:
        self.seen.setdefault(line, (wanted, allowance, []))[2].append(values)

    def check(self) -> None:
        for line, (wanted, allowance, seen) in self.seen.items():
            means = np.mean(np.array(seen, float), axis=0)
            assert len(wanted) == len(means), f"line {line}: {len(means)} values, {len(wanted)} are written"
            assert np.all(np.abs(means - wanted) <= allowance), f"line {line}: the mean is {means.tolist()}, not {wanted}"


def perform(script: Script, game: ir.Game, play: Play, other: Callable[[str, int, int], View], most_runs: int = 1000) -> None:
    """Plays a script and compares; means over the runs only if all of them are played.

    other: (name of an example, its seed, steps of rest) -> the view of that example, for `equal`.
    """
    gathered = Gathered()
    for run in range(script.seed, script.seed + min(script.runs, most_runs)):
        view = play.reset((run, 0))
        steps = 0
        for line, text in script.lines:
            if step := _STEP.fullmatch(text):
                for _ in range(int(step.group(1) or 1)):
                    steps += 1
                    view = play.step(_actions(game, view, step.group(2), line), (run, steps))
            elif text.startswith("before "):
                view = play.arrange(pictures.read(game, _TEXT.findall(text), view))
            elif equal := _EQUAL.fullmatch(text):
                there, path = other(equal.group(2), run, steps), equal.group(3)
                same = values_of(game, view, path) == values_of(game, there, path)
                assert same == (equal.group(1) == "equal"), f"line {line}: {path} {values_of(game, view, path)}"
            else:
                _check(text, line, game, view, gathered)
    if script.runs <= most_runs:
        gathered.check()


def _actions(game: ir.Game, view: View, text: str, line: int) -> list[int]:
    """Returns the numbers of actions; the name of a policy stands for what it chooses."""
    names = split_actions(text) if text else []
    assert len(names) in (0, game.agents.number), f"line {line}: an action for each agent, or none"
    names = names or ["stay"] * game.agents.number
    chosen = view.chosen or {}
    return [game.agents.actions.index(chosen[name][agent] if name in chosen else name) for agent, name in enumerate(names)]


def _check(text: str, line: int, game: ir.Game, view: View, gathered: Gathered) -> None:
    """Compares one line with the view, or remembers it for the mean over the runs."""
    if text.startswith("after "):
        drawn = pictures.draw(game, view)
        assert drawn == _TEXT.findall(text), f"line {line}: the map is " + " ".join(f'"{row}"' for row in drawn)
    elif mean := _MEAN.fullmatch(text):
        values = [float(v) for v in values_of(game, view, mean.group(1))]
        gathered.add(line, [float(v) for v in mean.group(2).split(",")], float(mean.group(3)), values)
    elif share := _SHARE.fullmatch(text):
        values = values_of(game, view, share.group(1))
        part = sum(_text(v) == share.group(2) for v in values) / len(values)
        gathered.add(line, [float(share.group(3))], float(share.group(4)), [part])
    elif count := _COUNT.fullmatch(text):
        found = sum(_text(v) == count.group(2) for v in values_of(game, view, count.group(1)))
        assert found == int(count.group(3)), f"line {line}: {found}"
    elif sees := _SEES.fullmatch(text):
        _check_seen(sees, line, game, view)
    elif labels := _LABELS.fullmatch(text):
        found = list(plane_names(game)[labels.group(1)][1])
        assert found == [x.strip() for x in labels.group(2).split("|")], f"line {line}: {' | '.join(found)}"
    else:
        path, equals, wanted = text.partition(" = ")
        assert equals, f"line {line}: not understood: {text}"
        values = values_of(game, view, path)
        _compare(line, [_text(v) for v in values], wanted)


def _compare(line: int, values: list[str], wanted: str) -> None:
    listed = [w.strip() for w in re.split(r",(?![^{]*\})", wanted)]
    if listed[0].startswith("all "):
        listed = [listed[0].removeprefix("all ")] * len(values)
    same = len(values) == len(listed) and all(_same(v, w) for v, w in zip(values, listed, strict=True))
    assert same, f"line {line}: {', '.join(values)} (written: {wanted})"


def _same(value: str, wanted: str) -> bool:
    if wanted == "-":
        return True
    try:
        return abs(float(value) - float(wanted)) <= 1e-6 * max(1.0, abs(float(wanted)))
    except ValueError:
        return value == wanted


def _text(value: Any) -> str:
    """Returns a value as the manual writes it."""
    match value:
        case None:
            return "nobody"
        case bool():
            return "yes" if value else "no"
        case frozenset():
            return "{" + ", ".join(map(str, sorted(value))) + "}"
        case float():
            return f"{value:.9g}"
        case _:
            return str(value)


def values_of(game: ir.Game, view: View, path: str) -> list[Any]:
    """Returns what a line's left side stands for: one value, one for each agent, or one for each cell."""
    word, _, rest = path.strip().partition(" ")
    match word:
        case "reward":
            return view.reward
        case "event":
            return _listed(view.events[rest])
        case "metric":
            return [view.metrics[rest]]
        case "allowed":
            return [mask[game.agents.actions.index(rest)] for mask in view.allowed]
        case "chosen":
            assert view.chosen is not None
            return list(view.chosen[rest])
        case "steps" | "truncated" | "terminated":
            return [getattr(view, word)]
        case "planes":
            return list(plane_names(game))
    name, *keys = re.findall(r"[\w.]+", path)
    owner, _, member = name.rpartition(".")
    places = {"agent": view.places, **view.herds}.get(owner, [])
    if places and member in ("row", "col"):
        return ["-" if p is None else p[member == "col"] for p in places]
    if places and member == "away":
        return [p is None for p in places]
    if owner == "agent" and member == "ticks":
        return view.away
    if owner == "agent" and member == "heading":
        return list(view.heading)
    if owner:
        values = view.agents[member] if owner == "agent" else view.cells[owner, member]
        return [_entry(game, owner, member, v, keys) for v in values]
    return _listed(_entry(game, "", member, view.world[member], keys))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _entry(game: ir.Game, owner: str, name: str, value: Any, keys: list[str]) -> Any:
    if not keys:
        return value
    fields = {"": game.fields, "agent": game.agents.fields}.get(owner) or next(
        k for k in (*game.kinds, *game.movers) if k.name == owner
    ).fields
    level = next(f for f in fields if f.name == name).type.by[0]
    return value[level.keys.index(keys[0])]


def _check_seen(seen: re.Match[str], line: int, game: ir.Game, view: View) -> None:
    agent, plane, rows, up, columns, side, wanted = seen.groups()
    number, labels = plane_names(game)[plane]
    row = game.window.ahead + (int(rows) if up == "behind" else -int(rows or 0))
    column = game.window.left + (int(columns) if side == "right" else -int(columns or 0))
    value = int(view.observation[int(agent), number, row, column])
    if plane == "marks":
        shown = " and ".join(label for bit, label in enumerate(labels) if value >> bit & 1) or "none"
    else:
        shown = labels[value] if labels else str(value)
    assert shown == wanted, f"line {line}: {shown}"
