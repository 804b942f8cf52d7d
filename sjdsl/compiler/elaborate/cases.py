"""Elaborates `case`: every value of the subject has exactly one arm (exhaustiveness)."""

from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.arithmetic import join_types
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.implications import narrow_word, narrowed
from sjdsl.compiler.ir.types import describe

Key = list[tuple[int | None, int | None, tuple[str, ...]]]  # of an arm: from, to, or the words


def case(e: ast.Case, scope: Scope) -> ir.Expr:
    """Returns a `case` whose arms cover the subject without gap or overlap; `otherwise` is spelt out."""
    subject = narrow_word(scope.expression(e.subject), scope.facts)
    if isinstance(subject, ir.Word):
        return _known_word(e, subject, scope)
    if subject.type.kind in ("word", "condition") and not subject.type.by:
        keys = _word_keys(e, subject, scope)
    elif subject.type.kind == "int" and not subject.type.by:
        keys = _number_keys(e, subject, scope)
    else:
        wanted = "a whole number, a word or a condition"
        raise scope.fail(
            errors.WrongType(e.subject.span, wanted=wanted, actual=describe(subject.type))
        )

    def values(arm_and_key: tuple[ast.Arm, Key]) -> list[ir.Arm]:
        arm, key = arm_and_key
        known: tuple[ir.Expr, ...] = ()
        if subject.type.kind == "condition" and len(key) == 1:  # what the arm may rely on
            known = (subject if key[0][2] == ("yes",) else ir.Not(value=subject),)
        value = scope.knowing(known).expression(arm.value)
        return [
            ir.Arm(low=low, high=high, words=words, value=value, origin=arm.span)
            for low, high, words in key
        ]

    made = scope.problems.each(zip(e.arms, keys, strict=True), values)
    if len(made) < len(e.arms):
        raise Poisoned
    arms = tuple(arm for several in made for arm in several)
    type_ = join_types([a.value.type for a in arms], scope, "choose between", e)
    return ir.Case(type=type_, subject=subject, arms=arms, origin=e.span)


def _known_word(e: ast.Case, subject: ir.Word, scope: Scope) -> ir.Expr:
    """The subject is a word known when compiled (what a phase is used with): its arm is the value, the others are only checked."""
    chosen: ir.Expr | None = None
    rest: ir.Expr | None = None
    for arm in e.arms:
        if arm.word is not None and not scope.static.is_word(arm.word.text):
            raise scope.fail(
                errors.WordOutside(
                    arm.word.span, word=arm.word.text, owner="this case", words=(subject.value,)
                )
            )
        value = scope.expression(arm.value)
        if arm.word is None:
            rest = value
            continue
        scope.static.refer(arm.word, Symbol("word", arm.word.text))
        if arm.word.text == subject.value:
            chosen = value
    found = chosen or rest
    if found is None:
        raise scope.fail(errors.CaseLacks(e.span, words=(subject.value,)))
    return found


def _word_keys(e: ast.Case, subject: ir.Expr, scope: Scope) -> list[Key]:
    names = ("yes", "no") if subject.type.kind == "condition" else subject.type.words
    seen: set[str] = set()
    keys: list[Key] = []
    for arm in e.arms:
        if arm.low is not None:
            raise scope.fail(errors.NumberForWord(arm.span))
        if arm.word is None:
            keys.append([])
            continue
        if arm.word.text not in names:
            raise scope.fail(
                errors.WordOutside(
                    arm.word.span, word=arm.word.text, owner="this case", words=names
                )
            )
        if arm.word.text in seen:
            raise scope.fail(errors.CaseRepeats(arm.word.span, name=arm.word.text))
        seen.add(arm.word.text)
        if subject.type.kind == "word":
            scope.static.refer(arm.word, Symbol("word", arm.word.text))
        keys.append([(None, None, (arm.word.text,))])
    rest = tuple(n for n in names if n not in seen)
    _close(
        e, keys, [(None, None, rest)] if rest else [], errors.CaseLacks(e.span, words=rest), scope
    )
    return keys


def _number_keys(e: ast.Case, subject: ir.Expr, scope: Scope) -> list[Key]:
    low, high = narrowed(subject, scope.facts)
    taken: list[tuple[float, float]] = []
    keys: list[Key] = []
    for arm in e.arms:
        if arm.word is not None:
            raise scope.fail(errors.WordForNumber(arm.span, name=arm.word.text))
        if arm.low is None:
            keys.append([])
            continue
        first, last = (
            float(arm.low),
            inf if arm.open else float(arm.high if arm.high is not None else arm.low),
        )
        if last < first or any(first <= b and a <= last for a, b in taken):
            raise scope.fail(errors.CaseOverlaps(arm.span))
        taken.append((first, last))
        keys.append([(arm.low, None if arm.open else int(last), ())])
    gaps, reached = list[tuple[float, float]](), low
    for first, last in sorted(taken):
        if first > reached:
            gaps.append((reached, min(first - 1, high)))
        reached = max(reached, last + 1)
    if reached <= high and reached < inf:
        gaps.append((reached, high))
    gaps = [(first, last) for first, last in gaps if first <= last]
    numbers = ""
    if gaps:
        first, last = gaps[0]
        numbers = (
            f"{first:g}"
            if first == last
            else f"{'' if first == -inf else f'{first:g}'}..{'' if last == inf else f'{last:g}'}"
        )
    rest: Key = [(int(a) if a > -inf else None, int(b) if b < inf else None, ()) for a, b in gaps]
    _close(e, keys, rest, errors.CaseLeavesOpen(e.span, numbers=numbers), scope)
    return keys


def _close(e: ast.Case, keys: list[Key], rest: Key, lacking: errors.TableGap, scope: Scope) -> None:
    """Gives what is left to `otherwise`, which must stand last and have something to do; without one, `lacking` is reported."""
    holes = [i for i, key in enumerate(keys) if not key]
    if not holes and rest:
        raise scope.fail(lacking)
    if holes and (len(holes) > 1 or holes[0] != len(keys) - 1):
        raise scope.fail(errors.OtherwiseNotLast(e.arms[holes[0]].span))
    if holes and not rest:
        raise scope.fail(errors.NothingForOtherwise(e.arms[-1].span))
    if holes:
        keys[-1] = rest
