"""What is written of one seed while it learns: rows of metrics, evaluations, policies, its learning curve."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import jax
from jax import Array

from .config import Config
from .environment import Environment
from .evaluate import Evaluation, make_evaluator, summarise
from .loggers import LoggerName, Loggers, open_loggers
from .policies import trained_policy
from .policy_file import POLICIES, SUFFIX, write_policy
from .processes import is_first
from .run_folder import (
    EVALUATIONS,
    Metrics,
    Row,
    append_line,
    cut_metrics,
    describe_game,
    draw_learning_curve,
    open_metrics,
    read_evaluations,
)

Evaluator = Callable[[Array, Any], Evaluation]


class Recorder:
    """The open files of one seed."""

    def __init__(
        self,
        folder: Path,
        env: Environment,
        config: Config,
        seed: int,
        metrics: Metrics,
        rows: list[Row],
        loggers: Loggers,
        evaluator: Evaluator,
    ) -> None:
        self.folder = folder
        self.rows = rows  # of all updates so far
        self._evaluations = read_evaluations(folder)
        self._config = config
        self._seed = seed
        self._metrics = metrics
        self._loggers = loggers
        self._evaluator = evaluator
        self._of = {"game": describe_game(env), "config": config.model_dump(mode="json"), "seed": seed}

    def append(self, row: Row) -> None:
        """Writes the row of an update."""
        self._metrics.append(row)
        self.rows.append(row)
        self._loggers.log(row)

    def keep(self, parameters: Any, update: int) -> None:
        """Stores the policy of an update: under its number, as `last`, and, where nothing is evaluated, as `best` if it is."""
        self._metrics.to_disk()
        names = [f"{update:08d}", "last"]
        if not self._config.evaluate_every and earned_most(self.rows, self._config.checkpoint_every):
            names.append("best")
        for name in names:
            self._write(name, parameters, update)

    def evaluate(self, parameters: Any, update: int) -> None:
        """Plays episodes with the policy of an update, writes what they came to, and stores the policy as `best` if it is."""
        figures = summarise(self._evaluator(jax.random.fold_in(jax.random.key(self._seed), update), parameters))
        start = {"update": update, "env_steps": update * self._config.steps_per_update}
        earned = figures["collective return"].mean
        best = max((row["collective return"]["mean"] for row in self._evaluations), default=-math.inf)
        row = start | {name: asdict(figure) for name, figure in figures.items()}
        append_line(self.folder / EVALUATIONS, row)
        self._evaluations.append(row)
        self._loggers.log(start | {"evaluation_collective_return": earned})
        if earned > best:
            self._write("best", parameters, update)

    def draw(self, title: str) -> None:
        """Draws the learning curve so far."""
        draw_learning_curve(self.folder, self.rows, f"{title}, seed {self._seed}")

    def _write(self, name: str, parameters: Any, update: int) -> None:
        described = self._of | {"update": update, "env_steps": update * self._config.steps_per_update}
        write_policy(self.folder / POLICIES / f"{name}{SUFFIX}", parameters, described)


def earned_most(rows: Sequence[Row], every: int) -> bool:
    """Whether the episodes finished since the last checkpoint earned more than those before any other.

    Args:
      rows: of all updates so far.
      every: updates between checkpoints; 0: there is none before the last.
    """
    size = every or max(len(rows), 1)
    earned = [_mean_return(rows[start : start + size]) for start in range(0, len(rows), size)]
    return bool(earned) and not math.isnan(earned[-1]) and all(not other >= earned[-1] for other in earned[:-1])


def _mean_return(rows: Sequence[Row]) -> float:
    finished = [row for row in rows if row["episodes"] > 0]
    episodes = sum(row["episodes"] for row in finished)
    return sum(row["episodes"] * row["collective_return"] for row in finished) / episodes if episodes else math.nan


@contextmanager
def open_recorders(
    folders: Sequence[Path], env: Environment, config: Config, done: int, loggers: Sequence[LoggerName], title: str
) -> Iterator[list[Recorder]]:
    """Opens the files of each seed, without what was written after update `done`; draws the learning curves at the end.

    Only the first of several processes writes: the others have no recorders.
    """
    evaluator = make_evaluator(env, lambda parameters: trained_policy(env, config, parameters), config.evaluation_episodes)
    with ExitStack() as stack:
        recorders: list[Recorder] = []
        for folder, seed in zip(folders, config.seed_numbers, strict=True) if is_first() else ():
            folder.mkdir(parents=True, exist_ok=True)
            rows = cut_metrics(folder, done)
            opened = stack.enter_context(open_loggers(loggers, folder, f"{title}, seed {seed}", config))
            metrics = stack.enter_context(open_metrics(folder))
            recorders.append(Recorder(folder, env, config, seed, metrics, rows, opened, evaluator))
            stack.callback(recorders[-1].draw, title)
        yield recorders
