"""The hash of a game: of what its rules say, in words of this file alone.

What is hashed is JSON: a node of the IR is a list, its tag and then what the rules say of it by
name:

    set soil.fruit = ripe   ->   ["set", {"target": ["read", {"name": "fruit", "owner": …}],
                                          "value": ["word", {"value": "ripe"}]}]

Tags and names stand in `HASHED`, so that classes and fields of the IR can be renamed: then the left
side of a line changes, or `name=field` says what the field is called now, and `name=field.part`
that only this part of it is hashed. Types that are inferred, their intervals among them, are not
hashed. Of an optional field only what is not its default is: a new one leaves the hashes of games
without it as they are.
"""

import json
from functools import cache
from hashlib import sha256
from operator import attrgetter
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.printer import game_text as ir_text

HASHED: dict[type[ir.Node | ir.Type], str] = {
    # expressions
    ir.Number: "number value",
    ir.Word: "word value",
    ir.Truth: "truth value",
    ir.Nobody: "nobody",
    ir.Nowhere: "nowhere",
    ir.ParamRef: "param name",
    ir.Member: "member name who=entity_type.what kinds=entity_type.names",
    ir.Local: "local name",
    ir.FieldRead: "read name owner",
    ir.Attribute: "attribute name owner",
    ir.Distance: "distance left right",
    ir.Bearing: "bearing fn left right",
    ir.At: "at row key",
    ir.Step: "step",
    ir.Arithmetic: "arithmetic fn args",
    ir.Compare: "compare fn left right",
    ir.Same: "same left right",
    ir.InRange: "in_range value low high",
    ir.InWords: "in_words value words",
    ir.InSet: "in_set value container",
    ir.IsEmpty: "is_empty container",
    ir.Chose: "chose agent action",
    ir.ChoseWith: "chose_with agent action given",
    ir.Given: "given name value",
    ir.ArgumentOf: "argument_of agent action number",
    ir.Unoccupied: "unoccupied cell",
    ir.StandsOn: "stands_on agent kinds",
    ir.StandsAt: "stands_at agent cell",
    ir.Not: "not value",
    ir.Logic: "logic fn args",
    ir.Count: "count domain",
    ir.Sum: "sum value domain",
    ir.SumRow: "of_row row fn",
    ir.ShiftRow: "shift_row row by filler",
    ir.Extreme: "extreme fn value domain otherwise",
    ir.Case: "case subject arms",
    ir.Arm: "arm low high words value",
    ir.Lowest: "lowest row last",
    ir.Mix: "mix row",
    ir.MatrixClass: "matrix_class name table",
    # domains
    ir.Domain: "domain var on restriction where",
    ir.Near: "near shape anchor",
    ir.InAgents: "in_agents value",
    ir.InCell: "in_cell value",
    ir.Among: "among members",
    ir.Shape: "shape name lanes see_through directed",
    # statements
    ir.Let: "let name value",
    ir.Draw: "draw name low high words numbers weights by different stream",
    ir.Each: "each domain body",
    ir.Pick: "pick number most domain body otherwise stream",
    ir.First: "first domain body",
    ir.Match: "match left right first body stream",
    ir.When: "when branches otherwise",
    ir.Chance: "chance branches otherwise stream",
    ir.Branch: "branch test body",
    ir.Set: "set target value lot",
    ir.Add: "add target value",
    ir.Give: "give value receiver but",
    ir.Tally: "tally event word amount receiver",
    ir.Send: "send who domain after facing way stay order_stream=cell_stream heading_stream",
    ir.Shift: "shift who to steps heading other quarters facing way stream heading_stream",
    ir.Face: "face who heading",
    ir.Remove: "remove who",
    ir.Move: "move domain course stream",
    ir.Wander: "wander goal away avoided stream",
    ir.Along: "along heading",
    ir.Mark: "mark shape anchor",
    ir.End: "end",
    # declarations
    ir.Type: "type kind words kinds unit low high by=indexed_by",
    ir.Param: "param name type value",
    ir.VarField: "field name type capped timer start",
    ir.Block: "block what condition",
    ir.Kind: "kind name glyph fields blocks",
    ir.GlyphMeaning: "glyph glyph kind starts",
    ir.ActionArgument: "argument name type",
    ir.ActionWithArguments: "action name arguments",
    ir.Forbid: "forbid actions condition",
    ir.Agents: "agents number actions relative fields forbids blocks with_arguments",
    ir.Movers: "movers name number glyph fields",
    ir.Phase: "phase label body marks",
    ir.Tick: "tick",
    ir.Kept: "kept held_by=held_by.what kinds=held_by.names name",
    ir.Trials: "trials number kept",
    ir.Task: "task draw train_on hold_outs",
    ir.TrainOn: "train_on number seed",
    ir.HoldOut: "hold_out condition",
    ir.Event: "event name by shown",
    ir.Measure: "measure name mean value",
    ir.Label: "label name condition",
    ir.Observable: "observable what kind field word type value labels hidden_when shown_when",
    ir.Hidden: "hidden what on name kinds when",
    ir.Window: "window ahead behind left right views",
    ir.View: "view ahead behind left right condition",
    ir.Check: "check sort=kind values",
    # beside the rules
    ir.Paint: "paint colour sprite",
    ir.Look: "look what name kinds condition body badge",
    ir.ScriptedPolicy: "policy name rules",
    ir.Act: "act on condition action given",
    ir.Go: "go on condition domain avoided",
    ir.Aim: "aim on condition shape domain avoided action given",
}
RULES = (
    "name",
    "params",
    "episode",
    "kinds",
    "rows",
    "edges",
    "glyphs",
    "fields",
    "agents",
    "movers",
    "shapes",
    "start",
    "schedule",
    "window",
    "observables",
    "hidden",
    "events",
    "measures",
)
OPTIONAL = ("trials", "task", "starting")  # hashed if there are any


def game_hash(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits that two games share if and only if their rules say the same.

    Left out is what changes nothing that happens: positions, the title, `cite`, `about`, names of
    sizes, groups, defines and variants, looks, policies, scenarios, and checks other than
    `require`, which says what parameters there can be.
    """
    return _digest(_rules(game))


def picture_hash(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits of what a picture of a game shows: the rules and the looks."""
    return _digest({**_rules(game), "looks": _hashable(game.looks)})


def policy_hash(policy: ir.ScriptedPolicy) -> str:
    """Returns 64 hexadecimal digits of the rules of a policy."""
    return sha256(_text(_hashable(policy)).encode()).hexdigest()


def printed_digest(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits of the printed IR, positions aside.

    For caches, since another version of the compiler prints other text.
    """
    return sha256(ir_text(game).encode()).hexdigest()[:16]


def _rules(game: ir.Game) -> dict[str, Any]:
    """Returns what the rules of a game say, as JSON."""
    required = tuple(check for check in game.checks if check.kind == "require")
    return {
        "requires": _hashable(required),
        **{name: _hashable(getattr(game, name)) for name in RULES},
        **{name: _hashable(part) for name in OPTIONAL if (part := getattr(game, name))},
    }


def _hashable(value: object) -> Any:
    """Returns a part of the rules as JSON."""
    match value:
        case ir.Named() | ir.Narrowed():
            # What a define or a guard has made of an expression says nothing more.
            return _hashable(value.value)
        case ir.Node() | ir.Type():
            tag, fields = _hashed_form(type(value))
            hashed = {}
            for name, field, default in fields:
                part = attrgetter(field)(value)
                if part != default:
                    hashed[name] = _hashable(part)
            return [tag, hashed]
        case ir.Entry():
            return value.name
        case ir.IndexSet():
            return list(value.names)
        case tuple():
            return [_hashable(item) for item in value]
        case _:
            return value


@cache
def _hashed_form(kind: type[ir.Node | ir.Type]) -> tuple[str, tuple[tuple[str, str, object], ...]]:
    """Returns the tag of a class, and its hashed fields.

    Of each: its name in the hash, where to find it, and the default that is left out.
    """
    tag, *names = HASHED[kind].split()
    # `name=field`, or `name` alone, which is then also the field's
    pairs = [(name.partition("=")[0], name.rpartition("=")[2]) for name in names]
    return tag, tuple((name, field, _default(kind, field)) for name, field in pairs)


def _default(kind: type[ir.Node | ir.Type], field: str) -> object:
    """Returns the default of a field; () for `part.names`, as no names are hashed."""
    name, _, part = field.partition(".")
    return () if part == "names" else kind.model_fields[name].default


def _text(hashable: object) -> str:
    return json.dumps(hashable, sort_keys=True, separators=(",", ":"))


def _digest(hashable: object) -> str:
    return sha256(_text(hashable).encode()).hexdigest()[:16]
