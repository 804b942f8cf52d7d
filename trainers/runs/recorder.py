"""Records a seed while it learns: rows of metrics, evaluations, policies and its learning curve."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from jax import Array

from ..devices.processes import is_first
from ..policies.evaluation import Evaluation, evaluation_key, make_evaluator, summarise
from ..policies.loading import trained_policy
from ..policies.policy_file import POLICIES, SUFFIX, remove_policies, write_policy
from ..settings.config import Config
from .learning_curve import draw_learning_curve
from .learning_signs import Signs, is_due
from .loggers import Log, open_loggers
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
from .run_stage import RunStage

Evaluator = Callable[[Array, Any], Evaluation]
POINTS = 1000  # of a learning curve, at most


@dataclass
class History:
    """What is kept in memory of the rows written so far; the rows themselves aren't."""

    config: Config
    updates: int = 0
    seconds: float = 0.0  # that they took
    # of the episodes that ended since the last stored policy, and their number
    collective_return: float = 0.0
    episodes: float = 0.0
    best: float = -math.inf  # the best mean of such episodes
    signs: Signs = field(default_factory=Signs)
    warnings: list[str] = field(default_factory=list)
    is_judged: bool = False  # whether the last row brought the warnings

    def count(self, row: Row) -> None:
        """Takes note of a row."""
        self.updates = row["update"]
        self.seconds = row["seconds"]
        if row["episodes"] > 0:
            self.collective_return += row["episodes"] * row["collective_return"]
            self.episodes += row["episodes"]
        self.signs.count(row)
        self.is_judged = is_due(self.updates, self.config)
        if self.is_judged:
            self.warnings = list(self.signs.warnings(self.config))

    def recall(self, row: Row) -> None:
        """Takes note of a row that was written before the run was stopped."""
        self.count(row)
        if self.is_mark(row["update"]):
            self.close()

    def is_mark(self, update: int) -> bool:
        """Whether the policy of an update is stored by its number."""
        return update % self.config.policy_updates == 0 or update == self.config.num_updates

    def close(self) -> bool:
        """Starts again after a policy was stored; returns whether its episodes earned the most."""
        mean = self.collective_return / self.episodes if self.episodes else -math.inf
        is_best = mean > self.best
        self.best = max(mean, self.best)
        self.collective_return = self.episodes = 0.0
        return is_best


@dataclass
class Recorder:
    """The open files of one seed."""

    stage: RunStage
    seed: int
    folder: Path
    metrics: Metrics
    history: History
    loggers: Sequence[Log]
    evaluator: Evaluator
    best_evaluated: float  # the best collective return of the evaluations so far

    def append(self, row: Row) -> None:
        """Writes the row of an update."""
        self.metrics.append(row)
        self.history.count(row)
        self.log(row)

    def log(self, row: Row) -> None:
        """Passes a row to each logger; its `env_steps` are the axis."""
        for log in self.loggers:
            log(row)

    def mark(self, parameters: Any, update: int) -> None:
        """Stores the policy of an update by its number and as `last`.

        If nothing is evaluated, it is also `best` if its episodes earned the most.
        """
        names = [f"{update:08d}", "last"]
        if self.history.close() and not self.stage.config.evaluate_every:
            names.append("best")
        self.store(parameters, update, *names)
        remove_policies(self.folder / POLICIES, self.stage.config.keep_policies)

    def store(self, parameters: Any, update: int, *names: str) -> None:
        """Stores the policy of an update under some names, after the metrics."""
        self.metrics.to_disk()
        description = {
            "game": describe_game(self.stage.env),
            "config": self.stage.config.record(),
            "seed": self.seed,
            **self._moment(update),
        }
        for name in names:
            write_policy(self.folder / POLICIES / f"{name}{SUFFIX}", parameters, description)

    def evaluate(self, parameters: Any, update: int) -> None:
        """Plays episodes with the policy of an update, writes their figures; stores the best."""
        figures = summarise(self.evaluator(evaluation_key(self.seed, update), parameters))
        moment = self._moment(update)
        earned = figures["collective return"].mean
        row = moment | {name: asdict(figure) for name, figure in figures.items()}
        append_line(self.folder / EVALUATIONS, row)
        self.log(moment | {"evaluation_collective_return": earned})
        if earned > self.best_evaluated:
            self.best_evaluated = earned
            self.store(parameters, update, "best")

    def _moment(self, update: int) -> dict[str, int]:
        """Returns an update and the environment steps until its end, as columns of a row."""
        return {"update": update, "env_steps": self.stage.steps_after(update)}


@contextmanager
def open_recorders(stage: RunStage, done: int) -> Iterator[list[Recorder]]:
    """Opens the files of each seed, without what was written after update `done`.

    At the end, it draws the learning curves. Only the first of several processes has recorders: the
    others don't write.
    """
    config = stage.config
    evaluator = make_evaluator(
        stage.env, partial(trained_policy, stage.env, config), config.evaluation_episodes
    )
    with ExitStack() as stack:
        recorders: list[Recorder] = []
        folders: dict[int, Path] = {}
        if is_first():
            folders = dict(zip(config.seed_numbers, stage.seed_folders, strict=True))
        for seed, folder in folders.items():
            folder.mkdir(parents=True, exist_ok=True)
            history = History(config)
            for row in cut_metrics(folder, done, config.evaluate_every):
                history.recall(row)
            title = f"{stage.title}, seed {seed}"
            loggers = open_loggers(
                stage.manifest["loggers"], folder, title, config, stage.steps_after(done)
            )
            evaluated = [
                row["collective return"]["mean"] for row in read_rows(folder / EVALUATIONS)
            ]
            recorder = Recorder(
                stage=stage,
                seed=seed,
                folder=folder,
                loggers=stack.enter_context(loggers),
                metrics=stack.enter_context(open_metrics(folder)),
                history=history,
                evaluator=evaluator,
                best_evaluated=max(evaluated, default=-math.inf),
            )
            recorders.append(recorder)
            stack.callback(_draw_curve, folder, title)
        yield recorders


def _draw_curve(folder: Path, title: str) -> None:
    draw_learning_curve(folder, thinned_rows(folder, POINTS), title)
