"""Metric loggers for TensorBoard and Weights & Biases, if they are installed."""

import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from sjdsl.extras import require
from sjdsl.files import read_bytes, write_whole

from ..settings.config import Config, ConfigError
from .metrics_files import Row

LoggerName = Literal["tensorboard", "wandb"]
PACKAGE = {"tensorboard": "tensorboardX", "wandb": "wandb"}
LONGEST_ID = 100  # bytes
WANDB_ID = "wandb_id"  # in the folder of a seed: the id of its run there, also when it is resumed


@dataclass(frozen=True)
class Loggers:
    """The open loggers of one seed."""

    functions: tuple[Callable[[Row], None], ...]

    def log(self, row: Row) -> None:
        """Logs a row to each; its `env_steps` are the axis."""
        for function in self.functions:
            function(row)


@contextmanager
def open_loggers(
    names: Sequence[LoggerName], folder: Path, title: str, config: Config, done: int
) -> Iterator[Loggers]:
    """Opens loggers by name.

    Args:
      folder: of the seed.
      done: environment steps after which the run resumes; what was logged of later ones is logged again.
    Raises:
      ConfigError, MissingExtra: as in `check_loggers`.
    """
    check_loggers(names)
    with ExitStack() as stack:
        makers = {"tensorboard": _tensorboard, "wandb": _wandb}
        yield Loggers(tuple(makers[name](stack, folder, title, config, done) for name in names))


def check_loggers(names: Sequence[str]) -> None:
    """Raises ConfigError for an unknown logger, MissingExtra for one that isn't installed."""
    for name in names:
        if name not in PACKAGE:
            raise ConfigError(f"unknown logger `{name}`; known: {', '.join(get_args(LoggerName))}")
        require(name, PACKAGE[name])


def _tensorboard(
    stack: ExitStack, folder: Path, title: str, config: Config, done: int
) -> Callable[[Row], None]:
    del title, config
    from tensorboardX import SummaryWriter

    events = folder / "tensorboard"
    # a file of its own, even if the one before was started in the same second, which names are made from
    again = {"purge_step": done + 1, "filename_suffix": f".{done}"} if events.exists() else {}
    writer = SummaryWriter(str(events), **again)
    stack.callback(writer.close)

    def log(row: Row) -> None:
        for name, value in _numbers(row).items():
            writer.add_scalar(name, value, row["env_steps"])

    return log


def _wandb(
    stack: ExitStack, folder: Path, title: str, config: Config, done: int
) -> Callable[[Row], None]:
    """Returns a function that logs to a run of its own, new or resumed; steps that it has already stay as they are."""
    del done
    import wandb

    known = folder / WANDB_ID
    if not known.exists():
        write_whole(known, secrets.token_hex(4).encode())
    number = read_bytes(known, LONGEST_ID).decode("ascii")
    one = {
        "id": number,
        "resume": "allow",
        "reinit": "create_new",
    }  # otherwise a process has one run for all its seeds
    run = wandb.init(project="sjdsl", name=title, dir=str(folder), config=config.record(), **one)
    stack.callback(run.finish)
    return lambda row: run.log(_numbers(row), step=row["env_steps"])


def _numbers(row: Row) -> dict[str, Any]:
    """Returns what a logger plots: everything but the axis and missing values."""
    return {
        name: value
        for name, value in row.items()
        if name not in ("update", "env_steps") and value == value
    }
