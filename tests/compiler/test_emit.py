"""Emission: what is printed is what was meant, in lines that fit."""

import ast
import re
from typing import Any

import jax
import jax.numpy as jnp
from hypothesis import given, settings
from hypothesis import strategies as st

from sjdsl.compiler import compile_source
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.emit.expressions import PYTHON_PRECEDENCE, text
from sjdsl.compiler.emit.layout import WIDTH
from sjdsl.compiler.emit.statements import statement_lines
from sjdsl.compiler.program.expressions import (
    DTYPES,
    Arange,
    Assign,
    Attribute,
    Binary,
    Broadcast,
    Call,
    Cast,
    Index,
    Lambda,
    Literal,
    Mapping,
    Name,
    Sequence,
    Slice,
    Unary,
    Where,
    path,
)
from sjdsl.library.factory import load_module

OPERATORS: dict[str, type[ast.operator] | type[ast.cmpop] | type[ast.unaryop]] = {
    "+": ast.Add, "-": ast.Sub, "*": ast.Mult, "/": ast.Div, "//": ast.FloorDiv, "%": ast.Mod,
    "&": ast.BitAnd, "|": ast.BitOr, "^": ast.BitXor, "<<": ast.LShift, ">>": ast.RShift,
    "<": ast.Lt, "<=": ast.LtE, ">": ast.Gt, ">=": ast.GtE, "==": ast.Eq, "!=": ast.NotEq,
}  # fmt: skip


def meant(node: Any) -> ast.expr:
    """Returns the tree that Python must read: written from the meaning of each node, without a thought of brackets."""
    load = ast.Load()
    match node:
        case Name(identifier=name):
            return ast.Name(name, load)
        case Literal(name=str(name)) if name:
            return ast.Name(name, load)
        case Literal(value=bool() | None | str() as value):
            return ast.Constant(value)
        case Literal(value=int() | float() as value):
            return (
                ast.Constant(value)
                if not str(value).startswith("-")
                else ast.UnaryOp(ast.USub(), ast.Constant(-value))
            )
        case Literal(value=value):
            return ast.Constant(value)
        case Attribute(value=value, name=name):
            return ast.Attribute(meant(value), name, load)
        case Call(function=function, arguments=arguments, keywords=keywords):
            named = [ast.keyword(name, meant(value)) for name, value in keywords]
            return ast.Call(meant(function), [meant(a) for a in arguments], named)
        case Slice(start=start, stop=stop):
            return ast.Slice(
                None if start is None else meant(start), None if stop is None else meant(stop)
            )
        case Index(value=value, keys=keys):
            key = meant(keys[0]) if len(keys) == 1 else ast.Tuple([meant(k) for k in keys], load)
            return ast.Subscript(meant(value), key, load)
        case Unary(op=op, operand=operand):
            return ast.UnaryOp(ast.Invert() if op == "~" else ast.USub(), meant(operand))
        case Binary(op=op, left=left, right=right):
            made = OPERATORS[op]()
            if isinstance(made, ast.cmpop):
                return ast.Compare(meant(left), [made], [meant(right)])
            return ast.BinOp(meant(left), made, meant(right))  # type: ignore[arg-type]
        case Where(condition=condition, then=then, otherwise=otherwise):
            return meant(Call(path("jnp.where"), (condition, then, otherwise)))
        case Cast(value=value, dtype=dtype):
            return meant(Call(Attribute(value, "astype"), (DTYPES[dtype],)))
        case Broadcast(value=value, shape=shape):
            return meant(Call(path("jnp.broadcast_to"), (value, Sequence(shape))))
        case Arange(size=size, dtype=dtype):
            return meant(
                Call(
                    path("jnp.arange"),
                    (size,),
                    () if dtype is None else (("dtype", DTYPES[dtype]),),
                )
            )
        case Sequence(items=items, is_list=is_list):
            return (ast.List if is_list else ast.Tuple)([meant(i) for i in items], load)
        case Mapping(entries=entries):
            return ast.Dict([ast.Constant(k) for k, _ in entries], [meant(v) for _, v in entries])
        case Lambda(parameters=parameters, body=body):
            arguments = ast.arguments([], [ast.arg(p) for p in parameters], None, [], [], None, [])
            return ast.Lambda(arguments, meant(body))
    raise AssertionError(node)


NAMES = st.sampled_from(["state", "position", "heading", "beam_cells", "orchard_fruit", "x"])
LEAVES = st.one_of(
    NAMES.map(Name),
    st.integers(-3, 300).map(Literal),
    st.sampled_from([0.5, -1.0, 1e-05, 3e20]).map(Literal),
    st.sampled_from([True, None, ..., "drop", "it's", 'a "b"\\']).map(Literal),
    st.integers(0, 9).map(lambda n: Literal(n, "NUM_WATER")),
)


@st.composite
def trees(draw: st.DrawFn, depth: int = 4) -> Any:
    """Draws an expression of at most so many levels."""

    def tree(levels: int) -> Any:
        if levels == 0 or draw(st.integers(0, 5)) == 0:
            return draw(LEAVES)

        def below() -> Any:
            return tree(levels - 1)

        def some(least: int = 0) -> tuple[Any, ...]:
            return tuple(below() for _ in range(draw(st.integers(least, 3))))

        def keys() -> tuple[Any, ...]:
            slices = [Slice(), Slice(None, draw(LEAVES)), Slice(draw(LEAVES), None)]
            return tuple(draw(st.sampled_from([key, *slices])) for key in some(1))

        dtype, name = draw(st.sampled_from(list(DTYPES))), draw(NAMES)
        kinds = (
            *[lambda: Binary(draw(st.sampled_from(sorted(PYTHON_PRECEDENCE))), below(), below())]
            * 5,
            lambda: Unary(draw(st.sampled_from("~-")), below()),
            lambda: Attribute(below(), name),
            lambda: Index(below(), keys()),
            lambda: Call(below(), some(), (("keyword", below()),)),
            lambda: Where(below(), below(), below()),
            lambda: Cast(below(), dtype),
            lambda: Broadcast(below(), some()),
            lambda: Arange(below(), dtype),
            lambda: Sequence(some(), draw(st.booleans())),
            lambda: Mapping(((name, below()),)),
            lambda: Lambda(("key",), below()),
        )
        return draw(st.sampled_from(kinds))()

    return tree(depth)


def read(lines: str) -> str:
    statement = ast.parse(lines).body[0]
    assert isinstance(statement, ast.Assign)
    return ast.dump(statement.value)


@settings(max_examples=60, deadline=None)
@given(trees())
def test_one_line_is_read_as_it_was_meant(node: Any) -> None:
    assert read(f"found = {text(node)}") == ast.dump(meant(node))


@settings(max_examples=60, deadline=None)
@given(trees())
def test_broken_lines_are_read_as_they_were_meant_and_fit(node: Any) -> None:
    lines = statement_lines(Assign(("found",), node), indent=0)
    assert read("\n".join(lines)) == ast.dump(meant(node))
    if (
        len(re.sub(r"[^([{]", "", text(node))) < 12
    ):  # brackets deep in brackets may be indented beyond any width
        assert max(map(len, lines)) <= WIDTH


MANY = """sj 1
game many "Many arms" {{
  episode 10
  kind grass "."
  map {{ "...." }}
  agents 2 {{ acts stay  field bag : 0 .. 250 = 0 }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule change
  phase change {{
    each agent {{ set agent.bag = case agent.bag {{ {arms}, otherwise : 3 }} }}
  }}
  metrics {{ }}
}}
"""


def test_many_arms_do_not_pile_up_brackets() -> None:
    """Python refuses more than 200 brackets inside each other."""
    arms = ",\n".join(f"{i} : {i * i % 251}" for i in range(250))
    module_text = compile_source(Source("many.sj", MANY.format(arms=arms)))
    assert max(map(len, module_text.splitlines())) <= WIDTH
    module = load_module(module_text, "<many>", "many")
    bags = jnp.arange(252, dtype=jnp.uint8).clip(0, 250).reshape(126, 2)

    def after(bag: Any) -> Any:
        key, params = jnp.zeros(2, jnp.uint32), module.default_params()
        state = module.initial_state().replace(agent_bag=bag)
        return module.step(state, jnp.zeros(2, jnp.int32), params, key)[0].agent_bag

    found = jax.jit(jax.vmap(after))(bags).reshape(-1)
    assert found.tolist()[:251] == [i * i % 251 if i < 250 else 3 for i in range(251)]
