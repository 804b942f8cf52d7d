"""Splits of the tasks of random programs, and which tasks of a game are played."""

from random import Random

from sjdsl.compiler import ir
from sjdsl.compiler.ir.task_rows import drawn_fields, part_name, parts_of, values_of
from sjdsl.library.tasks import splits_of, with_tasks

# Conditions on the fields that programs declare.
CONDITIONS = {
    "sown": ("sown is clover", "sown in { clover, nettle }", "not (sown is thistle)"),
    "harvest": (
        "harvest[clover] > harvest[thistle]",
        "harvest[nettle] in 0 .. 1",
        "harvest[clover] + harvest[nettle] < 2",
    ),
    "weeds": ("weeds[1] is not clover", "weeds[0] is weeds[2]"),
    "crop": ("crop[thistle] == 0", "crop[clover] < 1 or crop[clover] > 2"),
}


def splits(fields: list[str], random: Random) -> list[str]:
    """Returns random splits of a task with these fields, none in some programs."""
    texts = []
    if random.random() < 0.5:
        texts.append(f"train on {random.randint(1, 2)} of rules seed {random.randint(0, 9)}")
    for number in range(random.choice((0, 0, 1, 1, 2))):
        names = random.sample(fields, random.randint(1, min(2, len(fields))))
        conditions = [random.choice(CONDITIONS[name]) for name in names]
        joined = random.choice((" and ", " or ")).join(conditions)
        texts.append(f"hold out split_{number} of rules where {joined}")
    return texts


def on_some_side(game: ir.Game, seed: int) -> ir.Game:
    """Returns a game that plays all tasks, those of a side, or those with some parts given."""
    task = game.task
    if task is None:
        return game
    random = Random(f"side {seed}")
    choices = ["all", "given", *splits_of(task)]
    if len(choices) > 2:
        choices.append("training")
    chosen = random.choice(choices)
    if chosen == "given":
        return with_tasks(game, _given(task, random))
    if chosen in ("all", "training"):
        return with_tasks(game, chosen)
    return with_tasks(game, "held_out", chosen)


def _given(task: ir.Task, random: Random) -> dict[str, int | str]:
    """Returns values of some parts."""
    given: dict[str, int | str] = {}
    for drawn in drawn_fields(task):
        values = random.sample(values_of(drawn), min(len(parts_of(drawn)), len(values_of(drawn))))
        for part, value in zip(parts_of(drawn), values, strict=False):
            if random.random() < 0.5:
                given[part_name(part, task)] = value
    return given
