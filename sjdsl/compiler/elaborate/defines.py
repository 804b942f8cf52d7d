"""Expands `define`s: the expression replaces the name, with its free variables bound where it is used."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, local_symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.scope import Scope


def use(name: ast.Name, arguments: tuple[ast.Expr, ...], scope: Scope) -> ir.Expr:
    """Writes a `define` out where it is used: its own names and its arguments, none of the variables around."""
    define = scope.static.defines[name.text]
    scope.static.use(name, Symbol("name", name.text))
    if name.text in scope.defining:
        raise scope.problems.fail(errors.DefineCycle(name.span, name=name.text))
    if len(arguments) != len(define.parameters):
        wanted = f"{len(define.parameters)} argument{'s' * (len(define.parameters) != 1)}"
        raise scope.problems.fail(errors.WrongArguments(name.span, name=name.text, wanted=wanted, given=len(arguments)))
    scope.static.expansions += 1
    if len(scope.defining) >= limits.MAX_DEFINES_DEEP or scope.static.expansions > limits.MAX_EXPANSIONS:
        what, limit = "defines that use one another", limits.MAX_DEFINES_DEEP
        if scope.static.expansions > limits.MAX_EXPANSIONS:
            what, limit = "uses of defines, once those inside them are written out", limits.MAX_EXPANSIONS
        if not any(isinstance(d, errors.TooMuch) for d in scope.problems.found):
            scope.problems.found.append(limits.too_much(f"too many {what}", limit, name.span, "name parts of it with `let` in the phase"))
        raise Poisoned
    values = scope.expressions(arguments)
    variables: dict[str, ir.Expr | str | None] = dict(zip((p.text for p in define.parameters), values, strict=True))
    named = {p.text: local_symbol(p) for p in define.parameters}
    inner = scope.but(variables=variables, locals=named, defining=(*scope.defining, name.text), withheld={})
    value = inner.expression(define.value)
    return ir.Named(type=value.type, name=name.text, value=value, origin=name.span)
