"""What stands beside the board: the rules, the generated program, the state, what an agent sees, why something happened."""

import re
from typing import Any

from sjdsl.compiler import compile_build, ir
from sjdsl.compiler.ir.queries import kind_named
from sjdsl.doc import read_written, report, rule_sheet
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, World
from sjdsl.properties import GameFamily, Verdict, verify_properties
from sjdsl.studio.counterexample import as_json
from sjdsl.studio.episode import Episode, measured
from sjdsl.studio.opened import Opened
from sjdsl.trace.effects import Effect
from sjdsl.trace.episode import Moment
from sjdsl.trace.lines import rules_with_effects
from sjdsl.trace.reasons import Explainer, Reason, explainer_of
from sjdsl.trace.rules import Rules
from sjdsl.trace.wording import say_effect, say_value

LINE = re.compile(r"# \S+\.sj:(\d+)$")


def rules_panel(opened: Opened) -> dict[str, Any]:
    """Returns the rule sheet, as Markdown."""
    return {"markdown": rule_sheet(read_written(opened.source, opened.composition.chosen))}


def python_panel(opened: Opened) -> dict[str, Any]:
    """Returns the generated module line by line, each with the line of the game that it comes from, or null."""
    lines: list[list[Any]] = []
    place: int | None = None
    for line in compile_build(opened.build, opened.source).splitlines():
        if found := LINE.search(line):
            place = int(found[1])
        elif not line.startswith("    ") or line.startswith(
            "    return"
        ):  # a comment is about all that follows, to the end of the phase
            place = None
        lines.append([line, place])
    return {"lines": lines}


def state_panel(opened: Opened, world: World, cell: Cell | None) -> dict[str, Any]:
    """Returns the values of the world, of each agent and each mover, and of one cell."""
    game = opened.game
    agents = [
        [("place", _place(world.position[a])), ("heading", HEADINGS[world.heading[a]])]
        for a in range(game.agents.number)
    ]
    for field in game.agents.fields:
        for agent, value in enumerate(world.agents[field.name]):
            agents[agent].append((field.name, say_value(value, field.type)))
    movers: list[list[Any]] = []
    for sort in game.movers:
        herd = world.movers[sort.name]
        for number, at in enumerate(herd.position):
            values = [(f.name, say_value(herd.fields[f.name][number], f.type)) for f in sort.fields]
            movers.append([sort.name, number, [("place", _place(at)), *values]])
    shown = None
    if cell is not None:
        board = board_of(game)
        kind, number = board.kind_of[cell], board.number[cell]
        values = [
            (f.name, say_value(world.cells[kind, f.name][number], f.type))
            for f in kind_named(game, kind).fields
        ]
        shown = {"kind": kind, "place": list(cell), "values": values}
    return {
        "world": [("step", str(world.step))]
        + [(f.name, say_value(world.fields[f.name], f.type)) for f in game.fields],
        "agents": agents,
        "movers": movers,
        "cell": shown,
    }


def _place(at: Cell | None) -> str:
    return "away" if at is None else f"({at.row}, {at.col})"


def seen_panel(opened: Opened, world: World, agent: int) -> dict[str, Any]:
    """Returns the observation of one agent, plane by plane: `values` row by row, and what each number stands for."""
    picture = observe(opened.game, world)[agent]
    return {
        "agent": agent,
        "planes": [
            {
                "name": plane.name,
                "encoding": plane.encoding,
                "labels": list(plane.labels),
                "values": picture[number].tolist(),
            }
            for number, plane in enumerate(planes(opened.game))
        ],
    }


def trace_panel(opened: Opened, moment: Moment) -> dict[str, Any]:
    """Returns what happened in the step that led to a moment.

    For each phase its rules with their lines, and for each rule what it changed: in words, with the reasons, and which cells that concerns,
    so that a page can ask why something on one cell is as it is.
    """
    rules, board = Rules(opened.build.sources), board_of(opened.game)
    turns = []
    for turn in moment.turns:
        found, explainer = [], explainer_of(turn, board, rules)
        for rule, effects in rules_with_effects(turn):
            span = None if rule is None else rule.origin
            found.append(
                {
                    "line": None if span is None or span.file != opened.source.name else span.line,
                    "place": "" if rule is None else rules.place(rule),
                    "text": "" if rule is None else rules.text(rule),
                    "effects": [_effect(effect, moment.world, explainer) for effect in effects],
                }
            )
        if found:
            turns.append({"phase": turn.label, "rules": found})
    return {"step": moment.number, "turns": turns}


def _effect(effect: Effect, world: World, explainer: Explainer) -> dict[str, Any]:
    """Returns one change. cells: its own, those between which somebody went, and the one where its agent or mover stands now."""
    owner = effect.owner
    stands = where_is(owner, world) if isinstance(owner, int | Mover) else None
    concerned = (owner, effect.old, effect.new, stands)
    return {
        "said": say_effect(effect, explainer.here.board),
        "cells": [
            list(cell)
            for cell in dict.fromkeys(place for place in concerned if isinstance(place, Cell))
        ],
        "because": [_reason(reason) for reason in explainer.effect(effect)],
    }


def _reason(reason: Reason) -> dict[str, Any]:
    """Returns why something happened: a sentence, its random bits in words, or nothing, and the reasons behind it."""
    return {
        "text": reason.text,
        "bits": reason.bits,
        "because": [_reason(behind) for behind in reason.because],
    }


def curves_panel(episode: Episode) -> dict[str, Any]:
    """Returns the returns of the agents at each moment so far, and the metrics of the step that led to it."""
    return {
        "returns": episode.returns,
        "metrics": [measured(episode.game, moment.outcome) for moment in episode.moments],
    }


def diff_panel(opened: Opened) -> dict[str, Any]:
    """Returns what the chosen variant changes in the game of the file, as `sjdsl diff` has it."""
    if not opened.composition.chosen:
        return {"text": None}
    plain, chosen = (
        read_written(opened.source),
        read_written(opened.source, opened.composition.chosen),
    )
    return {"text": report(plain, chosen)}


def checks_panel(opened: Opened) -> dict[str, Any]:
    """Returns the verdict on each check of the game as its text has it, with a counterexample in words and as what leads to it."""
    family = GameFamily(opened.source, opened.composition.chosen)
    found = verify_properties(family)
    return {
        "verdicts": [
            _verdict(verdict, opened, family.own) for verdict in (*found.verdicts, *found.faults)
        ]
    }


def _verdict(verdict: Verdict, opened: Opened, game: ir.Game) -> dict[str, Any]:
    return {
        "text": verdict.text,
        "line": verdict.line if verdict.file == opened.source.name else None,
        "status": verdict.status,
        "reason": verdict.reason,
        "untested": list(verdict.untested),
        "trace": list(verdict.trace),
        "scenario": None if verdict.scenario is None else as_json(verdict.scenario, game),
    }
