"""The abstract syntax tree: scripted policies and scenarios."""

from sjdsl.compiler.ast.expressions import Chosen, Domain, Expr, Name, ShapeRef, String
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.source import Span


class Act(Node):
    """`when C choose ACTION`"""

    span: Span
    condition: Expr
    action: Chosen


class Go(Node):
    """`seek D avoiding E`"""

    span: Span
    domain: Domain
    avoided: Domain | None


class Aim(Node):
    """`aim SHAPE at D avoiding E choose ACTION`"""

    span: Span
    shape: ShapeRef
    domain: Domain
    avoided: Domain | None
    action: Chosen


class ScriptedPolicy(Node):
    """`policy cooperator "…" { … }`: the first rule that applies acts"""

    span: Span
    name: Name
    title: String | None
    rules: tuple[Act | Go | Aim, ...]


class Slots(Node):
    """`slots 2 focal`, or `slots 5 policy defector`"""

    span: Span
    number: Expr
    policy: Name | None


class Scenario(Node):
    span: Span
    name: Name
    title: String | None
    slots: tuple[Slots, ...]
