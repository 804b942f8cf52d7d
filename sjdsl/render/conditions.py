"""The conditions of looks in words, for legends.

`agent.health == 2` becomes `health 2`, `tree.fruit is ripe` becomes `ripe`.
"""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.equivalence import form
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.printer import number_text

COMPARISONS = {
    "==": "{} {}",
    "!=": "{} not {}",
    "<": "{} under {}",
    "<=": "{} at most {}",
    ">": "{} over {}",
    ">=": "{} at least {}",
}
REDUCTIONS = {"sum": "all {}", "min": "least {}", "max": "most {}"}


def in_words(condition: ir.Expr) -> str:
    """Returns what a condition says of its cell, agent or mover; "" if it always holds."""
    return ", ".join(filter(None, map(_part, conjuncts(condition))))


def _part(e: ir.Expr) -> str:
    """Returns a condition in words. It isn't an `and`, except inside another condition."""
    match e:
        case ir.Same(left=ir.Word(value=word)) | ir.Same(right=ir.Word(value=word)):
            return word
        case ir.InWords(words=words):
            is_any = set(words) == set(e.value.type.words)
            return "" if is_any else " or ".join(words)
        case ir.Same(left=left, right=ir.Nobody() | ir.Nowhere()) | ir.IsEmpty(container=left):
            return f"no {_value(left)}"
        case ir.Not(
            value=ir.Same(left=left, right=ir.Nobody() | ir.Nowhere()) | ir.IsEmpty(container=left)
        ):
            return _value(left)
        case ir.Same(left=left, right=right):
            return f"{_value(left)} same as {_value(right)}"
        case ir.Not(value=ir.Same(left=left, right=right)) if not isinstance(right, ir.Word):
            return f"{_value(left)} other than {_value(right)}"
        case ir.Compare(fn=">", left=ir.At() as entry, right=ir.Number(value=0)):
            return _value(entry)
        case ir.Compare(fn=">", left=left, right=ir.Number(value=0)):
            return f"some {_value(left)}"
        case ir.Compare(fn="==", left=left, right=ir.Number(value=0)):
            return f"no {_value(left)}"
        case ir.Compare(
            fn=">" | "<" as fn,
            left=ir.At(row=field, key=key),
            right=ir.At(row=other_field, key=other_key),
        ) if form(field) == form(other_field):
            comparison = "more" if fn == ">" else "less"
            return f"{_value(field)}: {comparison} {_value(key)} than {_value(other_key)}"
        case ir.Compare(fn=fn, left=left, right=right):
            return COMPARISONS[fn].format(_value(left), _value(right))
        case ir.InRange(value=value, low=low, high=high):
            return f"{_value(value)} {_value(low)} to {_value(high)}"
        case ir.Logic(fn="or", args=args):
            return " or ".join(map(in_words, args))
        case ir.Not(value=value):
            return f"not {in_words(value)}"
        case ir.Logic():
            return in_words(e)
        case _:
            return _value(e)


def _value(e: ir.Expr) -> str:
    """Returns a value in words: a field without its owner."""
    match e:
        case ir.FieldRead(name=name) | ir.Named(name=name) | ir.Member(name=name):
            return name
        case ir.At(row=row, key=key):
            return f"{_value(row)}: {_value(key)}"
        case ir.Number(value=value):
            return number_text(value)
        case ir.Word(value=word):
            return word
        case ir.SumRow(fn=fn, row=row):
            return REDUCTIONS[fn].format(_value(row))
        case ir.Narrowed(value=value):
            return _value(value)
        case _:
            raise AssertionError(e)  # the compiler refuses every other expression in a `look`
