"""No text of a game and no name of a file becomes code of a generated module."""

import ast
import os
from pathlib import Path

import pytest

import sjdsl
from sjdsl.cli import run
from sjdsl.compiler import build, compile_rules, compile_source
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.emit.escaping import quoted, remark
from sjdsl.compiler.syntax.read import read_source

GAME = """sj 1
game tiny "{title}" {
  episode 5
  kind floor "."
  kind tree "T" { field fruit : { none, ripe } = none }
  map { "T.." }
  agents 1 {
    acts stay, forward
    moves compass
  }
  phase start { each agent { send agent to floor } }
  schedule grow
  phase grow { each tree { chance 0.5 { set tree.fruit = ripe } } }
}
"""
NAMES = [
    'a"""\nopen("PWNED","w").write("x")\n"""b.sj',
    "'''\nopen('PWNED','w').write('x')\n'''.sj",
    'b\\"""\ropen("PWNED","w").write("x")\r.sj',
    "c.sj\nopen('PWNED','w').write('x')\n.sj",
    "{{ 7 * 7 }}{% raw %}${x}%s{0}.sj",
    "<script>alert(1)<.sj",
    "\u2028\u202e\x0c\x85.sj",
    os.fsdecode(b"\xff\xfe.sj"),
    'ends in a quote".sj',
    "ends in a backslash\\.sj",
]


def text_of(title: str = "Tiny") -> str:
    return GAME.replace("{title}", title)


def written(name: str, folder: Path, title: str = "Tiny") -> Path:
    path = folder / name
    path.write_text(text_of(title), encoding="utf-8")
    return path


def shape(text: str) -> str:
    """Returns the code of a module without its docstrings and comments."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        ):
            node.value = ast.Constant("")
    return ast.dump(tree)


@pytest.mark.parametrize("name", NAMES)
def test_the_name_of_a_file_becomes_no_code(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = shape(compile_source(read_source(written("plain.sj", tmp_path))))
    path = written(name, tmp_path)
    monkeypatch.chdir(tmp_path)
    module, alone = tmp_path / "module.py", tmp_path / "alone.py"
    assert run(["compile", str(path), "-o", str(module)]) == 0
    assert run(["compile", "--standalone", str(path), "-o", str(alone)]) == 0
    assert shape(module.read_text("utf-8")) == plain
    assert plain[len("Module(body=[") : -400].split("Assign(", 1)[1] in shape(
        alone.read_text("utf-8")
    )
    for command in ("check", "doc"):
        assert run([command, str(path)]) == 0
    assert sjdsl.make(path).name == "tiny"
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.parametrize(
    "title",
    ["'''", 'a \\"\\"\\" b', "{{ 7 * 7 }}", "ends in \\\\", '\\"', "é \U0001f352", "</script>"],
)
def test_the_texts_of_a_game_become_no_code(title: str, tmp_path: Path) -> None:
    ours = shape(compile_source(read_source(written("tiny.sj", tmp_path, title))))
    env = sjdsl.make(tmp_path / "tiny.sj")
    assert env.title == title.replace('\\"', '"').replace("\\\\", "\\")
    plain = shape(compile_source(Source("tiny.sj", text_of(), tmp_path)))
    value = f"value=Constant(value={env.title!r})"
    assert ours.replace(value, "").replace(env.hash, "") == plain.replace(
        "value=Constant(value='Tiny')", ""
    ).replace(sjdsl.make(written("plain.sj", tmp_path)).hash, "")


def test_what_is_cached_does_not_depend_on_the_file(tmp_path: Path) -> None:
    """Whoever has the same rules gets what was cached for another: nothing of that file is in it, nor are its lines."""
    one, other = tmp_path / "one.sj", tmp_path / "other.sj"
    one.write_text(text_of(), encoding="utf-8")
    other.write_text(
        text_of().replace("\n  phase grow", "\n\n  # a remark\n  phase grow"), encoding="utf-8"
    )
    first, second = (compile_rules(build(read_source(path))) for path in (one, other))
    assert first == second
    assert ".sj" not in first


def test_one_escaping() -> None:
    every = [chr(code) for code in (*range(0x3000), 0xD800, 0xDCFF, 0xFEFF, 0x1F352)]
    for character in every:
        text = f"a{character}b{character}"
        assert ast.literal_eval(quoted(text)) == text
        namespace: dict[str, object] = {}
        exec(
            f'def f():\n    """{remark(text)}"""  # {remark(text)}\nx = 1  # {remark(text)}\ny = 2\n',
            namespace,
        )
        assert namespace["y"] == 2
        assert remark(text).encode("ascii").decode() == remark(text)
