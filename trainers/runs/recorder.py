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
    METRICS_JSONL,
    Row,
    append_line,
    cut_metrics,
    read_rows,
    thinned_rows,
    to_disk,
)
from .run_folder import describe_game
from .run_stage import RunStage

Evaluator = Callable[[Array, Any], Evaluation]
POINTS = 1000  # of a learning curve, at most


@dataclass
class History:
    """Totals over the rows written so far; the rows themselves are only on disk."""

    config: Config
    updates: int = 0  # the number of the last row's update
    seconds: float = 0.0  # training time until then
    # of the episodes that ended since a policy was last stored by its number
    sum_of_returns: float = 0.0  # of collective returns
    num_episodes: float = 0.0
    best_mean: float = -math.inf  # the highest mean collective return between two such policies
    signs: Signs = field(default_factory=Signs)
    warnings: list[str] = field(default_factory=list)  # that the run learns nothing

    def add_row(self, row: Row) -> None:
        """Adds the row of the next update to the totals, and makes the warnings when due.

        Args:
          row: `episodes` is how many episodes ended in the update, and `collective_return` their
            mean, undefined if none ended.
        """
        self.updates = row["update"]
        self.seconds = row["seconds"]
        if row["episodes"] > 0:
            self.sum_of_returns += row["episodes"] * row["collective_return"]
            self.num_episodes += row["episodes"]
        self.signs.count(row)
        if is_due(self.updates, self.config):
            self.warnings = list(self.signs.warnings(self.config))

    def recall(self, row: Row) -> None:
        """Adds a row that was written before the run was stopped."""
        self.add_row(row)
        if self.is_mark(row["update"]):
            self.close()

    def is_mark(self, update: int) -> bool:
        """Whether the policy of an update is stored by its number."""
        return update % self.config.policy_updates == 0 or update == self.config.num_updates

    def close(self) -> bool:
        """Returns whether the episodes since the last stored policy have the best mean so far.

        Afterwards no episodes are counted: a policy is stored now.
        """
        mean = -math.inf
        if self.num_episodes:
            mean = self.sum_of_returns / self.num_episodes
        is_best = mean > self.best_mean
        self.best_mean = max(mean, self.best_mean)
        self.sum_of_returns = 0.0
        self.num_episodes = 0.0
        return is_best


@dataclass
class Recorder:
    """The files of one seed, and its loggers."""

    stage: RunStage
    seed: int
    folder: Path
    history: History
    loggers: Sequence[Log]
    evaluator: Evaluator
    best_evaluated: float  # the best collective return of the evaluations so far

    def append(self, row: Row) -> None:
        """Writes the row of an update."""
        append_line(self.folder / METRICS_JSONL, row)
        self.history.add_row(row)
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
        to_disk(self.folder / METRICS_JSONL)
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
        to_disk(self.folder / EVALUATIONS)
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
                history=history,
                evaluator=evaluator,
                best_evaluated=max(evaluated, default=-math.inf),
            )
            recorders.append(recorder)
            stack.callback(_draw_curve, folder, title)
        yield recorders


def _draw_curve(folder: Path, title: str) -> None:
    draw_learning_curve(folder, thinned_rows(folder, POINTS), title)
