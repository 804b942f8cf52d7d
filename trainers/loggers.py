"""Metric loggers for TensorBoard and Weights & Biases, if they are installed."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from .config import Config, ConfigError
from .metrics_files import Row

LoggerName = Literal["tensorboard", "wandb"]
PACKAGE = {"tensorboard": "tensorboardX", "wandb": "wandb"}


@dataclass(frozen=True)
class Loggers:
    """The open loggers of one seed."""

    functions: tuple[Callable[[Row], None], ...]

    def log(self, row: Row) -> None:
        """Hands a row to each; its `env_steps` are the axis."""
        for function in self.functions:
            function(row)


@contextmanager
def open_loggers(names: Sequence[LoggerName], folder: Path, title: str, config: Config) -> Iterator[Loggers]:
    """Opens loggers by name.

    Raises:
      ConfigError: a name that is none, or a package that is not installed.
    """
    check_loggers(names)
    with ExitStack() as stack:
        makers = {"tensorboard": _tensorboard, "wandb": _wandb}
        yield Loggers(tuple(makers[name](stack, folder, title, config) for name in names))


def check_loggers(names: Sequence[str]) -> None:
    """Raises ConfigError for a logger that is unknown or not installed."""
    import importlib.util

    for name in names:
        if name not in PACKAGE:
            raise ConfigError(f"unknown logger `{name}`; known: {', '.join(get_args(LoggerName))}")
        if importlib.util.find_spec(PACKAGE[name]) is None:
            raise ConfigError(f"`{name}` needs the package {PACKAGE[name]}: pip install 'sjdsl[{name}]'")


def _tensorboard(stack: ExitStack, folder: Path, title: str, config: Config) -> Callable[[Row], None]:
    del title, config
    from tensorboardX import SummaryWriter

    writer = SummaryWriter(str(folder / "tensorboard"))
    stack.callback(writer.close)

    def log(row: Row) -> None:
        for name, value in _numbers(row).items():
            writer.add_scalar(name, value, row["env_steps"])

    return log


def _wandb(stack: ExitStack, folder: Path, title: str, config: Config) -> Callable[[Row], None]:
    import wandb

    run = wandb.init(project="sjdsl", name=title, dir=str(folder), config=config.record())
    stack.callback(run.finish)
    return lambda row: run.log(_numbers(row), step=row["env_steps"])


def _numbers(row: Row) -> dict[str, Any]:
    """Returns what a logger plots: not the axis, and nothing that has no value."""
    return {name: value for name, value in row.items() if name not in ("update", "env_steps") and value == value}
