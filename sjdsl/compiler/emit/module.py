"""Emits the text of a Python module from an array program; the template only prints."""

import hashlib
from functools import cache
from importlib.resources import files
from pathlib import PurePosixPath

import jinja2
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import KERNELS
from sjdsl.compiler.ir.printer import game as ir_text
from sjdsl.compiler.lower import token_planes
from sjdsl.compiler.program import Attribute, Constant, Function, Line, Program
from sjdsl.version import __version__

FORBIDDING = (
    "allowed = jnp.take_along_axis(allowed_actions(state, params), actions[:, None], axis=1)[:, 0]",
    "actions = jnp.where(allowed, actions, STAY)",
)


@cache
def template(name: str) -> jinja2.Template:
    """Returns one of the templates of generated files."""
    text = files("sjdsl.compiler.emit").joinpath(f"templates/{name}").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    return environment.from_string(text)


def game_hash(game: ir.Game) -> str:
    """Returns 16 hexadecimal digits that two games share if and only if their IR is equal (positions, `cite`, `about` and `look` aside)."""
    rules = game.model_copy(update={"cites": (), "about": (), "looks": ()})
    return hashlib.sha256(ir_text(rules).encode()).hexdigest()[:16]


def render(program: Program, game: ir.Game) -> str:
    """Returns the module's text."""
    used = {word for f in program.functions for line in f.lines for word in _words(line.text)}
    used |= {word for c in program.constants for word in _words(c.text)}
    used |= {word for _, value in program.facts for word in _words(value)} | {"TokenPlane"}
    imports = [
        f"from {module} import {', '.join(n for n in names if n in used)}"
        for module, names in KERNELS.items()
        if any(n in used for n in names)
    ]
    facts = [(name, value) for name, value in program.facts if name != "SCHEDULE"]
    facts.insert(2, ("HASH", repr(game_hash(game))))
    turns = next(value for name, value in program.facts if name == "SCHEDULE").split(", ")
    marks = [a.name for a in program.state if a.name.startswith("mark_")]
    cleared = [f"state = state.replace({', '.join(f'{m}=jnp.zeros_like(state.{m})' for m in marks)})"] if marks else []
    return template("module.py.j2").render(
        program=program,
        headline=f"{_escaped(program.title or program.name)}: State, Params, reset, one function a phase, step, observe.",
        version=__version__,
        hash=game_hash(game),
        imports=sorted(imports),
        facts=facts,
        planes=[repr(p) for p in token_planes(game)],
        map_rows=[repr(row) for row in game.rows],
        constants=[_constant(c) for c in program.constants],
        params=[_attribute(a) for a in program.params] or ["pass"],
        state=[_attribute(a) for a in program.state],
        outcome=[_attribute(a) for a in program.outcome],
        param_defaults=[f"{a.name}={a.default}" for a in program.params],
        state_defaults=[f"{a.name}={a.default}" for a in program.state],
        outcome_defaults=[f"{a.name}={a.default}" for a in program.outcome],
        forbidding=FORBIDDING if game.agents.forbids else (),
        cleared=cleared,
        turns=[t for t in turns if t],
        functions=[_function(f) for f in program.functions],
    )


def _words(text: str) -> set[str]:
    import re

    return set(re.findall(r"[A-Za-z_][A-Za-z0-9_]*", text))


def _escaped(text: str) -> str:
    """Returns a title as it may stand in a docstring: printable ASCII without quotes and backslashes."""
    return "".join(c if c.isascii() and c.isprintable() and c not in "\"\\'" else "?" for c in text)


def _commented(text: str) -> str:
    """Returns a text as it may stand in a comment: one line of printable ASCII."""
    return "".join(c if c.isascii() and c.isprintable() else "?" for c in text)


def _attribute(a: Attribute) -> str:
    return f"{a.name}: Array  # {a.dtype.rstrip('_')}{a.shape}  {_commented(a.comment)}"


def _constant(c: Constant) -> str:
    if c.text:
        return f"{c.name} = jnp.asarray({c.text})  # {_commented(c.comment)}"
    values = np.array2string(c.value, separator=", ", threshold=c.value.size + 1, max_line_width=110)
    dtype = "bool" if c.value.dtype == bool else f"jnp.{c.value.dtype}"
    return f"{c.name} = jnp.asarray({values}, {dtype})  # {_commented(c.comment)}"


def _function(f: Function) -> dict[str, object]:
    result = {"allowed_actions": "Array", "measures": "dict[str, Array]", "episode_length": "Array", "observe": "Array"}
    returns = result.get(f.name, "tuple[State, Outcome]")
    return {"head": f"{f.name}({f.arguments}) -> {returns}", "doc": f.doc, "lines": [_line(x) for x in f.lines]}


def _line(line: Line) -> str:
    if line.origin is None:
        return line.text
    return f"{line.text}  # {_commented(PurePosixPath(line.origin.file).name)}:{line.origin.line}"
