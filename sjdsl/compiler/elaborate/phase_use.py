"""The state of elaboration while one use of a phase is built."""

from dataclasses import dataclass, field

from sjdsl.compiler.elaborate.streams import Streams


@dataclass
class PhaseUse:
    """What is kept while one use of a phase is built: its streams, and its pools of sends by destination."""

    streams: Streams
    pools: dict[str, int] = field(default_factory=dict)
