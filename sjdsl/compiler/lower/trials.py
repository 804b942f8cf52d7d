"""Lowers trials: the function that begins one with the fields that the trial before leaves it."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, beginning_phases, written_field
from sjdsl.compiler.lower.beginning import begun
from sjdsl.compiler.lower.writer import Module, Writer, replaced
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import Expression, Name, Where, live, path

BEGINNING = (("state", "State"), ("is_last", "Array"), ("params", "Params"), ("key", "Array"))
TRIAL = "world_trial"  # the attribute of State that counts the trials


def next_trial(
    game: ir.Game,
    trials: ir.Trials,
    laid: Expression,
    module: Module,
) -> Function:
    """Returns the function `next_trial`. laid: the state before `start` when an episode begins."""
    w = Writer(module)
    w.set(Name("laid"), laid)
    attributes = _kept_attributes(game, trials)
    kept = {attribute: path(f"state.{attribute}") for attribute in attributes}
    counted = path(f"state.{TRIAL}") + 1
    w.set(Name("laid"), replaced("laid", _unless_last("laid", {TRIAL: counted, **kept})))
    state: Expression = Name("laid")
    for phase in beginning_phases(game):
        w.set(Name("begun"), begun(phase, state))
        written = _attributes_written_by(phase)
        lost: dict[str, Expression] = {}
        for attribute in attributes:
            if attribute in written:
                lost[attribute] = path(f"laid.{attribute}")
        state = replaced("begun", _unless_last("begun", lost))
    w.give_back(state)
    doc = (
        "Returns the first state of the next trial; if `is_last`, of the next episode.\n\n"
        "A trial begins as an episode does, but for the fields that are kept: "
        f"what {'its first phases write' if game.starting else '`start` writes'} to them is lost."
    )
    return Function("next_trial", BEGINNING, "State", doc, live(w.body))


def _unless_last(state: str, changes: dict[str, Expression]) -> dict[str, Expression]:
    """Returns new values of attributes of a state, which stay as they are in the last trial."""
    return {
        attribute: Where(Name("is_last"), path(f"{state}.{attribute}"), value)
        for attribute, value in changes.items()
    }


def _kept_attributes(game: ir.Game, trials: ir.Trials) -> list[str]:
    """Returns the attributes of State that are kept, those of the task too, but not `trial`."""
    kept = {(field.held_by, field.name) for field in trials.kept}
    if game.task is not None:
        world = ir.EntityType("world")
        kept |= {(world, name) for name in game.task.fields}
    attributes = []
    for field in all_fields(game):
        if (field.held_by, field.name) in kept:
            attributes.append(attribute_name(field))
    return attributes


def _attributes_written_by(phase: ir.Phase) -> set[str]:
    """Returns the attributes of State that a phase sets or adds to."""
    written = set()
    for node in ir.walk(phase):
        if isinstance(node, ir.Set | ir.Add):
            field = written_field(node.target)
            for owner in field.held_by.names or (field.held_by.what,):
                written.add(f"{owner}_{field.name}")
    return written
