"""Elaborates the length of an episode, and its trials.

episode 5 trials of 300 { keep tree.hue }   ->   300, Trials(number=5, kept=(tree.hue))
"""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.compose import Composition, path_text
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.queries import contains
from sjdsl.compiler.ir.types import integer

TRIAL = "trial"  # a field of the world that counts the trials


def declare_trial(game: Composition, scope: Scope) -> None:
    """Adds the number of the trial to the fields of the world, if the episode has trials."""
    if game.episode is None or game.episode.trials is None:
        return
    static = scope.static
    static.has_trials = True
    static.used.add(Symbol("name", TRIAL))  # by the episode itself
    with scope.problems.skip_if_broken(static.broken, Symbol("name", TRIAL)):
        number = _number_of_trials(game.episode, scope)
        if isinstance(game.episode.length, ast.Path):
            static.sized.add(field_symbol(TRIAL, "world"))
        static.fields[TRIAL] = ir.VarField(
            name=TRIAL,
            held_by=ir.EntityType("world"),
            type=integer(0, number - 1, "count"),
            start=0,
            origin=game.episode.length.span,
        )


def _number_of_trials(episode: ast.Episode, scope: Scope) -> int:
    name = "the number of trials"
    return scope.whole(episode.length, name, name, 1, limits.MAX_TRIALS)


def episode(game: Composition, scope: Scope) -> tuple[ir.Expr, ir.Trials | None]:
    """Returns the steps of a trial, or of the whole episode without trials; and the trials.

    The steps are made of numbers and parameters alone.
    """
    if game.episode is None:
        raise scope.fail(errors.MissingPart(game.span, part="episode", example="`episode 1000`"))
    trials = game.episode.trials
    length = game.episode.length if trials is None else trials.steps
    steps = scope.number(length, ("steps",), "a number of steps")
    if contains(steps, ir.Step, ir.FieldRead, ir.Aggregate):
        help_ = "use numbers, `size`s and `param`s; `end` ends an episode when something happens"
        quantity = "the length of an episode"
        raise scope.fail(errors.NotFixed(length.span, quantity=quantity, help=help_))
    if trials is None:
        return steps, None
    number = _number_of_trials(game.episode, scope)
    kept = scope.problems.each(trials.kept, lambda path: _kept(path, scope))
    fields = [field for fields in kept for field in fields]
    for place, field in enumerate(fields):
        if field in fields[:place]:
            part = f"`keep {field.held_by.name}.{field.name}`"
            scope.problems.add(errors.WrittenTwice(field.span, part=part))
    return steps, ir.Trials(number=number, kept=tuple(fields), origin=trials.span)


def _kept(path: ast.Path, scope: Scope) -> list[ir.Kept]:
    """Returns the fields that a path names: `agent.f`, `kind.f`, `group.f`, `deer.f`, `f`."""
    static = scope.static
    head = path.name.text
    match path.steps:
        case () if head in static.task_fields:
            raise scope.fail(errors.KeptAnyway(path.span, name=head))
        case () if head in static.fields and head != TRIAL:
            static.use(path.name, Symbol("name", head))
            return [ir.Kept(held_by=ir.EntityType("world"), name=head, origin=path.span)]
        case (ast.Member(name=name),):
            return _kept_of(path, name, scope)
        case () if head not in static.names():
            raise scope.problems.unknown(path.name, static.fields, "the fields of the world")
        case _:
            raise scope.fail(errors.NotKept(path.span, name=path_text(path)))


def _kept_of(path: ast.Path, name: ast.Name, scope: Scope) -> list[ir.Kept]:
    """Returns a field of agents, of movers, or of cells of a kind or of each kind of a group."""
    static = scope.static
    head = path.name.text
    kinds = static.kinds_of(head)
    if head == "agent":
        owners = [AGENTS]
    elif head in static.movers:
        owners = [ir.EntityType("mover", (head,))]
    elif kinds is not None:
        owners = [ir.EntityType("cell", (kind,)) for kind in kinds]
    else:
        known = ["agent", *static.kinds, *static.groups, *static.movers]
        raise scope.problems.unknown(path.name, known, "what has fields")
    if head != "agent":
        static.refer(path.name, Symbol("name", head))
    kept = []
    for owner in owners:
        fields = static.fields_of(owner)
        symbol = Symbol("field", name.text, owner.name)
        if symbol in static.broken:
            raise Poisoned
        attributes = CELL_ATTRIBUTES if owner.what == "cell" else AGENT_ATTRIBUTES
        is_attribute = name.text in attributes or (owner.what, name.text) == ("mover", "heading")
        if is_attribute:
            raise scope.fail(errors.NotKept(path.span, name=path_text(path)))
        if name.text not in fields:
            raise no_field(name, f"`{owner.name}`", fields, scope.problems)
        static.use(name, symbol)
        kept.append(ir.Kept(held_by=owner, name=name.text, origin=path.span))
    return kept
