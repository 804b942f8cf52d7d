"""`differences`: one pair of small programs for each sort of difference, the variants of the games, and nothing left out."""

import json
from collections import Counter

import pytest

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.doc import Written, differences, read_written
from sjdsl.doc.report import as_json, report

from .changes import small_changes, without_origins
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

# What is replaced in the base by what, and every line of the report below its first.
PAIRS = {
    "nothing": ([("  episode 20\n", "\n# a remark\n  episode   20\n")], "nothing differs"),
    "title": ([('"A yard"', '"A farm yard"')], "Description | title: A yard -> A farm yard"),
    "about": (
        [('  about summary "Two people and a few trees."\n', '  about difficulty "easy"\n')],
        "Description | summary: removed, was Two people and a few trees. | difficulty: added, easy",
    ),
    "cite": ([("A book", "Another book")], "Description | source 1: A book -> Another book"),
    "param": ([("apple   : reward      = 1", "apple   : reward      = -0.5")], "Numbers | apple: 1 -> -0.5 (reward)"),
    "entry of a table": ([("none: 0.25", "none: 0.00008")], "Numbers | growth[none]: 0.25 -> 0.00008 (probability)"),
    "limits": ([("in 0 .. 0.5", "in 0 .. 0.75")], "Numbers | growth, may be: 0 to 0.5 -> 0 to 0.75"),
    "new param": (
        [("  episode 20", "  param pear : reward = 2 in 0 .. 3\n  episode 20"), ("give apple to", "give pear to agent  give apple to")],
        "Numbers | pear: added, 2 (may be 0 to 3) (reward) | Phases | eat |"
        " Each agent that chose `zap` and that stands on a tree cell whose `fruit` is `ripe`: |"
        " + The agent receives a reward of `pear`.",
    ),
    "size": ([("count       = 2", "count       = 3")], "Numbers | players: 2 -> 3 (count) | Agents | number of agents: 2 -> 3 |"
        " Scenarios | scenarios | - `visitor`: 1 focal agent and 1 agent that follows `greedy`. |"
        " + `visitor`: 2 focal agents and 1 agent that follows `greedy`."),
    "episode": (
        [("episode 20", "episode 30")],
        "Episode | episode | - An episode is cut off (truncated) after 20 steps; the reward of the last step counts. |"
        " + An episode is cut off (truncated) after 30 steps; the reward of the last step counts.",
    ),
    "map size": (
        [('".tT."', '".tT."\n        "...."')],
        "Map | size: 2 rows of 4 cells -> 3 rows of 4 cells | cells of grass: 4 -> 8",
    ),
    "map": (
        [('"..T#"', '"..t#"')],
        "Map | cells of tree (`fruit` = `ripe`): 2 -> 1 | cells of tree (`fruit` = `none`): 1 -> 2 | cells of the same kind and state: 8 -> 7",
    ),
    "actions": (
        [("acts turn_left, forward, stay, zap", "acts forward, stay, zap, sing")],
        "Agents | action turn_left: removed, was 0 | action forward: 1 -> 0 | action stay: 2 -> 1 | action zap: 3 -> 2 | action sing: added, 3",
    ),
    "moves": ([("moves relative", "moves compass")], "Agents | moves: relative to the heading -> by the compass"),
    "field of agents": (
        [("0 .. 9 capped", "0 .. 7 capped")],
        "Agents | fields | - `bag`: a whole number from 0 to 9, at first 0; what would leave this range by adding is cut off. |"
        " + `bag`: a whole number from 0 to 7, at first 0; what would leave this range by adding is cut off.",
    ),
    "forbid": (
        [("forbid zap", "forbid forward, zap")],
        "Agents | forbidden actions | - `zap` of an agent counts as `stay` while the `tired` of the agent is more than 0. |"
        " + `forward` and `zap` of an agent count as `stay` while the `tired` of the agent is more than 0.",
    ),
    "blocks": ([("blocks agents, ray", "blocks agents")], "Kinds of cell | wall | - A lane of `ray` ends at a wall cell."),
    "new kind": (
        [("  group ground", '  kind pond "~" { field fish : 0 .. 3 = 1 }\n  group ground'), ('"..T#"', '".~T#"')],
        "Numbers | players, may be: 1 to 4 -> 1 to 3 | Map | cells of grass: 4 -> 3 | cells of pond (`fish` = 1): added, 1 |"
        " cells of the same kind and state: 8 -> 7 | Kinds of cell | kind pond: added, glyph ~ | pond | + `fish`: a whole number from 0 to 3, at first 1. |"
        " glyph ~: added, pond `fish` = 1 | Observation | not seen | + The `fish` of pond cells.",
    ),
    "group": ([("group ground = grass, tree", "group ground = grass")], "Kinds of cell | group ground: grass, tree -> grass"),
    "shape": ([("line(2)", "line(3)")], "Shapes | ray | - 2 cells. | - It turns with the agent, which looks up in the picture. | - x | - x | - ^ |"
        " + 3 cells. | + It turns with the agent, which looks up in the picture. | + x | + x | + x | + ^"),
    "field of the world": (
        [("{ sun, rain } = sun", "{ sun, rain } = rain")],
        "State of the world | fields | - `weather`: `sun` or `rain`, at first `sun`. | + `weather`: `sun` or `rain`, at first `rain`.",
    ),
    "define": (
        [("is ripe)\n", "is none)\n")],
        "Names | names | - `ripe_trees` is the number of tree cells whose `fruit` is `ripe`. |"
        " + `ripe_trees` is the number of tree cells whose `fruit` is `none`.",
    ),
    "start": (
        [("send agent to grass", "send agent to grass facing east")],
        "Initialisation | start | - Each agent: the agent is sent to a random free grass cell, looking in a random direction. |"
        " + Each agent: the agent is sent to a random free grass cell, looking east.",
    ),
    "phase moved": (
        [("tick -> walk -> grow -> eat", "walk -> grow -> eat -> tick")],
        "Schedule | phase tick: place 1, at the beginning -> place 4, after eat",
    ),
    "phase added": (
        [("grow -> eat", "grow -> eat -> rest"), ("  observe", "  phase rest { give 1 to all }\n  observe")],
        "Schedule | phase rest: added, place 5, after eat | Phases | rest | + Every agent receives a reward of 1.",
    ),
    "phase removed": (
        [("walk -> grow", "grow"), ("  phase walk { move each agent }\n", "")],
        "Schedule | phase walk: removed, was place 2, after tick | Phases | walk |"
        " - Each agent makes the move it chose, all at the same time (see Movement).",
    ),
    "phase changed": (
        [("set agent.tired = 3", "set agent.tired = 4")],
        "Phases | eat | Each agent that chose `zap` and that stands on a tree cell whose `fruit` is `ripe`: |"
        " - The `tired` of the agent becomes 3. | + The `tired` of the agent becomes 4.",
    ),
    "window": ([("behind 1", "behind 0")], "Observation | window behind: 1 -> 0 (cells)"),
    "seen": (
        [("  show agent.tired", "")],
        "Observation | seen | - The `tired` of the observer itself, the same everywhere in the window. |"
        " not seen | + The `tired` of the observer itself.",
    ),
    "metrics": (
        [("mean fruit", "final fruit")],
        "Metrics | metrics | - `fruit`: the mean over the steps of an episode of `ripe_trees`, read at the end of each step. |"
        " + `fruit`: at the last step of an episode `ripe_trees`, read at the end of each step.",
    ),
    "checks": (
        [("always ripe_trees <= 3", "conserved ripe_trees")],
        "Checks | checks | - After every step: `ripe_trees` is at most 3. | + Never changes: `ripe_trees`.",
    ),
    "policies": (
        [("policy greedy {", 'policy greedy "eats" { when agent.bag > 5 choose zap ')],
        "Policies | title of greedy: added, eats | greedy | + If the `bag` of the agent is more than 5, choose `zap`.",
    ),
    "scenarios": (
        [("slots 1 policy greedy", "slots 1 policy random")],
        "Scenarios | scenarios | - `visitor`: 1 focal agent and 1 agent that follows `greedy`. |"
        " + `visitor`: 1 focal agent and 1 agent that chooses all actions equally likely.",
    ),
}  # fmt: skip


def read(text: str) -> Written:
    return read_written(Source("yard.sj", text))


def told(old: Written, new: Written) -> str:
    """Returns the lines of a report below its first, layout left out."""
    _, *lines = report(old, new, differences(old, new)).splitlines()
    return " | ".join(" ".join(line.split()) for line in lines if line)


@pytest.mark.parametrize("name", PAIRS)
def test_one_difference(name: str) -> None:
    edits, wanted = PAIRS[name]
    text = BASE
    for old, new in edits:
        assert text.count(old) == 1 or name == "param", old
        text = text.replace(old, new)
    assert told(read(BASE), read(text)) == wanted


def test_the_other_way_round_is_the_opposite() -> None:
    new = read(BASE.replace("apple   : reward      = 1", "apple   : reward      = 2").replace("behind 1", "behind 0"))
    there, back = (as_json(*pair, differences(*pair))["sections"] for pair in ((read(BASE), new), (new, read(BASE))))
    changes = [[(c["what"], c["old"], c["new"]) for s in side for c in s["changes"]] for side in (there, back)]
    assert changes == [[("apple", 1.0, 2.0), ("window behind", 1, 0)], [("apple", 2.0, 1.0), ("window behind", 0, 1)]]


def test_json_holds_the_same() -> None:
    new = read(BASE.replace("set agent.tired = 3", "set agent.tired = 4"))
    found = json.loads(json.dumps(as_json(read(BASE), new, differences(read(BASE), new))))
    assert found["differs"] is True
    (section,) = found["sections"]
    assert section["section"] == "Phases"
    change = {"what": "eat", "removed": ["The `tired` of the agent becomes 3."], "added": ["The `tired` of the agent becomes 4."]}
    assert section["changes"] == [change]


# What the rules of the released code say differs from the default of each game.
COMPASS = ("Agents", "moves: relative to the heading -> by the compass")
THROUGH_WALLS = ("Kinds of cell", "A lane of `beam` ends at a wall cell")
RELEASED = {
    "clean_up": [COMPASS, THROUGH_WALLS, ("Observation", "+ `gate` cells not as what they are, but as `grass`")],
    "coins": [COMPASS],
    "coop_mining": [COMPASS, ("Numbers", "spawn_iron: 0.0004 -> 0.0002"), ("Numbers", "spawn_gold: 0.00016 -> 0.00008")],
    "gift_refinement": [
        COMPASS,
        ("Schedule", "phase consume: place 4, after collect -> place 8, after sample"),
        ("Observation", "- The `raw` entry of the `bag` of the observer itself"),
    ],
    "harvest_closed": [COMPASS, THROUGH_WALLS],
    "harvest_open": [COMPASS, THROUGH_WALLS],
    "harvest_partnership": [COMPASS, THROUGH_WALLS],
    "mushrooms": [COMPASS, ("Schedule", "phase tick: place 1, at the beginning -> place 8"), ("Schedule", "phase eat: place 3")],
    "pd_arena": [
        COMPASS,
        ("Schedule", "phase tick"),
        ("Phases", "- Each agent *one*, standing for agent *row* and agent *column* in turn"),
        ("Phases", "+ Each agent *column* that stands in the `reach` of agent *row*"),
        ("Observation", "+ The `coop` entry of the `bag` of every agent"),
    ],
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", RELEASED)
def test_what_the_released_variant_changes(name: str) -> None:
    pair = games()[name], games()[f"{name}+socialjax"]
    for section, text in RELEASED[name]:
        lines = {s.title: report(*pair, [s]) for s in differences(*pair)}
        assert section in lines and text in " ".join(lines[section].split()), (section, text)


@pytest.mark.thorough
def test_a_game_does_not_differ_from_itself() -> None:
    for written in games().values():
        assert differences(written, written) == ()


@pytest.mark.thorough
def test_no_part_of_the_rules_changes_without_a_difference() -> None:
    tried: Counter[tuple[str, str]] = Counter()
    unnoticed = []
    for name, written in (small() | manual()).items():
        game = without_origins(written.game)
        for sort, field, changed in small_changes(game, tried):
            unnoticed += [(name, sort, field) for other in changed if not differs(written, other)]
    assert unnoticed == []


def differs(written: Written, changed: ir.Game) -> bool:
    try:
        return bool(differences(written, Written(changed, written.file, written.chosen, written.variants, written.numbers)))
    except (KeyError, StopIteration, ValueError, AttributeError, IndexError, RuntimeError, AssertionError):
        return True  # not even a game: a name that nothing has was read
