"""Records one seed while it learns: rows of metrics, evaluations, policies and its learning curve."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from jax import Array

from ..devices.processes import is_first
from ..environment import Environment
from ..policies.evaluation import Evaluation, evaluation_key, make_evaluator, summarise
from ..policies.loading import trained_policy
from ..policies.policy_file import POLICIES, SUFFIX, remove_policies, write_policy
from ..settings.config import Config
from .learning_curve import draw_learning_curve
from .learning_signs import LearningWarning, Signs, is_due
from .loggers import LoggerName, Loggers, open_loggers
from .metrics_files import (
    EVALUATIONS,
    Metrics,
    Row,
    append_line,
    cut_metrics,
    open_metrics,
    read_rows,
    thinned_rows,
)
from .run_folder import describe_game

Evaluator = Callable[[Array, Any], Evaluation]
POINTS = 1000  # of a learning curve, at most


@dataclass
class Earned:
    """What the finished episodes earned since the last stored policy, and the best between any two before."""

    total: float = 0.0  # collective return
    episodes: float = 0.0
    best: float = -math.inf  # mean of an episode

    def add(self, row: Row) -> None:
        """Counts the episodes of an update."""
        if row["episodes"] > 0:
            self.total += row["episodes"] * row["collective_return"]
            self.episodes += row["episodes"]

    def close(self) -> bool:
        """Starts again after a stored policy; returns whether more was earned than between any two before."""
        mean = self.total / self.episodes if self.episodes else math.nan
        is_best = mean > self.best
        self.best = mean if is_best else self.best
        self.total = self.episodes = 0.0
        return is_best


class History:
    """What is kept in memory of the rows written so far; the rows themselves aren't."""

    def __init__(self, config: Config) -> None:
        self.updates = 0
        self.seconds = 0.0  # that they took
        self.earned = Earned()
        self.signs = Signs()
        self.warnings: list[LearningWarning] = []
        self.is_judged = False  # whether these were looked for at the last row
        self._config = config

    def count(self, row: Row) -> None:
        """Takes note of a row."""
        self.updates, self.seconds = row["update"], row["seconds"]
        self.earned.add(row)
        self.signs.count(row)
        self.is_judged = is_due(self.updates, self._config)
        if self.is_judged:
            self.warnings = list(self.signs.warnings(self._config))

    def recall(self, row: Row) -> None:
        """Takes note of a row that was written before the run was stopped."""
        self.count(row)
        if self.is_mark(row["update"]):
            self.earned.close()

    def is_mark(self, update: int) -> bool:
        """Whether the policy of an update is stored by its number."""
        return update % self._config.policy_updates == 0 or update == self._config.num_updates


@dataclass
class Recorder:
    """The open files of one seed."""

    folder: Path
    about: Mapping[str, Any]  # what stored policies say of their run
    config: Config
    seed: int
    metrics: Metrics
    history: History
    loggers: Loggers
    evaluator: Evaluator
    best_evaluated: float  # the best collective return of the evaluations so far
    steps_before: int  # environment steps of the stages before this one

    def append(self, row: Row) -> None:
        """Writes the row of an update."""
        self.metrics.append(row)
        self.history.count(row)
        self.loggers.log(row)

    def mark(self, parameters: Any, update: int) -> None:
        """Stores the policy of an update by its number, as `last`, and also as `best` if it is and nothing is evaluated."""
        is_best = self.history.earned.close()
        best = ("best",) if is_best and not self.config.evaluate_every else ()
        self.store(parameters, update, f"{update:08d}", "last", *best)
        remove_policies(self.folder / POLICIES, self.config.keep_policies)

    def moment(self, update: int) -> dict[str, int]:
        """Returns an update and the environment steps until its end, those of earlier stages included."""
        return {
            "update": update,
            "env_steps": self.steps_before + update * self.config.steps_per_update,
        }

    def store(self, parameters: Any, update: int, *names: str) -> None:
        """Stores the policy of an update under some names, after the metrics."""
        self.metrics.to_disk()
        described = {**self.about, **self.moment(update)}
        for name in names:
            write_policy(self.folder / POLICIES / f"{name}{SUFFIX}", parameters, described)

    def evaluate(self, parameters: Any, update: int) -> None:
        """Plays episodes with the policy of an update, writes their figures, and stores the policy as `best` if it is."""
        figures = summarise(self.evaluator(evaluation_key(self.seed, update), parameters))
        start = self.moment(update)
        earned = figures["collective return"].mean
        append_line(
            self.folder / EVALUATIONS,
            start | {name: asdict(figure) for name, figure in figures.items()},
        )
        self.loggers.log(start | {"evaluation_collective_return": earned})
        if earned > self.best_evaluated:
            self.best_evaluated = earned
            self.store(parameters, update, "best")


@contextmanager
def open_recorders(
    folders: Sequence[Path],
    env: Environment,
    config: Config,
    done: int,
    loggers: Sequence[LoggerName],
    title: str,
    steps_before: int = 0,
) -> Iterator[list[Recorder]]:
    """Opens the files of each seed, without what was written after update `done`; draws the learning curves at the end.

    `steps_before`: environment steps of stages before this one. Only the first of several processes has recorders: the others don't write.
    """
    evaluator = make_evaluator(
        env, lambda parameters: trained_policy(env, config, parameters), config.evaluation_episodes
    )
    with ExitStack() as stack:
        recorders: list[Recorder] = []

        def draw(folder: Path, seed: int) -> None:
            draw_learning_curve(folder, thinned_rows(folder, POINTS), f"{title}, seed {seed}")

        for folder, seed in zip(folders, config.seed_numbers, strict=True) if is_first() else ():
            folder.mkdir(parents=True, exist_ok=True)
            history = History(config)
            for row in cut_metrics(folder, done, config.evaluate_every):
                history.recall(row)
            steps = steps_before + done * config.steps_per_update
            opened = stack.enter_context(
                open_loggers(loggers, folder, f"{title}, seed {seed}", config, steps)
            )
            metrics = stack.enter_context(open_metrics(folder))
            about = {"game": describe_game(env), "config": config.record(), "seed": seed}
            best = max(
                (row["collective return"]["mean"] for row in read_rows(folder / EVALUATIONS)),
                default=-math.inf,
            )
            recorders.append(
                Recorder(
                    folder,
                    about,
                    config,
                    seed,
                    metrics,
                    history,
                    opened,
                    evaluator,
                    best,
                    steps_before,
                )
            )
            stack.callback(draw, folder, seed)
        yield recorders
