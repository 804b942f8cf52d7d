"""A program as stable text for readers and tests: what `sjdsl dump --after program` shows."""

from collections.abc import Iterator

from sjdsl.compiler.emit.expressions import text
from sjdsl.compiler.program import Program
from sjdsl.compiler.program.expressions import Assign, Return


def listing(program: Program) -> Iterator[str]:
    """Yields a program line by line, a statement a line."""
    yield f"program {program.name} from {program.source}"
    for fact in program.facts:
        if fact.name != "HASH":  # of the rules, not of this program
            yield f"fact {fact.name} = {text(fact.value)}"
    for plane in program.planes:
        labels = ", ".join(plane.labels)
        yield f"plane {plane.name} : {plane.encoding} 0 .. {plane.high} {labels}".rstrip()
    for number in program.numbers:
        yield f"number {number.name} = {number.value}  # {number.comment}".removesuffix("  # ")
    for constant in program.constants:
        yield f"constant {constant.name} = {text(constant.value)}  # {constant.comment}"
    for label, fields in (
        ("state", program.state),
        ("param", program.params),
        ("outcome", program.outcome),
    ):
        for field in fields:
            yield f"{label} {field.name} : {field.dtype}{field.shape}  # {field.comment}"
    for function in program.functions:
        parameters = ", ".join(f"{name}: {type_}" for name, type_ in function.parameters)
        yield f"function {function.name}({parameters}) -> {function.returns}"
        for statement in function.body:
            match statement:
                case Assign(names=names, value=value):
                    yield f"    {', '.join(names)} = {text(value)}"
                case Return(values=values):
                    yield f"    return {', '.join(map(text, values))}"
