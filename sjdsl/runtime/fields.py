"""Describes the variables of a state: type, owner and array shape, without JAX."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class StateField:
    """One attribute of a generated module's State: a field of agents, of cells, or of the world.

    Encodings:
      word: the number of one of `size` enum values.
      agent: the number of an agent, -1 for nobody.
      agents: bit i for agent i; of more than 32 agents, bit i % 32 of entry i // 32.
      cell: 256 times the row plus the column, -1 for nowhere.
      place: the cell of a mover in the padded frame, 0 for nowhere.
      condition: bool.
      number: from `low` to `high`, None without limits.
    """

    attribute: str
    encoding: Literal["word", "agent", "agents", "cell", "place", "condition", "number"]
    size: int = 0
    low: float | None = None
    high: float | None = None
