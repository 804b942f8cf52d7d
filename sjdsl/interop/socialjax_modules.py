"""Makes `import socialjax` use compiled games: patches the installed suite, or stands in for it."""

import importlib
import sys
from types import ModuleType

from sjdsl.interop import socialjax, spaces

PACKAGE = "socialjax"
WRAPPERS = ("CTRolloutManager", "LogWrapper", "MAPPOWorldStateWrapper", "SVOLogWrapper", "load_params", "save_params")


def stand_in() -> str | None:
    """Lets scripts of the suite that say `import socialjax` have our games; calling it again changes nothing.

    Where the suite's package can be imported, its `make` becomes ours and its wrappers stay. Otherwise there are modules of its names
    with what its scripts take from them: `socialjax`, `socialjax.wrappers.baselines`, `socialjax.environments.spaces`.

    Returns:
      why the suite's package, though installed, could not be imported; None otherwise.
    """
    try:
        suite = importlib.import_module(PACKAGE)
    except Exception as error:
        for name in [name for name in sys.modules if name.split(".")[0] == PACKAGE]:
            del sys.modules[name]  # what was imported before it failed
        _make_modules()
        absent = isinstance(error, ModuleNotFoundError) and error.name == PACKAGE
        return None if absent else f"{type(error).__name__}: {error}"
    vars(suite).update(make=socialjax.make, registered_envs=socialjax.registered_envs)
    return None


def _make_modules() -> None:
    box, discrete = spaces.space_classes()
    baselines = _module(f"{PACKAGE}.wrappers.baselines", **{name: getattr(socialjax, name) for name in WRAPPERS})
    shapes = _module(f"{PACKAGE}.environments.spaces", Box=box, Discrete=discrete, MultiDiscrete=spaces.MultiDiscrete)
    wrappers = _module(f"{PACKAGE}.wrappers", baselines=baselines)
    environments = _module(f"{PACKAGE}.environments", spaces=shapes)
    _module(PACKAGE, make=socialjax.make, registered_envs=socialjax.registered_envs, wrappers=wrappers, environments=environments)


def _module(name: str, **content: object) -> ModuleType:
    """Returns a module of a name, which `import` finds from now on."""
    made = ModuleType(name, f"Stands in for the module {name} of SocialJax.")
    made.__path__ = []  # a package: its parts are imported by their full names
    made.__dict__.update(content)
    sys.modules[name] = made
    return made
