"""Each state of a cell looks different, and the legend says what each look means."""

from itertools import product

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.render.appearance import Drawing, draw_cell
from sjdsl.render.board import draw_tile
from sjdsl.render.conditions import in_words
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import KindLook, Look, make_look

GAME = """sj 1
game lot "A lot" {{
  episode 9
  kind ground "."
  kind {kind} "k" {{ {fields} }}
  map {{ "..k" }}
  {agents}
  phase start {{ each agent {{ send agent to ground }} }}
  schedule rule
  phase rule {{ {rules} }}
  {looks}
  observe {{ {shown} }}
  variant other "Another" {{ episode 8 }}
}}
"""
AGENTS = "agents 2 { acts stay }"
CONSTANT = "field across : { east, west } = east  field down : { north, south } = north"
PLANTS = "field fruit : { none, ripe } = none  field nut : { none, ripe } = none  field bark : { none, ripe } = none"
PICKED = "each agent on lane { set lane.fruit = ripe  set lane.nut = ripe  set lane.bark = ripe }"
MANY = " ".join(f"field f{n} : {{ none, w{n} }} = none" for n in range(6))
CHANGED = "each lane { " + " ".join(f"set lane.f{n} = w{n}" for n in range(6)) + " }"


def look_of(
    kind: str = "lane",
    fields: str = "",
    rules: str = "",
    looks: str = "",
    shown: str = "",
    agents: str = AGENTS,
) -> Look:
    text = GAME.format(
        kind=kind, fields=fields, rules=rules, looks=looks, shown=shown, agents=agents
    )
    return make_look(build(Source("lot.sj", text)).game)


def drawn(kind: KindLook) -> list[tuple[tuple[str, ...], Drawing]]:
    """Returns what is drawn for each combination of the words of a kind."""
    numbers = product(*(range(len(field.words)) for field in kind.fields))
    always = tuple(int(rule.condition is None) for rule in kind.rules)
    return [
        (
            tuple(f.words[n] for f, n in zip(kind.fields, key, strict=True)),
            draw_cell(kind, (*key, *always)),
        )
        for key in numbers
    ]


@pytest.mark.parametrize(
    ("kind", "fields", "rules"),
    [
        ("lane", CONSTANT, ""),
        ("lane", f"{CONSTANT} field paved : {{ earth, stone, brick }} = earth", ""),
        ("wall", CONSTANT, ""),
        ("pond", CONSTANT, ""),
        ("tree", CONSTANT, ""),
        ("lane", "field hue : { red, blue } = red  field rim : { red, blue } = red", ""),
        ("lane", PLANTS, PICKED),
        ("lane", f"{CONSTANT} {PLANTS}", PICKED),
        ("lane", MANY, CHANGED),
        ("lane", f"field sort : {{ {', '.join(f'sort_{n}' for n in range(20))} }} = sort_0", ""),
        (
            "lane",
            f"field sort : {{ {', '.join(f'sort_{n}' for n in range(20))} }} = sort_0",
            "each lane { set lane.sort = sort_1 }",
        ),
        ("tree", MANY.replace("lane", "tree"), CHANGED.replace("lane", "tree")),
    ],
)
def test_each_combination_of_words_looks_different(kind: str, fields: str, rules: str) -> None:
    states = drawn(next(k for k in look_of(kind, fields, rules).kinds if k.name == kind))
    tiles = {draw_tile(drawing, 40).tobytes() for _, drawing in states}
    assert len(tiles) == len(states)


@pytest.mark.parametrize(("fields", "rules"), [(CONSTANT, ""), (PLANTS, PICKED)])
def test_each_combination_is_in_the_legend(fields: str, rules: str) -> None:
    look = look_of("lane", fields, rules)
    entries = legend_entries(look)
    pictures = [entry for entry, _ in entries]
    for words, drawing in drawn(look.kinds[-1]):
        assert drawing in pictures, words
    assert len({text for _, text in entries}) == len(entries)


def test_the_legend_names_each_word_of_two_fields() -> None:
    texts = [text for _, text in legend_entries(look_of("lane", CONSTANT))]
    assert texts == ["ground", "lane", "west", "south", "west, south"]


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("lane.crop is leek", "leek"),
        ("lane.crop is not leek", "not leek"),
        ("lane.crop is leek or lane.state is wet", "leek or wet"),
        ("(lane.crop is leek or lane.crop is kale) and lane.eggs > 2", "leek or kale, eggs over 2"),
        ("lane.crop in { leek, kale } and lane.eggs == 2", "leek or kale, eggs 2"),
        ("not (lane.crop in { leek, kale })", "not leek or kale"),
        ("lane.eggs > 0", "some eggs"),
        ("lane.eggs == 0", "no eggs"),
        ("lane.eggs >= 3 and lane.eggs <= 4", "eggs at least 3, eggs at most 4"),
        ("lane.eggs in 2 .. 4", "eggs 2 to 4"),
        ("lane.eggs < lane.nests", "eggs under nests"),
        ("lane.owner is nobody", "no owner"),
        ("lane.owner is not nobody and not (lane.fans is nobody)", "owner, fans"),
        ("lane.store[hay] > 0", "store: hay"),
        ("lane.store[hay] > lane.store[oats]", "store: more hay than oats"),
        ("lane.store[hay] < 3", "store: hay under 3"),
        ("sum(lane.store) > 5", "all store over 5"),
        ("full(lane)", "eggs 9 or nests 9"),
    ],
)
def test_conditions_are_said_in_words(condition: str, words: str) -> None:
    fields = """field crop : { none, leek, kale } = none  field state : { dry, wet } = dry  field eggs : 0 .. 9 = 1  field nests : 0 .. 9 = 1
      field owner : agent  field fans : set of agent  field store by { hay, oats } : 0 .. 9 = 0"""
    text = GAME.format(
        kind="lane",
        fields=fields,
        rules="",
        looks=f"look lane where {condition} as red",
        shown="",
        agents=AGENTS,
    )
    game = build(
        Source(
            "lot.sj",
            text.replace(
                "observe", "define full(place) = place.eggs == 9 or place.nests == 9  observe"
            ),
        )
    ).game
    (look,) = game.looks
    assert look.condition is not None
    assert in_words(look.condition) == words
