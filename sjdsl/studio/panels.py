"""The panels beside the board: rules, generated program, state, observations, reasons, checks."""

import re
from typing import Any

from sjdsl.compiler import compile_build, ir
from sjdsl.compiler.ir.queries import kind_named
from sjdsl.compiler.lower import token_planes
from sjdsl.doc import read_written, report, rule_sheet
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.observe import observe, visible_cells
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, World
from sjdsl.interpreter.step import action_mask
from sjdsl.properties import GameFamily, Verdict, verify_properties
from sjdsl.studio.counterexample import as_json
from sjdsl.studio.episode import Episode, metric_values
from sjdsl.studio.opened import Opened
from sjdsl.told import Window, message
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
    """Returns the lines of the generated module, each with the line of the game it comes from.

    The latter is null for a line that comes from none.
    """
    lines: list[list[Any]] = []
    game_line: int | None = None
    for line in compile_build(opened.build, opened.source).splitlines():
        # A comment with a line of the game is about all that follows in the phase.
        if comment := LINE.search(line):
            game_line = int(comment[1])
        elif not line.startswith("    ") or line.startswith("    return"):
            game_line = None
        lines.append([line, game_line])
    return {"lines": lines}


def state_panel(opened: Opened, world: World, cell: Cell | None) -> dict[str, Any]:
    """Returns the values of the world, of each agent and each mover, and of one cell."""
    game = opened.game
    world_values = [(f.name, say_value(world.fields[f.name], f.type)) for f in game.fields]
    agents = []
    for agent, position in enumerate(world.position):
        values = [("place", _place_text(position)), ("heading", HEADINGS[world.heading[agent]])]
        for field in game.agents.fields:
            values.append((field.name, say_value(world.agents[field.name][agent], field.type)))
        agents.append(values)
    movers: list[list[Any]] = []
    for mover in game.movers:
        herd = world.movers[mover.name]
        for number, position in enumerate(herd.position):
            values = [("place", _place_text(position))]
            for field in mover.fields:
                values.append((field.name, say_value(herd.fields[field.name][number], field.type)))
            movers.append([mover.name, number, values])
    return {
        "world": [("step", str(world.step)), *world_values],
        "agents": agents,
        "movers": movers,
        "cell": None if cell is None else _cell_values(game, world, cell),
    }


def _cell_values(game: ir.Game, world: World, cell: Cell) -> dict[str, Any]:
    """Returns the kind of a cell, its place, and the values of its fields in words."""
    board = board_of(game)
    kind = board.kind_of[cell]
    number = board.number[cell]
    values = [
        (field.name, say_value(world.cells[kind, field.name][number], field.type))
        for field in kind_named(game, kind).fields
    ]
    return {"kind": kind, "place": list(cell), "values": values}


def _place_text(cell: Cell | None) -> str:
    return "away" if cell is None else f"({cell.row}, {cell.col})"


def seen_panel(opened: Opened, world: World, agent: int) -> dict[str, Any]:
    """Returns the observation of one agent by plane, and as the message to a language model.

    A plane has `values`, row by row, and `labels`, the meaning of each number. `window` has the row
    and the column of each cell that the agent sees, by rows with its `heading` up, null for others;
    it is null for an agent that is away.
    """
    game = opened.game
    observation = observe(game, world)[agent]
    allowed = action_mask(game, world)[agent]
    trial = 0 if game.trials is None else int(world.fields["trial"])
    described = [
        {
            "name": plane.name,
            "encoding": plane.encoding,
            "labels": list(plane.labels),
            "values": observation[number].tolist(),
        }
        for number, plane in enumerate(planes(game))
    ]
    text = message(Window(game, token_planes(game)), observation, allowed, trial=trial)
    return {
        "agent": agent,
        "planes": described,
        "message": text,
        "heading": int(world.heading[agent]),
        "window": _seen_cells(game, world, agent),
    }


def _seen_cells(game: ir.Game, world: World, agent: int) -> list[list[list[int] | None]] | None:
    """Returns the cells that an agent sees by their places in its window."""
    position = world.position[agent]
    if position is None:
        return None
    window = game.window
    cols = window.left + 1 + window.right
    cells: list[list[list[int] | None]] = [
        [None] * cols for _ in range(window.ahead + 1 + window.behind)
    ]
    instance = Instance(board_of(game), world, names={"agent": agent})
    for row, col, cell in visible_cells(window, agent, position, instance):
        cells[row][col] = list(cell)
    return cells


def trace_panel(opened: Opened, moment: Moment) -> dict[str, Any]:
    """Returns what happened in the step that led to a moment.

    For each phase these are its rules with their lines, and for each rule its changes: in words,
    with their reasons, and with the cells that they concern, so that a page can show why a cell is
    as it is.
    """
    rules = Rules(opened.build.sources)
    board = board_of(opened.game)
    turns = []
    for turn in moment.turns:
        explainer = explainer_of(turn, board, rules)
        rules_of_turn = []
        for rule, effects in rules_with_effects(turn):
            span = None if rule is None else rule.origin
            is_in_text = span is not None and span.file == opened.source.name
            described = {
                "line": span.line if span is not None and is_in_text else None,
                "place": "" if rule is None else rules.place(rule),
                "text": "" if rule is None else rules.text(rule),
                "effects": [
                    _describe_effect(effect, moment.world, explainer) for effect in effects
                ],
            }
            rules_of_turn.append(described)
        if rules_of_turn:
            turns.append({"phase": turn.label, "rules": rules_of_turn})
    return {"step": moment.number, "turns": turns}


def _describe_effect(effect: Effect, world: World, explainer: Explainer) -> dict[str, Any]:
    """Returns one change in words, with its reasons and the cells that it concerns.

    These are the cell that changed, those between which somebody went, and the one where the agent
    or mover stands now.
    """
    owner = effect.owner
    position = where_is(owner, world) if isinstance(owner, int | Mover) else None
    concerned = (owner, effect.old, effect.new, position)
    cells = dict.fromkeys(cell for cell in concerned if isinstance(cell, Cell))
    return {
        "said": say_effect(effect, explainer.instance.board),
        "cells": [list(cell) for cell in cells],
        "because": [_describe_reason(reason) for reason in explainer.effect(effect)],
    }


def _describe_reason(reason: Reason) -> dict[str, Any]:
    """Returns a reason: a sentence, its random draw in words or "", and the reasons behind it."""
    return {
        "text": reason.text,
        "bits": reason.bits,
        "because": [_describe_reason(behind) for behind in reason.because],
    }


def curves_panel(episode: Episode) -> dict[str, Any]:
    """Returns the agents' returns and the metrics of the last step, at each moment so far."""
    return {
        "returns": episode.returns,
        "metrics": [metric_values(episode.game, moment.outcome) for moment in episode.moments],
    }


def diff_panel(opened: Opened) -> dict[str, Any]:
    """Returns what the chosen variants change in the game, as `sjdsl diff` prints it."""
    variants = opened.composition.chosen
    if not variants:
        return {"text": None}
    return {"text": report(read_written(opened.source), read_written(opened.source, variants))}


def checks_panel(opened: Opened) -> dict[str, Any]:
    """Returns the verdict on each check of the text, with its counterexample if there is one."""
    family = GameFamily(opened.source, opened.composition.chosen)
    results = verify_properties(family)
    verdicts = (*results.verdicts, *results.faults)
    return {"verdicts": [_describe_verdict(verdict, opened, family.own) for verdict in verdicts]}


def _describe_verdict(verdict: Verdict, opened: Opened, game: ir.Game) -> dict[str, Any]:
    """Returns a verdict; its line is None in another file. game: that of the counterexample."""
    return {
        "text": verdict.text,
        "line": verdict.line if verdict.file == opened.source.name else None,
        "status": verdict.status,
        "reason": verdict.reason,
        "untested": list(verdict.untested),
        "trace": list(verdict.trace),
        "scenario": None if verdict.scenario is None else as_json(verdict.scenario, game),
    }
