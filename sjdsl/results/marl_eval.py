"""Results in the JSON of marl-eval: environment, task, algorithm, run, step.

Source of the format: Gorsane et al. 2022 and the README of instadeepai/marl-eval, "Data Structure for Raw Experiment data". A task is a
game, an algorithm a way of training, a run a seed. Each step has one figure, the mean over the episodes that ended about then; the
absolute metric is the mean over the episodes that evaluate the last policy.
"""

from typing import TYPE_CHECKING, Any

from sjdsl.results.sections import ways
from sjdsl.results.selecting import games

if TYPE_CHECKING:
    import pandas as pd

METRIC = "return"  # collective return of an episode


def marl_eval(frame: "pd.DataFrame", curves: "pd.DataFrame") -> tuple[dict[str, Any], list[str]]:
    """Returns the nested data, and warnings about data that marl-eval rejects, which needs the same algorithms and runs in every task."""
    tasks: dict[str, Any] = {}
    for setting, rows in games(frame):
        whole = rows[~rows.run.isin(rows[rows.status == "failed"].run)]  # where a seed has failed, others would be averaged
        algorithms = {words: _runs(seeds, curves) for words, seeds in ways(whole)}
        tasks |= {setting.label: found} if (found := {words: runs for words, runs in algorithms.items() if runs}) else {}
    return {"sjdsl": tasks}, _unequal(tasks)


def _runs(seeds: "pd.DataFrame", curves: "pd.DataFrame") -> dict[str, Any]:
    found = {}
    for row in seeds.dropna(subset="collective_return").itertuples():
        points = curves[(curves.run == row.run) & (curves.seed == row.seed)]
        pairs = zip(points.env_steps, points.collective_return, strict=True)
        steps = {f"step_{number}": {"step_count": int(step), METRIC: [value]} for number, (step, value) in enumerate(pairs, 1)}
        found[f"seed_{row.seed}"] = {**steps, "absolute_metrics": {METRIC: [row.collective_return]}}
    return found


def _unequal(tasks: dict[str, Any]) -> list[str]:
    if len({tuple(algorithms) for algorithms in tasks.values()}) > 1:
        return ["marl-eval needs the same ways of training in every game; they differ here, so marl-eval will reject `marl_eval.json`"]
    counts = {(len(runs), *(len(steps) for steps in runs.values())) for algorithms in tasks.values() for runs in algorithms.values()}
    if len(counts) > 1:
        return ["marl-eval needs equally many seeds and steps everywhere; they differ here, so marl-eval will reject `marl_eval.json`"]
    return []
