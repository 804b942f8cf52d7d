"""The text that a player is told before an episode: all rules of a game, in English."""

from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from typing import Any, TypeVar, assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables, renamed
from sjdsl.compiler.ir.queries import (
    all_fields,
    beginning_phases,
    blocks_always,
    body_types,
    can_be_away,
    task_space,
)
from sjdsl.compiler.lower.cell_appearance import token_planes
from sjdsl.doc.actions import built_in_moves, has_built_in_moves, phases_asking_for
from sjdsl.doc.wording import counted, joined, number, table_value, value_at_start
from sjdsl.told.legal import can_turn, looks_north
from sjdsl.told.lines import Line, bullets
from sjdsl.told.naming import Naming, article
from sjdsl.told.parameters import HasGame, parameters_of
from sjdsl.told.phrases import English
from sjdsl.told.reading import reading
from sjdsl.told.relevance import FieldName, Relevant, fields_read, relevant, set_in
from sjdsl.told.reply import reply_lines
from sjdsl.told.sentences import Speaker
from sjdsl.told.shapes import shape_lines
from sjdsl.told.terms import PLACEHOLDERS, explained, with_terms
from sjdsl.told.window import Window

Part = TypeVar("Part", bound=ir.Node)
FEW = 2  # fields that stand in one line
MOVES = (
    "moves: all agents move at once; {}whoever "
    "would step off the grid or onto a cell that it can't enter stays; two can't change places; of "
    "several who would enter one cell one does, by lot; a cell can be entered while its agent "
    "leaves it, not while it stays"
)


def told(
    env: HasGame | ir.Game, agent: int | None = None, role: str = "", notebook: bool = True
) -> str:
    """Returns the text that a player is told before an episode.

    It is made of the rules and of the parameters alone, so nothing that a state hides is in it.

    Args:
      env: an environment; or a game, with its default parameters.
      agent: the number of the player; without one, the text doesn't say who it is.
      role: words on the part that it plays; notebook: whether it may keep notes.

    Raises:
      ValueError: there is no such agent, or the environment doesn't know its rules.
      NotSupported: the compiler can't make observations of the game.
    """
    game: ir.Game | None = env if isinstance(env, ir.Game) else env.game
    if game is None:
        raise ValueError("this environment was made without its rules: pass one of `sjdsl.make`")
    if agent is not None and not 0 <= agent < game.agents.number:
        raise ValueError(f"agents are numbered 0 to {game.agents.number - 1}; there is no {agent}")
    if isinstance(env, ir.Game):
        values = {param.name: param.value for param in game.params}
    else:
        values = parameters_of(env)
    player = _Player(game, values)
    sections = {
        "YOUR AIM": player.aim(agent, role),
        "THE WORLD": player.world(),
        "ACTIONS": player.actions(),
        "SHAPES": shape_lines(player.shapes, player.laned, player.english),
        "HOW A TRIAL BEGINS" if game.trials else "HOW AN EPISODE BEGINS": player.beginning(),
        "WHAT HAPPENS IN A STEP": player.step(),
        "TERMS": player.terms(),
        "NUMBERS": player.tables(),
        "YOUR WINDOW": reading(player.relevant, player.window, player.english),
        "YOUR REPLY": reply_lines(notebook),
    }
    parts = ["\n".join([title, *lines]) for title, lines in sections.items() if lines]
    return "\n\n".join(parts) + "\n"


class _Player:
    """Writes the sections of the text on one game."""

    def __init__(self, game: ir.Game, values: Mapping[str, Any]) -> None:
        self.relevant: Relevant = relevant(game)
        self.game = self.relevant.game
        self.window = Window(game, token_planes(game))
        task = () if game.task is None else (game.task.draw,)
        blocks = [block for kind in game.kinds for block in kind.blocks]
        self.parts: tuple[ir.Node, ...] = (
            *task,
            *beginning_phases(self.game),
            *self.game.schedule,
            *self.game.agents.forbids,
            *self.game.agents.blocks,
            *blocks,
            *self.game.observables,
            *self.game.hidden,
            self.game.window,
        )
        self.naming = with_terms(Naming(self.game, values), self.parts)
        self.english = English(self.naming)
        self.speaker = Speaker(self.english)

    def _all(self, *classes: type[Part]) -> list[Part]:
        nodes = (node for part in self.parts for node in ir.walk(part))
        return [node for node in nodes if isinstance(node, classes)]

    @property
    def laned(self) -> frozenset[str]:
        """The shapes of whose lanes these rules take the first that fits."""
        domains = [node.domain for node in self._all(ir.First)]
        domains += [node.right for node in self._all(ir.Match) if node.first]
        return frozenset(d.restriction.shape for d in domains if isinstance(d.restriction, ir.Near))

    @property
    def shapes(self) -> tuple[ir.Shape, ...]:
        """The shapes that these rules speak of."""
        names = {node.shape for node in self._all(ir.Near)}
        names |= {node.shape for node in self._all(ir.Mark)}
        return tuple(shape for shape in self.game.shapes if shape.name in names)

    def aim(self, agent: int | None, role: str) -> list[str]:
        game = self.game
        others = game.agents.number - 1
        who = f"There are {game.agents.number} agents, numbered 0 to {others}."
        if not others:
            who = "You are the only agent."
        elif agent is not None:
            who += f" You are agent {agent}."
        length = self.english.text(game.episode)
        lines = [
            f"You are an agent in a game on a grid. {who}",
            "Your score is the sum of your own rewards over the whole episode.",
        ]
        authors_words = dict(game.about).get("player")
        if authors_words is not None:
            lines.append(authors_words)
        if role:
            lines.append(role)
        if game.trials is None:
            lines.append(f"An episode lasts {length} steps{self._may_end_early()}.")
        else:
            lines.append(
                f"An episode has {game.trials.number} trials of {length} steps each"
                f"{self._may_end_early()}. Steps are counted from 0 in each trial."
            )
            lines.append(f"Each trial begins anew, as said below{self._kept()}.")
        return lines

    def _may_end_early(self) -> str:
        return ", unless a rule ends it earlier" if self._all(ir.End) else ""

    def _kept(self) -> str:
        trials = self.game.trials
        assert trials is not None
        kept = []
        for field in trials.kept:
            owner = field.held_by
            name = field.name if owner.what == "world" else f"each {owner.name}'s {field.name}"
            kept.append(name)
        if self.game.task is not None:
            kept += self.game.task.fields
        if not kept:
            return ""
        names = joined(dict.fromkeys(kept))
        return (
            ", except that these keep their values from one trial to the next, whatever is said "
            f"there: {names}"
        )

    def world(self) -> list[str]:
        rows = counted(len(self.game.rows), "row")
        columns = counted(len(self.game.rows[0]), "column")
        heading = ", a heading (north, east, south or west)"
        if looks_north(self.game):
            heading = ""
        edge = "The edges of the grid are joined: whoever leaves it on one side comes back on the other."
        if not self.game.wraps:
            edge = "Nobody can leave the grid."
        lines = [
            f"The grid has {rows} and {columns}. {edge} "
            f"At most one {self.naming.somebody} stands on a cell.",
            "Kinds of cell (all can be entered unless it says otherwise):",
        ]
        for kind in self.game.kinds:
            if kind.name in self.naming.all_kinds:
                lines += self._kind(kind)
        lines += listed(
            "Each agent has a number, a cell (its row and col, counted from 0 in the north-west)"
            f"{heading}",
            self._fields(self.game.agents.fields),
            ", and",
        )
        for movers in self.game.movers:
            lines += listed(
                f"Movers: {movers.number} of the sort {movers.name}, which stand on cells as agents do and move as "
                "the rules say",
                self._fields(movers.fields),
                "; each has",
            )
        fields = self._fields(self.game.fields)
        return [*lines, *listed("The world has", fields, "")] if fields else lines

    def _kind(self, kind: ir.Kind) -> list[str]:
        parts = []
        if blocks_always(kind):
            parts.append("nobody can enter it")
        for block in kind.blocks:
            parts += self._block(block)
        head = f"- {kind.name}: {'; '.join(parts)}" if parts else f"- {kind.name}"
        return listed(
            head, self._fields(kind.fields, kind), "; it has" if parts else ", which has", "  "
        )

    def _block(self, block: ir.Block) -> list[str]:
        nouns = {movers.name: movers.name for movers in self.game.movers} | {"agents": "agent"}
        is_always = block.condition is None
        if block.what not in nouns or (block.what == "agents" and is_always):
            return []
        if is_always:
            return [f"no {nouns[block.what]} can enter it"]
        assert block.condition is not None
        test = self.english.text(block.condition)
        return [f"{article(nouns[block.what])} can't enter it if {test}"]

    def _fields(self, fields: tuple[ir.VarField, ...], kind: ir.Kind | None = None) -> list[str]:
        """Returns the fields that matter, each with its values and its start."""
        return [
            self._field(field, kind)
            for field in fields
            if self.relevant.has(field) and field.name != "heading"
        ]

    def _field(self, field: ir.VarField, kind: ir.Kind | None) -> str:
        by = "".join(f" for each {_entries(index_set)}" for index_set in field.type.indexed_by)
        values = "a timer" if field.timer else _values(field.type)
        starts = self._starts(field, kind)
        return f"{field.name}{by} ({values}{starts})"

    def _starts(self, field: ir.VarField, kind: ir.Kind | None) -> str:
        if self.game.task is not None and field.name in self.game.task.fields:
            return ""
        if (field.held_by.what, field.held_by.name, field.name) in self.set_first:
            return ""
        if kind is None:
            return f"; {value_at_start(field.start, field, str)} at first"
        cells: Counter[str] = Counter()
        for meaning in self.game.glyphs:
            if meaning.kind == kind.name:
                start = dict(meaning.starts).get(field.name, field.start)
                cells[value_at_start(start, field, str)] += sum(
                    row.count(meaning.glyph) for row in self.game.rows
                )
        cells = +cells  # without those that no cell has
        if len(cells) == 1:
            return f"; {next(iter(cells))} at first"
        texts = [f"{start} on {counted(number_, 'cell')}" for start, number_ in cells.items()]
        return f"; at first {joined(texts)}"

    @cached_property
    def set_first(self) -> frozenset[FieldName]:
        """The fields that the beginning sets for all who have them, whatever their start."""
        found: set[FieldName] = set()
        for each in self.game.start.body:
            if isinstance(each, ir.Each) and each.domain.on is None:
                if each.domain.where is None and each.domain.restriction is None:
                    found |= set_in(each.body)
        return frozenset(found - fields_read(self.game.start))

    def actions(self) -> list[str]:
        lines = ["In each step every agent chooses one action, all at the same time:"]
        with_arguments = {action.first: action for action in self.game.agents.with_arguments}
        numbers = {n for action in self.game.agents.with_arguments for n in action.numbers}
        for index, name in enumerate(self.game.agents.actions):
            if index in with_arguments:
                action = with_arguments[index]
                example = self.game.agents.actions[index]
                meaning = self._meaning(action.name, action.name)
                lines.append(f"- {_declared(action)}, such as {example}: {meaning}")
            elif index not in numbers:
                lines.append(f"- {name}: {self._meaning(name, index)}")
        lines += [f"- {self._forbidden(forbid)}" for forbid in self.game.agents.forbids]
        if self.game.agents.forbids:
            lines.append("The state before the step decides; what isn't allowed counts as stay.")
        return lines

    def _meaning(self, name: str, action: int | str) -> str:
        meanings = built_in_moves(name, self.game)
        stages = [phase.label for phase in phases_asking_for(action, self.game)]
        if stages:
            meanings.append(f"see the stage{'s' if len(stages) > 1 else ''} {joined(stages)}")
        return "; ".join(meanings) or "nothing"

    def _forbidden(self, forbid: ir.Forbid) -> str:
        actions = self.game.agents.actions
        stay = actions.index("stay")
        names = [actions[action] for action in forbid.actions if action != stay]
        if len(names) == len(actions) - 1 and len(names) > 1:
            what = "Anything but stay"
        else:
            what = joined(names)
        condition = forbid.condition
        if forbid.names:
            renames = _letters(forbid)
            condition = renamed(condition, renames)
            forbid = forbid.model_copy(
                update={"names": tuple(renames.get(name, name) for name in forbid.names)}
            )
            what = f"{forbid.action}({', '.join(_argument_names(forbid, names))})"
        verb = "are" if not forbid.names and len(names) > 1 and "Anything" not in what else "is"
        return f"{what} {verb} not allowed while {self.english.text(condition)}."

    def beginning(self) -> list[str]:
        lines = []
        task = self.game.task
        if task is not None:
            lines.append(
                f"When an episode begins, these are drawn ({task_space(task):,} ways, all equally "
                "likely), and stay until it ends:"
            )
            draws = (s for s in task.draw.body if isinstance(s, ir.Draw))
            lines += [
                f"- {name}: {self.speaker.drawn(draw)}."
                for name, draw in zip(task.fields, draws, strict=True)
            ]
            start = f"{'In each trial' if self.game.trials else 'Then'}:"
            lines.append(start)
        for phase in beginning_phases(self.game):
            if phase.body and phase is not self.game.start:
                lines.append(f"After that ({phase.label}):")
            lines += bullets(self.speaker.block(phase.body))
        return lines

    def step(self) -> list[str]:
        lines = [
            "A step has these stages, one after the other. What a stage says holds for all it "
            "speaks of at the same",
            "time: its conditions are about the state when the stage begins, and its changes "
            "appear when it ends.",
        ]
        for place, (title, sentences) in enumerate(self._stages(), 1):
            lines += [f"{place}. {title}", *(f"  {line}" for line in bullets(sentences))]
        return [*lines, *bullets(map(Line, self._notes()))]

    def _stages(self) -> list[tuple[str, tuple[Line, ...]]]:
        stages = []
        for turn in self.game.schedule:
            match turn:
                case ir.Phase():
                    sentences = self.speaker.block(turn.body)
                    title = turn.label
                case ir.Tick():
                    sentences = self._tick()
                    title = "tick"
                case _:
                    assert_never(turn)
            if sentences:
                stages.append((title, sentences))
        return stages

    def _tick(self) -> tuple[Line, ...]:
        timers = [f for f in all_fields(self.game) if f.timer and self.relevant.has(f)]
        lines = []
        if timers:
            names = joined(dict.fromkeys(timer.name for timer in timers))
            lines.append(Line(f"the timers ({names}) that are above 0 fall by 1"))
        if any(node.after is not None for node in self._all(ir.Send)):
            lines.append(
                Line(f"each {self.naming.somebody} that is away is one step nearer to its return")
            )
        return tuple(lines)

    def _notes(self) -> list[str]:
        """Returns how the rules are meant, as far as this game needs it."""
        notes = []
        sends = self._all(ir.Send)
        if has_built_in_moves(self.game):
            changes = "a turn changes only the heading, a step only the cell; "
            notes.append(MOVES.format(changes if can_turn(self.game) else ""))
        if sends:
            notes.append(
                "a cell is free if nobody stood on it when the stage began; several who are sent "
                "get different cells, by lot"
            )
        if any(can_be_away(self.game, entity_type) for entity_type in body_types(self.game)):
            notes.append(
                "whoever is away stands nowhere, sees nothing and does nothing; its fields stay, and "
                "it can still get rewards"
            )
        added = self._all(ir.Add)
        if any(node.target.type.kind != "agents" for node in added):
            notes.append(
                "what is added to a number in one stage is summed first, then kept within its limits"
            )
        if self._all(ir.Tally):
            notes.append("counts begin at 0 in each step; above 255 they stay at 255")
        if self._all(ir.Chance, ir.Draw):
            notes.append(
                'what is drawn is drawn anew each time, and where it says "each", for each one by itself'
            )
        if self.laned:
            notes.append(
                'the "first" in a lane is the nearest to the agent that fits; others are passed '
                "over"
            )
        if self._all(ir.Step) and self.game.trials is None:
            notes.append("the first step is step 0")
        if self._all(ir.Distance):
            notes.append(
                "a distance counts steps along rows and columns, whatever stands between"
                + (", the shorter way round" if self.game.wraps else "")
            )
        if self._all(ir.Bearing):
            notes.append(
                "steps ahead or to the right are counted as one looks, whatever stands between, "
                "and are below 0 behind and to the left"
            )
        if self._all(ir.At):
            notes.append("x[a] is the entry of x for a")
        return notes

    def terms(self) -> list[str]:
        return [f"- {text}." for text in explained(self.naming, self.parts)]

    def tables(self) -> list[str]:
        """Returns the tables that the rules read."""
        names = {node.name for node in self._all(ir.ParamRef) if node.type.indexed_by}
        return [
            f"- {param.name}: {table_value(self.naming.values[param.name], param.type.indexed_by, str)}"
            for param in self.game.params
            if param.name in names
        ]


def listed(head: str, fields: list[str], link: str, margin: str = "") -> list[str]:
    """Returns a sentence on fields: in one line if they are few, else below each other."""
    if not fields:
        return [head if head.startswith("- ") else f"{head}."]
    if len(fields) <= FEW:
        return [f"{head}{link} {joined(fields)}"]
    return [f"{head}{link}:", *(f"{margin}- {field}" for field in fields)]


def _declared(action: ir.ActionWithArguments) -> str:
    """Returns `offer(apples, pears) with apples (0 to 1) and pears (0 to 2)`."""
    names = [one.name or "x" for one in action.arguments]
    values = [
        f"{name} ({'an agent' if one.type.kind == 'agent' else _values(one.type)})"
        for name, one in zip(names, action.arguments, strict=True)
    ]
    return f"{action.name}({', '.join(names)}) with {joined(values)}"


def _letters(forbid: ir.Forbid) -> dict[str, str]:
    """Returns a letter for each agent that is an argument: `agent x` rather than `the who`."""
    members = [v.name for v in free_variables(forbid.condition) if isinstance(v, ir.Member)]
    names = [name for name in forbid.names if name in members]
    return dict(zip(names, PLACEHOLDERS, strict=False))


def _argument_names(forbid: ir.Forbid, names: list[str]) -> list[str]:
    """Returns the arguments of a `forbid`: its names, fixed values, or `any`."""
    values = [name[name.index("(") + 1 : -1].split(", ") for name in names]
    texts = []
    for place, name in enumerate(forbid.names):
        seen = {value[place] for value in values}
        texts.append(name or (seen.pop() if len(seen) == 1 else "any"))
    return texts


def _values(type_: ir.Type) -> str:
    """Returns what the values of a field are."""
    match type_.kind:
        case "word":
            return joined(type_.words, "or")
        case "int":
            return f"{number(type_.low)} to {number(type_.high)}"
        case "real":
            return "a number, whole or not"
        case "agent":
            return "an agent or nobody"
        case "agents":
            return "a set of agents"
        case "cell":
            return f"a cell of {joined(type_.kinds, 'or')}, or nowhere"
        case "condition" | "mix" | "member":
            raise AssertionError(type_)
        case _:
            assert_never(type_.kind)


def _entries(index_set: ir.IndexSet) -> str:
    match index_set.kind:
        case "agent":
            return "agent"
        case "number":
            return f"number from {index_set.names[0]} to {index_set.names[-1]}"
        case "word":
            return f"of {joined(index_set.names)}"
