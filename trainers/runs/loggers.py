"""Metric loggers for TensorBoard and Weights & Biases, if they are installed."""

import math
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
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


Log = Callable[[Row], None]


@contextmanager
def open_loggers(
    names: Sequence[LoggerName], folder: Path, title: str, config: Config, done: int
) -> Iterator[list[Log]]:
    """Yields the functions that log rows of a seed, by the names of loggers.

    Args:
      folder: of the seed.
      done: environment steps after which the run resumes; what was logged of later ones is logged
        again.
    Raises:
      ConfigError, MissingExtra: as in `check_loggers`.
    """
    check_loggers(names)
    makers = {"tensorboard": _open_tensorboard, "wandb": _open_wandb}
    with ExitStack() as stack:
        yield [makers[name](stack, folder, title, config, done) for name in names]


def check_loggers(names: Sequence[str]) -> None:
    """Raises ConfigError for an unknown logger, MissingExtra for one that isn't installed."""
    for name in names:
        if name not in PACKAGE:
            raise ConfigError(f"unknown logger `{name}`; known: {', '.join(get_args(LoggerName))}")
        require(name, PACKAGE[name])


def _open_tensorboard(stack: ExitStack, folder: Path, title: str, config: Config, done: int) -> Log:
    """Returns a function that logs to files in the folder; see `open_loggers`."""
    del title, config
    from tensorboardX import SummaryWriter

    # a suffix, as file names are made from the second in which a writer was started
    writer = SummaryWriter(
        str(folder / "tensorboard"), purge_step=done + 1, filename_suffix=f".{done}"
    )
    stack.callback(writer.close)

    def log(row: Row) -> None:
        for name, value in _numbers(row).items():
            writer.add_scalar(name, value, row["env_steps"])

    return log


def _open_wandb(stack: ExitStack, folder: Path, title: str, config: Config, done: int) -> Log:
    """Returns a function that logs to a run of its own, new or resumed.

    Steps that it has already stay as they are.
    """
    del done
    import wandb

    id_file = folder / WANDB_ID
    if not id_file.exists():
        write_whole(id_file, secrets.token_hex(4).encode())
    run = wandb.init(
        project="sjdsl",
        name=title,
        dir=str(folder),
        config=config.record(),
        id=read_bytes(id_file, LONGEST_ID).decode("ascii"),
        resume="allow",
        reinit="create_new",  # otherwise a process has one run for all its seeds
    )
    stack.callback(run.finish)
    return lambda row: run.log(_numbers(row), step=row["env_steps"])


def _numbers(row: Row) -> dict[str, Any]:
    """Returns what a logger plots: everything but the axis and missing values."""
    axis = ("update", "env_steps")
    return {
        name: value for name, value in row.items() if name not in axis and not math.isnan(value)
    }
