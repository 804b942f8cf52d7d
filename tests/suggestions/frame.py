"""The game into which the short texts of the cases are written, and the cases themselves."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

FOLDER = Path(__file__).parent
GAME = """sj 1
game meadow "The frame of the cases" {{
  {episode}
{numbers}
  kind grass "."
  kind tree  "T" {{ field fruit : {{ none, ripe }} = ripe  glyph "t" with fruit = none }}
  kind wall  "#" {{ blocks agents }}
{world}
  {map}
  agents 2 {{
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap
    {moves}
    field bag : 0 .. 9 capped = 0
{agents}
  }}
  phase start {{ {start} }}
  {schedule}
  phase walk {{ move each agent }}
  phase rule {{
{rule}
  }}
  phase shoot {{ each agent where agent chose zap {{ add 1 to agent.bag }} }}
{phases}
  observe {{
    {window}
{observe}
  }}
  metrics {{
{metrics}
  }}
  checks {{
{checks}
  }}
{policies}
}}
"""
PARTS = {
    "episode": "episode 100",
    "map": 'map { "...." "TTTT" }',
    "moves": "moves relative",
    "start": "each agent { send agent to grass facing north }",
    "schedule": "schedule walk -> rule -> shoot",
    "window": "window ahead 2, behind 1, left 1, right 1",
} | dict.fromkeys(
    ("numbers", "world", "agents", "rule", "phases", "observe", "metrics", "checks", "policies"), ""
)


@dataclass(frozen=True)
class Case:
    """`wrong` stands at the place `at` of the frame; `says`: parts of the one message about it; `right`: what it suggests, applied.

    `given`: what else the game has; `besides`: what the repair puts elsewhere.
    """

    name: str
    at: str
    wrong: str
    says: tuple[str, ...]
    right: str
    given: dict[str, str] = field(default_factory=dict)
    besides: dict[str, str] = field(default_factory=dict)

    @property
    def mistaken(self) -> str:
        return GAME.format(**PARTS | self.given | {self.at: self.wrong})

    @property
    def repaired(self) -> str:
        return GAME.format(**PARTS | self.given | {self.at: self.right} | self.besides)


def cases() -> list[Case]:
    """Returns the cases of all files of this folder."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        for entry in tomllib.loads(path.read_text("utf-8"))["case"]:
            found.append(Case(**entry | {"says": tuple(entry["says"])}))
    return found
