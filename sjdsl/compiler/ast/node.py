"""What all nodes of the tree as written are: frozen dataclasses, equal by content."""

from dataclasses import dataclass
from typing import dataclass_transform

from sjdsl.compiler.diagnostics.frozen import Frozen


@dataclass_transform(frozen_default=True)
class Node(Frozen):
    """A subclass declares its fields and is a dataclass; only the method that makes a node is compiled for each of the 89 classes."""

    def __init_subclass__(cls) -> None:
        cls.__doc__ = cls.__doc__ or cls.__name__  # else each is given its signature as text, slowly
        dataclass(eq=False, repr=False)(cls)
