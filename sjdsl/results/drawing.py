"""How the pictures of a report look: colours that colour-blind readers can tell apart."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

# Okabe and Ito 2008, without black, which is for published figures, and without yellow, which is hard to see on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
PUBLISHED: Mapping[str, Any] = {"color": "black", "linestyle": "--", "marker": "x", "linewidth": 1}


@contextmanager
def colours() -> Iterator[None]:
    """Has plots take their colours from the palette."""
    import matplotlib  # here: importing it costs as much as a short test
    from cycler import cycler

    with matplotlib.rc_context({"axes.prop_cycle": cycler(color=PALETTE)}):
        yield
