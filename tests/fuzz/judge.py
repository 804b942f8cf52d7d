"""What becomes of a program: refused, with which codes; or compiled in every way and played, and what went wrong."""

import re
import shutil
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sjdsl.compiler import Build, build, ir, lower_build
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.library.factory import load_module
from sjdsl.runtime.env import Environment
from tests.fuzz.policies import different_choice
from tests.fuzz.printed import changed_by_layout
from tests.fuzz.programs import Program
from tests.fuzz.sides import on_some_side
from tests.fuzz.together import (
    History,
    OnNumPy,
    Play,
    forms,
    interpret,
    jitted,
    module_text,
    moments,
    of_text,
    random_play,
    run,
)
from tests.verify_ir import verify

# What a generated text may be refused for: things its generator does not look at closely.
FORESEEN = {
    "SJ101": "a variant drops a define that is used",
    "SJ108": "a variant changes an entry of what it has changed",
    "SJ109": "two variants change one thing differently",
    "SJ113": "a variant drops a define that a check speaks of",
    "SJ115": "a variant says one thing twice",
    "SJ203": "a `case` of a number with fewer values than its generator knows",
    "SJ204": "several guarded adds reach one field",
    "SJ205": "a word of a phase's use that the field does not have",
    "SJ206": "a word of a phase's use compared with words it is none of",
    "SJ207": "a define used where its guard does not stand",
    "SJ212": "a variant breaks a requirement",
    "SJ213": "found a fraction: a sum that the compiler, unlike its generator, knows to stay within 0 and 1",
    "SJ214": "an episode whose length is a parameter, of 0 steps",
    "SJ303": "a variant's map has too few cells",
    "SJ401": "two writes that may disagree",
    "SJ402": "set and add",
    "SJ403": "two destinations",
    "SJ404": "a destination that may be full",
    "SJ511": "a variant changes the number of agents",
    "SJ502": "a variant adds a timer, and no tick",
    "SJ508": "a define that asks for a place, used in `phase start`",
    "SJ517": "a split that leaves nothing on a side",
    "SJ601": "a stated limit",
}
IN_VARIANTS = 15  # steps that are played in each variant
TRACED = 3  # one program in so many is traced: it takes as long as all else


@dataclass(frozen=True)
class Manner:
    """How a program is played; see `judge`."""

    seed: int
    steps: int
    jit: bool = False
    strict: bool = False


@dataclass
class Verdict:
    """One variant of a program. `codes`: why it is refused; `fault`: what went wrong, empty if nothing did."""

    variants: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()
    messages: tuple[str, ...] = ()
    fault: str = ""
    steps: int = 0
    game: ir.Game | None = None

    @property
    def accepted(self) -> bool:
        return not self.codes and self.game is not None

    @property
    def sort(self) -> str:
        """The fault without what differs from program to program: to tell one from another, and to keep it while shrinking."""
        head = self.fault.split("\n")[0]
        return re.sub(r"\(.*|\[.*|[0-9]+|step : ", "", head)[:60]


@contextmanager
def written(program: Program) -> Iterator[Source]:
    """Writes a program into a folder of its own while it is looked at."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz"))
    try:
        for name, text in program.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        yield Source("game.sj", program.text, folder)
    finally:
        shutil.rmtree(folder)


def judge(
    program: Program, seed: int, steps: int = 50, jit: bool = False, strict: bool = True
) -> list[Verdict]:
    """Returns what becomes of a program without a variant and, more briefly, in each of them.

    strict: one program in `TRACED` is also traced by JAX. jit: also run there.
    """
    strict = strict and seed % TRACED == 0
    with written(program) as source:
        plain = _judge_one(source, (), Manner(seed, steps, jit, strict))
        brief = Manner(seed, min(steps, IN_VARIANTS))
        others = [_judge_one(source, (name,), brief) for name in program.variants]
        if plain.accepted and plain.game is not None and not plain.fault:
            plain.fault = changed_by_layout(program, source, plain.game)
    return [plain, *others]


def _judge_one(source: Source, variants: tuple[str, ...], manner: Manner) -> Verdict:
    verdict = Verdict(variants)
    try:
        made = build(source, variants)
        verdict.game = verify(made.game)
        made = replace(made, game=verify(on_some_side(made.game, manner.seed)))
        lower_build(made, source)
    except CompileError as refused:
        errors = [d for d in refused.diagnostics if d.severity == "error"]
        verdict.codes = tuple(dict.fromkeys(d.code for d in errors))
        verdict.messages = tuple(
            f"{d.code} {d.span.file}:{d.span.line} {d.message}" for d in errors
        )
        unforeseen = [
            m
            for m in verdict.messages
            if m[:5] not in FORESEEN or (m[:5] == "SJ213" and not m.endswith("found a fraction"))
        ]
        verdict.fault = f"unforeseen {unforeseen[0]}" if unforeseen else ""
        return verdict
    except Exception as error:
        verdict.fault = f"compiler: {_told(error)}"
        return verdict
    try:
        _play(verdict, made, manner)
    except Exception as error:
        verdict.fault = verdict.fault or f"{_told(error)}"
    return verdict


def _play(verdict: Verdict, made: Build, manner: Manner) -> None:
    game = made.game
    play = random_play(game, manner.seed, manner.steps)
    history = interpret(game, play)
    text = module_text(game)
    env = of_text(game, text)
    report = run(env, play, history)
    verdict.steps = report.steps
    verdict.fault = report.differences[0] if report.differences else ""
    if manner.strict and not verdict.fault and game.policies:
        verdict.fault = _choices(game, env, play, history)
    if manner.strict and not verdict.fault:
        changed = forms(on_jax(game, text))
        verdict.fault = f"the state changes its form: {changed[0]}" if changed else ""
    if manner.jit and not verdict.fault:
        verdict.fault = _on_jax(game, text, play, history)


def _choices(game: ir.Game, env: OnNumPy, play: Play, history: History) -> str:
    """Returns where policies choose differently when they are compiled."""
    at = range(0, min(len(history.moments), 16), 3)
    states = [state for state, *_ in moments(env, play, min(len(history.moments), 16))]
    return different_choice(
        game,
        env,
        [states[i + 1] for i in at],
        [history.moments[i].ended for i in at],
        play.start[0],
    )


def _on_jax(game: ir.Game, text: str, play: Any, history: Any) -> str:
    other = random_play(game, 1 + play.start[0] % 1000, len(play.keys))
    plays, histories = [play, other], [history, interpret(game, other)]
    differences = jitted(on_jax(game, text), plays, histories)
    return f"on JAX, {differences[0]}" if differences else ""


def on_jax(game: ir.Game, text: str) -> Environment:
    """Returns the environment of a game with this module."""
    module = load_module(text, f"<{game.name}>", game.name)
    return Environment(module, module.default_params(), game=game)


def _told(error: Exception) -> str:
    """Returns an error as its type, text and the last places of our own code it went through."""
    places = [
        f
        for f in traceback.extract_tb(error.__traceback__)
        if "/sjdsl/" in f.filename or "on NumPy" in f.filename or "<" in f.filename
    ]
    last = places[-1] if places else None
    where = f" at {Path(last.filename).name}:{last.name}" if last else ""
    return f"{type(error).__name__}{where}: {str(error)[:300]}"


__all__ = ["FORESEEN", "Verdict", "field", "judge"]
