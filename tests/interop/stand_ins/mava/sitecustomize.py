"""Lets Mava's scripts be imported where not all is installed that Mava names; Python runs this when it starts, if the folder is on its path.

A package that no script needs here is an empty stand-in. A checkout from before Jumanji 1.1 says `MaConnector`, and calls specs, which
have become properties.
"""

import importlib.abc
import importlib.machinery
import importlib.util
import sys
from types import ModuleType
from typing import Any

UNUSED = ("brax", "gigastep", "marl_eval", "matrax", "neptune", "tensorboard_logger")


class Empty(ModuleType):
    """A module in which every name in capitals is a class without content, and every other one a module of this kind."""

    __path__: list[str] = []  # noqa: RUF012, a package, as Python has it

    def __getattr__(self, name: str) -> Any:
        if not name[0].isupper():
            raise AttributeError(name)
        return type(name, (), {})


class StandIns(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds, after all others, the packages that are not there."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        del path, target
        return importlib.machinery.ModuleSpec(name, self, is_package=True) if name.split(".")[0] in UNUSED else None

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        return Empty(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        del module


sys.meta_path.append(StandIns())
if importlib.util.find_spec("jumanji") is not None:
    from jumanji import specs
    from jumanji.environments.routing import connector

    connector.MaConnector = connector.Connector
    specs.Spec.__call__ = lambda self: self
