"""Counts that only the later phases see: chains of defines, kinds, agents; each one message, quickly."""

import time

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source

GAME = """sj 1
game pond {{
  episode 20
  kind shore "."
{more}  map {{ "....." }}
  agents {agents} {{ acts turn_left, forward, stay }}
  phase start {{ each agent {{ send agent to shore }} }}
  schedule pay
  phase pay {{ each agent {{ give {reward} to agent }} }}
}}
"""
DOUBLING = "  define d0 = 1\n" + "".join(f"  define d{i} = d{i - 1} + d{i - 1}\n" for i in range(1, 41))
CHAIN = "  define d0 = 1\n" + "".join(f"  define d{i} = d{i - 1} + 1\n" for i in range(1, 401))
BROAD = "  define d0 = 1\n" + "".join(f"  define d{i} = {' + '.join([f'd{i - 1}'] * 20)}\n" for i in range(1, 5))
GLYPHS = [chr(c) for c in range(33, 127) if chr(c) not in '\\".']
KINDS = "".join(f'  kind k{i} "{GLYPHS[i]}"\n' for i in range(65))


@pytest.mark.parametrize(
    ("more", "agents", "reward", "code"),
    [
        (DOUBLING, 2, "d40", "SJ007"),
        (CHAIN, 2, "d400", "SJ007"),
        (BROAD, 2, "d4", "SJ007"),
        (KINDS, 2, "1", "SJ007"),
        ("", 65, "1", "SJ214"),
        ("", 6, "1", "SJ303"),
    ],
)
def test_one_message_quickly(more: str, agents: int, reward: str, code: str) -> None:
    began = time.process_time()
    found = [d for d in check(Source("pond.sj", GAME.format(more=more, agents=agents, reward=reward))) if d.severity == "error"]
    assert [d.code for d in found] == [code], [d.message for d in found]
    assert time.process_time() - began < 2
