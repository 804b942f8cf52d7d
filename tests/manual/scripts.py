"""The `result` blocks of the manual: read, performed on a play, compared.

A block is a list of lines; the manual explains them under "How to read the examples".
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import HEADINGS
from sjdsl.interpreter.step import action_mask
from sjdsl.library.action_names import split_actions
from sjdsl.testing.paths import find_field, read_field

from .blocks import Block
from .plays import Play

_TEXT = re.compile(r'"([^"]*)"')
_COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
_STEP = re.compile(r"(?:(\d+) steps|step)\b\s*(.*)")
_MEAN = re.compile(r"mean (.+?) = (.+) within ([\d.]+)")
_SHARE = re.compile(r"share (.+?) is (\w+) = (.+) within ([\d.]+)")
_COUNT = re.compile(r"count (.+?) is (\w+) = (\d+)")
_EQUAL = re.compile(r"(equal|unequal) (\w+): (.+)")
_SEES = re.compile(
    r"agent (\d+) sees (.+?)(?: (\d+) (ahead|behind))?(?: (\d+) (left|right))? = (.+)"
)
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
        value = (
            text
            if declared.type.kind == "word"
            else np.float32(text)
            if declared.type.kind == "real"
            else int(text)
        )
        values[name] = _replaced(
            values.get(name, declared.value),
            [by.place_of(w) for by, w in zip(declared.type.indexed_by, words, strict=True)],
            value,
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
            assert len(wanted) == len(means), (
                f"line {line}: {len(means)} values, {len(wanted)} are written"
            )
            assert np.all(np.abs(means - wanted) <= allowance), (
                f"line {line}: the mean is {means.tolist()}, not {wanted}"
            )


def perform(
    script: Script, play: Play, other: Callable[[str, int, int], Play], most_runs: int = 1000
) -> None:
    """Plays a script and compares; means over the runs only if all of them are played.

    other: (name of an example, its seed, steps of rest) -> the play of that example, for `equal`.
    """
    gathered = Gathered()
    for run in range(script.seed, script.seed + min(script.runs, most_runs)):
        play.reset((run, 0))
        steps = 0
        for line, text in script.lines:
            if step := _STEP.fullmatch(text):
                for _ in range(int(step.group(1) or 1)):
                    steps += 1
                    play.step(_actions(play, step.group(2), line), (run, steps))
            elif text.startswith("before "):
                play.arrange(_TEXT.findall(text))
            elif equal := _EQUAL.fullmatch(text):
                there, path = other(equal.group(2), run, steps), equal.group(3)
                same = values_of(play, path) == values_of(there, path)
                assert same == (equal.group(1) == "equal"), (
                    f"line {line}: {path} {values_of(play, path)}"
                )
            else:
                _check(text, line, play, gathered)
    if script.runs <= most_runs:
        gathered.check()


def _actions(play: Play, text: str, line: int) -> list[int]:
    """Returns the numbers of actions; the name of a policy stands for what it chooses."""
    names, policies = (
        split_actions(text) if text else [],
        {policy.name for policy in play.game.policies},
    )
    assert len(names) in (0, play.board.agents), f"line {line}: an action for each agent, or none"
    names = [
        play.chosen(name)[agent] if name in policies else name
        for agent, name in enumerate(names or ["stay"] * play.board.agents)
    ]
    return [play.game.agents.actions.index(name) for name in names]


def _check(text: str, line: int, play: Play, gathered: Gathered) -> None:
    """Compares one line with the play, or remembers it for the mean over the runs."""
    if text.startswith("after "):
        drawn = play.drawn()
        assert drawn == _TEXT.findall(text), f"line {line}: the map is " + " ".join(
            f'"{row}"' for row in drawn
        )
    elif mean := _MEAN.fullmatch(text):
        values = [float(v) for v in values_of(play, mean.group(1))]
        gathered.add(
            line, [float(v) for v in mean.group(2).split(",")], float(mean.group(3)), values
        )
    elif share := _SHARE.fullmatch(text):
        values = values_of(play, share.group(1))
        part = sum(_text(v) == share.group(2) for v in values) / len(values)
        gathered.add(line, [float(share.group(3))], float(share.group(4)), [part])
    elif count := _COUNT.fullmatch(text):
        found = sum(_text(v) == count.group(2) for v in values_of(play, count.group(1)))
        assert found == int(count.group(3)), f"line {line}: {found}"
    elif sees := _SEES.fullmatch(text):
        _check_seen(sees, line, play)
    elif labels := _LABELS.fullmatch(text):
        found = list(plane_named(play.game, labels.group(1))[1])
        assert found == [x.strip() for x in labels.group(2).split("|")], (
            f"line {line}: {' | '.join(found)}"
        )
    else:
        path, equals, wanted = text.partition(" = ")
        assert equals, f"line {line}: not understood: {text}"
        _compare(line, [_text(v) for v in values_of(play, path)], wanted)


def plane_named(game: ir.Game, name: str) -> tuple[int, tuple[str, ...]]:
    """Returns the number and labels of a plane of an observation."""
    return next(
        (number, plane.labels) for number, plane in enumerate(planes(game)) if plane.name == name
    )


def _compare(line: int, values: list[str], wanted: str) -> None:
    listed = [w.strip() for w in re.split(r",(?![^{]*\})", wanted)]
    if listed[0].startswith("all "):
        listed = [listed[0].removeprefix("all ")] * len(values)
    same = len(values) == len(listed) and all(
        _same(v, w) for v, w in zip(values, listed, strict=True)
    )
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
        case set():
            return "{" + ", ".join(map(str, sorted(value))) + "}"
        case float():
            return f"{value:.9g}"
        case _:
            return str(value)


def values_of(play: Play, path: str) -> list[Any]:
    """Returns what a line's left side stands for: one value, one for each agent, or one for each cell."""
    game, world, (word, _, rest) = play.game, play.world, path.strip().partition(" ")
    match word:
        case "reward":
            return [float(reward) for reward in play.outcome.reward]
        case "event":
            return np.ravel(_counts(play)[rest]).tolist()
        case "metric":
            return [float(play.outcome.measures[rest])]
        case "allowed":
            return [mask[game.agents.actions.index(rest)] for mask in action_mask(game, world)]
        case "chosen":
            return list(play.chosen(rest))
        case "steps":
            return [world.step]
        case "terminated":
            return [play.outcome.terminated]
        case "truncated":
            return [play.outcome.truncated and not play.outcome.terminated]
        case "planes":
            return [plane.name for plane in planes(game)]
    owner, _, member = path.strip().rpartition(".")
    herd: Any = world if owner == "agent" else world.movers.get(owner)
    if herd is not None and member in ("row", "col"):
        return ["-" if p is None else getattr(p, member) for p in herd.position]
    if herd is not None and member == "away":
        return [p is None for p in herd.position]
    if owner == "agent" and member == "ticks":
        return [away.ticks if away else 0 for away in world.away]
    if owner == "agent" and member == "heading":
        return [HEADINGS[heading] for heading in world.heading]
    values = read_field(find_field(game, path), world)
    return values if owner else _listed(values)


def _counts(play: Play) -> dict[str, Any]:
    """Returns the counts of events by name, of a row entry by entry."""
    return {
        name: np.asarray(play.outcome.events[event.name])[(...,) if word is None else (..., number)]
        for event in play.game.events
        for number, (word, name) in enumerate(counts_of(event))
    }


def _listed(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else [value]


def _check_seen(seen: re.Match[str], line: int, play: Play) -> None:
    agent, plane, rows, up, columns, side, wanted = seen.groups()
    number, labels = plane_named(play.game, plane)
    row = play.game.window.ahead + (int(rows) if up == "behind" else -int(rows or 0))
    column = play.game.window.left + (int(columns) if side == "right" else -int(columns or 0))
    value = int(play.seen()[int(agent), number, row, column])
    if plane == "marks":
        shown = (
            " and ".join(label for bit, label in enumerate(labels) if value >> bit & 1) or "none"
        )
    else:
        shown = labels[value] if labels else str(value)
    assert shown == wanted, f"line {line}: {shown}"
