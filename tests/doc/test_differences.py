"""`differences`: one pair of small programs for each sort of difference, the variants of the games, and nothing left out."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.doc import Written, differences, read_written, report

from .corpus import games, manual, small

BASE = """sj 1
game yard "A yard" {
  cite "A book"
  about summary "Two people and a few trees."
  size  players : count       = 2 in 1 .. 4
  param apple   : reward      = 1
  param growth  : probability = { none: 0.25, ripe: 0 } in 0 .. 0.5
  episode 20
  field weather : { sun, rain } = sun
  kind grass "."
  kind wall  "#" { blocks agents, ray }
  kind tree  "T" { field fruit : { none, ripe } = ripe  glyph "t" with fruit = none }
  group ground = grass, tree
  map { "..T#"
        ".tT." }
  agents players {
    acts turn_left, forward, stay, zap
    moves relative
    field bag : 0 .. 9 capped = 0
    timer tired
    forbid zap when agent.tired > 0
  }
  shape ray = line(2)
  define ripe_trees = count(tree where tree.fruit is ripe)
  phase start { each agent { send agent to grass } }
  schedule tick -> walk -> grow -> eat
  phase walk { move each agent }
  phase grow { each tree where tree.fruit is none { chance growth[tree.fruit] { set tree.fruit = ripe } } }
  phase eat {
    each agent on tree where tree.fruit is ripe and agent chose zap {
      set tree.fruit = none
      give apple to agent
      tally eaten for agent
      set agent.tired = 3
    }
    when weather is rain { each agent as one { each agent as two in ray of one { add 1 to two.bag } } }
    when step == 9 { set weather = rain }
  }
  observe { window ahead 2, behind 1, left 1, right 1  show agent.tired }
  metrics { event eaten  mean fruit = ripe_trees }
  checks { always ripe_trees <= 3 }
  policy greedy { seek tree where tree.fruit is ripe }
  scenario visitor { slots players - 1 focal  slots 1 policy greedy }
}
"""

# What is replaced in the base, and by what, perhaps of several places; then every line of the report below its first.
PAIRS = {
    "nothing": ("  episode 20\n", "\n# a remark\n  episode   20\n", "nothing differs"),
    "title": ('"A yard"', '"A farm yard"', "Description | title: A yard -> A farm yard"),
    "about": (
        '  about summary "Two people and a few trees."\n',
        '  about difficulty "easy"\n',
        "Description | summary: removed, was Two people and a few trees. | difficulty: added, easy",
    ),
    "cite": ("A book", "Another book", "Description | source 1: A book -> Another book"),
    "param": (
        "apple   : reward      = 1",
        "apple   : reward      = -0.5",
        "Numbers | apple: 1 -> -0.5 (reward)",
    ),
    "entry of a table": (
        "none: 0.25",
        "none: 0.00008",
        "Numbers | growth[none]: 0.25 -> 0.00008 (probability)",
    ),
    "limits": ("in 0 .. 0.5", "in 0 .. 0.75", "Numbers | growth, may be: 0 to 0.5 -> 0 to 0.75"),
    "new param": (
        "  episode 20",
        "  param pear : reward = 2 in 0 .. 3\n  episode 20",
        "give apple to",
        "give pear to agent  give apple to",
        "Numbers | pear | + param pear : reward = 2 in 0 .. 3 | Phases | eat | set tree.fruit = none | - give apple to agent"
        " | + give pear to agent give apple to agent | tally eaten for agent",
    ),
    "size": (
        "count       = 2",
        "count       = 3",
        "Numbers | players: 2 -> 3 (count) | Agents | number of agents: 2 -> 3",
    ),
    "episode": ("episode 20", "episode 30", "Episode | episode | - episode 20 | + episode 30"),
    "map size": (
        '".tT."',
        '".tT."\n        "...."',
        "Map | size: 2 rows of 4 cells -> 3 rows of 4 cells | cells of grass: 4 -> 8",
    ),
    "map": (
        '"..T#"',
        '"..t#"',
        "Map | cells of tree (`fruit` = `ripe`): 2 -> 1 | cells of tree (`fruit` = `none`): 1 -> 2"
        " | cells of the same kind and state: 8 -> 7",
    ),
    "actions": (
        "acts turn_left, forward, stay, zap",
        "acts forward, stay, zap, sing",
        "Agents | acts | - acts turn_left, forward, stay, zap | + acts forward, stay, zap, sing",
    ),
    "moves": (
        "moves relative",
        "moves compass",
        "Agents | moves | - moves relative | + moves compass",
    ),
    "field of agents": (
        "0 .. 9 capped",
        "0 .. 7 capped",
        "Agents | bag | - field bag : 0 .. 9 capped = 0 | + field bag : 0 .. 7 capped = 0",
    ),
    "forbid": (
        "forbid zap",
        "forbid forward, zap",
        "Agents | forbid zap | - forbid zap when agent.tired > 0 | forbid forward, zap | + forbid forward, zap when agent.tired > 0",
    ),
    "blocks": (
        "blocks agents, ray",
        "blocks agents",
        'Kinds of cell | wall | - kind wall "#" { blocks agents, ray } | + kind wall "#" { blocks agents }',
    ),
    "new kind": (
        "  group ground",
        '  kind pond "~" { field fish : 0 .. 3 = 1 }\n  group ground',
        '"..T#"',
        '".~T#"',
        "Map | cells of grass: 4 -> 3 | cells of pond (`fish` = 1): added, 1"
        ' | cells of the same kind and state: 8 -> 7 | Kinds of cell | pond | + kind pond "~" { field fish : 0 .. 3 = 1 }',
    ),
    "group": (
        "group ground = grass, tree",
        "group ground = grass",
        "Kinds of cell | ground | - group ground = grass, tree | + group ground = grass",
    ),
    "shape": ("line(2)", "line(3)", "Shapes | ray | - shape ray = line(2) | + shape ray = line(3)"),
    "field of the world": (
        "{ sun, rain } = sun",
        "{ sun, rain } = rain",
        "State of the world | weather | - field weather : { sun, rain } = sun | + field weather : { sun, rain } = rain",
    ),
    "define": (
        "is ripe)\n",
        "is none)\n",
        "Names | ripe_trees | - define ripe_trees = count(tree where tree.fruit is ripe)"
        " | + define ripe_trees = count(tree where tree.fruit is none)",
    ),
    "start": (
        "send agent to grass",
        "send agent to grass facing east",
        "Phases | start | - phase start { each agent { send agent to grass } }"
        " | + phase start { each agent { send agent to grass facing east } }",
    ),
    "phase moved": (
        "tick -> walk -> grow -> eat",
        "walk -> grow -> eat -> tick",
        "Schedule | schedule | - schedule tick -> walk -> grow -> eat | + schedule walk -> grow -> eat -> tick",
    ),
    "phase added": (
        "grow -> eat",
        "grow -> eat -> rest",
        "  observe",
        "  phase rest { give 1 to all }\n  observe",
        "Schedule | schedule | - schedule tick -> walk -> grow -> eat | + schedule tick -> walk -> grow -> eat -> rest"
        " | Phases | rest | + phase rest { give 1 to all }",
    ),
    "phase removed": (
        "walk -> grow",
        "grow",
        "  phase walk { move each agent }\n",
        "",
        "Schedule | schedule | - schedule tick -> walk -> grow -> eat | + schedule tick -> grow -> eat | Phases | walk"
        " | - phase walk { move each agent }",
    ),
    "phase changed": (
        "set agent.tired = 3",
        "set agent.tired = 4",
        "Phases | eat | tally eaten for agent | - set agent.tired = 3 | + set agent.tired = 4 | }",
    ),
    "window": (
        "behind 1",
        "behind 0",
        "Observation | window | - window ahead 2, behind 1, left 1, right 1 | + window ahead 2, behind 0, left 1, right 1",
    ),
    "seen": ("  show agent.tired", "", "Observation | agent.tired | - show agent.tired"),
    "metrics": (
        "mean fruit",
        "final fruit",
        "Metrics | fruit | - mean fruit = ripe_trees | + final fruit = ripe_trees",
    ),
    "checks": (
        "always ripe_trees <= 3",
        "conserved ripe_trees",
        "Checks | checks | - always ripe_trees <= 3 | + conserved ripe_trees",
    ),
    "policies": (
        "policy greedy {",
        'policy greedy "eats" { when agent.bag > 5 choose zap ',
        "Policies | greedy | - policy greedy { seek tree where tree.fruit is ripe }"
        ' | + policy greedy "eats" { when agent.bag > 5 choose zap seek tree where tree.fruit is ripe }',
    ),
    "scenarios": (
        "slots 1 policy greedy",
        "slots 1 policy random",
        "Scenarios | visitor | - scenario visitor { slots players - 1 focal slots 1 policy greedy }"
        " | + scenario visitor { slots players - 1 focal slots 1 policy random }",
    ),
}


def read(text: str) -> Written:
    return read_written(Source("yard.sj", text))


def told(old: Written, new: Written) -> str:
    """Returns the lines of a report below its first, layout left out."""
    _, *lines = report(old, new).splitlines()
    return " | ".join(" ".join(line.split()) for line in lines if line)


@pytest.mark.parametrize("name", PAIRS)
def test_one_difference(name: str) -> None:
    *edits, wanted = PAIRS[name]
    text = BASE
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        assert text.count(old) == 1 or name == "param", old
        text = text.replace(old, new)
    assert told(read(BASE), read(text)) == wanted


def test_the_other_way_round_is_the_opposite() -> None:
    new = read(
        BASE.replace("apple   : reward      = 1", "apple   : reward      = 2").replace(
            "none: 0.25", "none: 0.5"
        )
    )
    assert (
        told(read(BASE), new)
        == "Numbers | apple: 1 -> 2 (reward) | growth[none]: 0.25 -> 0.5 (probability)"
    )
    assert (
        told(new, read(BASE))
        == "Numbers | apple: 2 -> 1 (reward) | growth[none]: 0.5 -> 0.25 (probability)"
    )


def test_layout_comments_and_order_are_no_differences() -> None:
    walk, phases = "  phase walk { move each agent }\n", "  phase grow"
    moved = BASE.replace(walk, "").replace(
        phases, f'{walk.replace(" move each", chr(10) + "move   each")}{phases}  # a "remark"\n'
    )
    assert moved != BASE
    assert told(read(BASE), read(moved)) == "nothing differs"


# What the rules of the released code say differs from the default of each game.
COMPASS = ("Agents", "- moves relative + moves compass")
THROUGH_WALLS = ("Kinds of cell", '- kind wall "#" { blocks agents, beam }')
RELEASED = {
    "clean_up": [COMPASS, THROUGH_WALLS, ("Observation", "+ show gate as { grass }")],
    "coins": [COMPASS],
    "coop_mining": [
        COMPASS,
        ("Numbers", "spawn_iron: 0.0004 -> 0.0002"),
        ("Numbers", "spawn_gold: 0.00016 -> 0.00008"),
    ],
    "gift_refinement": [
        COMPASS,
        ("Schedule", "consume"),
        ("Observation", "- show agent.bag + hide agent.bag"),
    ],
    "harvest_closed": [COMPASS, THROUGH_WALLS],
    "harvest_open": [COMPASS, THROUGH_WALLS],
    "harvest_partnership": [COMPASS, THROUGH_WALLS],
    "mushrooms": [COMPASS, ("Schedule", "eat")],
    "pd_arena": [
        COMPASS,
        ("Schedule", "tick"),
        ("Phases", "each agent as column in reach of row"),
        ("Observation", "+ show everyone.bag"),
    ],
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", RELEASED)
def test_what_the_released_variant_changes(name: str) -> None:
    _, *sections = report(games()[name], games()[f"{name}+socialjax"]).split("\n\n")
    lines = {
        title: " ".join(rest.split())
        for title, _, rest in (section.partition("\n") for section in sections)
    }
    for section, text in RELEASED[name]:
        assert text in lines[section], (section, text)


@pytest.mark.thorough
def test_a_game_does_not_differ_from_itself() -> None:
    for written in games().values():
        assert differences(written, written) == {}


def without_one(c: Composition) -> Iterator[tuple[str, Composition]]:
    """Yields a game without each of its declarations, but those with numbers of their own: what it is named, and what is left."""
    tables = {
        *Composition.TABLES,
        "agent_fields",
        "forbids",
        "agent_blocks",
        "observables",
        "looks",
    } - {"constants"}
    for table in sorted(tables):
        found = getattr(c, table)
        yield from (
            (name, replace(c, **{table: {n: d for n, d in found.items() if n != name}}))
            for name in found
        )
    yield from (
        (name, replace(c, **{name: None}))
        for name in ("acts", "moves", "schedule", "episode")
        if getattr(c, name) is not None
    )
    if c.windows:
        yield "window", replace(c, windows=())


@pytest.mark.parametrize("programs", [small, pytest.param(manual, marks=pytest.mark.thorough)])
def test_no_declaration_is_lost_without_a_difference(
    programs: Callable[[], dict[str, Written]],
) -> None:
    for written in programs().values():
        for name, left in without_one(written.composition):
            ((what, *lines),) = differences(written, replace(written, composition=left)).values()
            assert what == (name or "checks")
            assert {line[:4] for line in lines} == {"  - "}, (written.game.name, name)
