"""Runs parts of a game on the reference interpreter: the scenes in which a phase does something, and tests of single checks."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from time import monotonic

from lsprotocol import types

from sjdsl.compiler import Build, build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.editor.analysis import Analysis
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.overflow import LeavesFloat32
from sjdsl.interpreter.state import default_params
from sjdsl.properties import Effort, GameFamily, Verdict, Verification
from sjdsl.properties.engines import EpisodeRunner
from sjdsl.properties.trajectory import play as play_scenario
from sjdsl.properties.verify_properties import decide_statically
from sjdsl.render.letters import draw
from sjdsl.trace.episode import Moment, Told, play, random_actions
from sjdsl.trace.lines import Teller, is_shown, make_teller, turn_lines
from sjdsl.trace.rules import Rules

STEPS = 60  # of random play in which a phase is looked for
SCENES = 3  # shown
SECONDS = 10.0  # at most, for the episodes of one check
QUICK = Effort(examples=60, compiled=False)  # no whole episodes: the interpreter plays these in seconds


@dataclass(frozen=True)
class Result:
    """What a run found. `summary`: a sentence; `text`: all of it; `marks`: messages for places of the text, until it changes."""

    summary: str
    text: str = ""
    failed: bool = False
    marks: tuple[types.Diagnostic, ...] = field(default=())


def variant_of(analysis: Analysis, phase: str) -> tuple[str, ...] | None:
    """Returns the first variant whose schedule has a phase, the game itself before all; None where none can be compiled and has it."""
    for names in analysis.choices:
        made = _built(analysis, names)
        if made is not None and (phase == "start" or any(isinstance(t, ir.Phase) and t.name == phase for t in made.game.schedule)):
            return names
    return None


def _built(analysis: Analysis, variants: tuple[str, ...]) -> Build | None:
    try:
        return analysis.build if not variants else build(analysis.source, variants)
    except CompileError:
        return None


def run_phase(analysis: Analysis, phase: str, seed: int = 0, steps: int = STEPS) -> Iterator[Result | None]:
    """Plays with random actions and yields None after each step, at last what a phase did: the first scenes in which it changed something."""
    variants = variant_of(analysis, phase)
    made = None if variants is None else _built(analysis, variants)
    if made is None or variants is None:
        yield Result(f"phase `{phase}` cannot be run: the game has errors, or no schedule has it", failed=True)
        return
    teller = make_teller(board_of(made.game), Rules(made.sources), (phase,))
    scenes: list[str] = []
    acted = played = 0
    never: set[Span] | None = None
    before: list[str] = []
    try:
        for moment in play(made.game, default_params(made.game), seed, 0 if phase == "start" else steps, random_actions(made.game)):
            turns = [turn for turn in moment.turns if is_shown(turn, (phase,))]
            played += bool(turns)
            if any(turn.effects for turn in turns):
                acted += 1
                scenes += [_scene(moment, turns, before, teller)] if len(scenes) < SCENES else []
            idle = {s.origin for turn in turns for s in turn.never if s.origin is not None}
            never = never if not turns else idle if never is None else never & idle
            before = draw(teller.looks, teller.board, moment.world)
            yield None
    except LeavesFloat32 as left:
        yield Result(f"phase `{phase}`: a real leaves float32 in step {left.before}", "\n".join(scenes), True)
        return
    named = f" of variant `{variants[0]}`" if variants else ""
    counted = "when the episode begins" if phase == "start" else f"in {acted} of {played} steps with random actions"
    said = f"phase `{phase}`{named}: something changes {counted} (seed {seed})"
    idle_here = sorted((span for span in never or () if span.file == analysis.document.name), key=lambda span: span.start)
    told = f"did not happen in {played} {'step' if played == 1 else 'steps'} with random actions"
    marks = [(analysis.document.lines.span(span), told, types.DiagnosticSeverity.Information) for span in idle_here]
    yield Result(said, "\n".join([said, "", *scenes]), False, tuple(types.Diagnostic(*mark, source="sjdsl run") for mark in marks))


def _scene(moment: Moment, turns: list[Told], before: list[str], teller: Teller) -> str:
    """Returns one step as the phase saw and changed it: the map when the step began, what was done, the map behind the whole step."""
    head = "an episode begins" if moment.number is None else f"step {moment.number}"
    names = teller.board.game.agents.actions
    chosen = ", ".join(f"{agent} {names[action]}" for agent, action in enumerate(moment.actions))
    lines = [head, *(f"    {row}" for row in before), *([f"  actions  {chosen}"] if chosen else [])]
    for turn in turns:
        lines += turn_lines(turn, teller)
    return "\n".join([*lines, *(f"    {row}" for row in draw(teller.looks, teller.board, moment.world)), ""])


# ---- checks


def check_numbers(analysis: Analysis, start: int | None = None) -> tuple[list[int], tuple[str, ...]]:
    """Returns which checks of a game stand at a place, all without one; and the first variant that has them."""
    for names in analysis.choices:
        made = _built(analysis, names)
        checks = () if made is None else made.game.checks
        own = [(i, c.origin) for i, c in enumerate(checks) if c.origin is not None and c.origin.file == analysis.document.name]
        found = [i for i, origin in own if start is None or origin.start == start]
        if found:
            return found, names
    return [], ()


def run_checks(analysis: Analysis, start: int | None = None) -> Iterator[Result | None]:
    """Tests the check that begins at a character, or all of a game; yields None between steps, at last the verdicts."""
    numbers, variants = check_numbers(analysis, start)
    if not numbers:
        yield Result("nothing can be tested: the game has errors, or no check stands here", failed=True)
        return
    family = GameFamily(analysis.source, variants)
    verdicts: list[Verdict] = []
    for number in numbers:
        if family.own.checks[number].sort == "expect":
            for verdict in _expected(family, number):
                if verdict is not None:
                    verdicts.append(verdict)
                yield None
        else:
            verdicts.append(Verification(family, QUICK, {number}).verdict(number))
            yield None
    failed = [v for v in verdicts if v.passed is False]
    named = f" of variant `{variants[0]}`" if variants else ""
    said = f"{len(verdicts)} checks{named}: {len(failed) or 'none'} failed"
    if len(verdicts) == 1:
        said = f"`{verdicts[0].text}`{named}: {_status(verdicts[0])}"
    text = "\n".join(line for v in verdicts for line in (f"{_status(v)}  {v.text}", *(f"    {t}" for t in v.trace)))
    spans = [family.own.checks[number].origin for number in numbers]
    marks = tuple(_judged(v, span, analysis) for v, span in zip(verdicts, spans, strict=True) if span is not None)
    yield Result(said, text, bool(failed), marks)


def _status(v: Verdict) -> str:
    return f"{v.status}: {v.reason}"


def _judged(v: Verdict, span: Span, analysis: Analysis) -> types.Diagnostic:
    """Returns a verdict as a message at its check: an error with its counterexample where it failed."""
    severity = types.DiagnosticSeverity.Error if v.passed is False else types.DiagnosticSeverity.Information
    said = "\n".join([_status(v), *(f"this line never ran: {line}" for line in v.untested), *v.trace])
    return types.Diagnostic(analysis.document.lines.span(span), said, severity, source="sjdsl run")


def _expected(family: GameFamily, number: int) -> Iterator[Verdict | None]:
    """Plays the episodes of an `expect` on the interpreter, as many as there is time for; yields None between parts of them."""
    check, runner, end = family.own.checks[number], EpisodeRunner(family, QUICK.seed), monotonic() + SECONDS
    static = decide_statically(family, number)
    if static is not None:
        yield static
        return
    whole = 0
    while whole < check.episodes:
        if monotonic() > end:
            break
        trajectory = play_scenario(family.own, runner.scenario(check.policies, whole), runner.length, [check])
        yield None
        if not trajectory.values(check)[-1][0]:
            yield _verdict(family, number, False, f"fails at the end of episode {whole}")
            return
        whole += 1
    said = f"{whole} of {check.episodes} episodes on the interpreter; `sjdsl test` plays all of them"
    yield _verdict(family, number, True if whole else None, said)


def _verdict(family: GameFamily, number: int, passed: bool | None, said: str) -> Verdict:
    check = family.own.checks[number]
    assert check.origin is not None
    how = "episodes" if passed is not None else "not decided"
    return Verdict(family.text_of(check), check.origin.file, check.origin.line, passed, how, said)  # type: ignore[arg-type]
