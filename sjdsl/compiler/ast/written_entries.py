"""Entries of tables as they are written: which one a change names, and one that stood for several by itself."""

from sjdsl.compiler import ast


def path_text(path: ast.Path) -> str:
    """Returns a path as written, without layout; keys other than names show as `..`."""
    steps = []
    for step in path.steps:
        if isinstance(step, ast.Member):
            steps.append("." + step.name.text)
        else:
            key = step.key
            steps.append(f"[{key.name.text}]" if isinstance(key, ast.Path) else f"[{key.value}]" if isinstance(key, ast.Int) else "[..]")
    return path.name.text + "".join(steps)


def entry_key(step: ast.Member | ast.Index) -> ast.Name | None:
    """Returns the entry that a change names: a word, or a number."""
    match step:
        case ast.Index(key=ast.Path(name=name)):
            return name
        case ast.Index(key=ast.Int(value=number) as written):
            return ast.Name(written.span, str(number))
    return None


def with_entry(value: ast.Expr | ast.Table, key: ast.Name, by: ast.By) -> ast.Expr | ast.Table:
    """Returns a table in which an entry stands by itself: one that `otherwise` or a single number for all stood for gets a line of its own."""
    known = isinstance(by, ast.Words) and key.text in {name.text for name in by.names}
    if not known and not (not isinstance(by, ast.Words) and key.text.isdigit()):
        return value
    rest = ast.Name(value.span, "otherwise")
    entries = value.entries if isinstance(value, ast.Table) else (ast.Entry(value.span, rest, value),)
    others = next((entry for entry in entries if entry.key.text == "otherwise"), None)
    if others is None or key.text in {entry.key.text for entry in entries}:
        return value
    return ast.Table(value.span, (ast.Entry(value.span, key, others.value), *entries))
