"""The version of the language: a file says it, what files said before the first release means the same, any other is refused."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import ALSO_READ, VERSION, parse, read_tree

GAME = """# ours
sj {version}  # the first line
game pond "Pond" {{
  episode 3
  kind shore "."
  map wraps {{ ".." }}
  agents 1 {{ acts stay }}
  phase start {{ each agent {{ send agent to shore }} }}
  schedule rest
  phase rest {{ }}
  define any(a, b) = a > b
  checks {{ always any(3, step) }}
}}
"""


def pond(version: str) -> Source:
    return Source("pond.sj", GAME.format(version=version))


@pytest.mark.parametrize("version", ALSO_READ)
def test_the_line_does_not_change_what_a_file_means(version: str) -> None:
    said, plain = read_tree(pond(version))[1], read_tree(pond(VERSION))[1]
    assert said.children[1:] == plain.children[1:]


@pytest.mark.parametrize("version", ["2", "1.3", "1.10", "01"])
def test_another_language_is_refused_with_what_to_do(version: str) -> None:
    with pytest.raises(CompileError) as caught:
        parse(pond(version))
    (problem,) = caught.value.diagnostics
    assert problem.code == "SJ001"
    assert problem.message == f"this file is for `sj {version}`, and this compiler reads `sj 1`"
