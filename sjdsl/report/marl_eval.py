"""Results in the JSON of marl-eval: environment, task, algorithm, run, step.

Source of the format: Gorsane et al. 2022 and the README of instadeepai/marl-eval, "Data Structure for Raw Experiment data". A task is a
game, an algorithm a way of training, a run a seed. Each step has one figure, the mean over the episodes that ended about then; the
absolute metric is the mean over the episodes that evaluate the last policy.
"""

from typing import Any

from sjdsl.report.contents import Contents
from sjdsl.report.ways import in_words

ENVIRONMENT = "sjdsl"
METRIC = "return"  # collective return of an episode


def marl_eval(contents: Contents) -> tuple[dict[str, Any], list[str]]:
    """Returns the nested data, and what marl-eval will not take as it is: it wants the same algorithms and runs in every task."""
    tasks: dict[str, Any] = {}
    for game in contents.games:
        algorithms: dict[str, Any] = {}
        for run in contents.index.runs(game.setting) if game.setting is not None else ():
            runs = _runs(contents, run)
            if runs:
                name = in_words(run)
                algorithms[name if name not in algorithms else f"{name} ({run.run[-8:]})"] = runs
        if algorithms:
            tasks[game.label] = dict(sorted(algorithms.items()))
    return {ENVIRONMENT: tasks}, _unequal(tasks)


def _runs(contents: Contents, run: Any) -> dict[str, Any]:
    """Returns the seeds that are done and evaluated, each with its steps; nothing where a seed has failed, as others would be averaged."""
    if contents.index.has_failed(run):
        return {}
    seeds = {row.seed: row for row in contents.index.seeds(run) if row.status == "done" and row.collective_return is not None}
    points: dict[int, list[tuple[int, float]]] = {seed: [] for seed in seeds}
    for point in contents.index.curve(run):
        if point.seed in points:
            points[point.seed].append((point.env_steps, point.collective_return))
    found = {}
    for seed, curve in points.items():
        steps = {f"step_{number}": {"step_count": step, METRIC: [value]} for number, (step, value) in enumerate(sorted(curve), 1)}
        found[f"seed_{seed}"] = {**steps, "absolute_metrics": {METRIC: [seeds[seed].collective_return]}}
    return found


def _unequal(tasks: dict[str, Any]) -> list[str]:
    if len({tuple(algorithms) for algorithms in tasks.values()}) > 1:
        return ["marl-eval wants the same ways of training in every game: here they differ, and `marl_eval.json` has them as they are"]
    counts = {(len(runs), *(len(steps) for steps in runs.values())) for algorithms in tasks.values() for runs in algorithms.values()}
    if len(counts) > 1:
        return ["marl-eval wants equally many seeds and steps everywhere: here they differ, and `marl_eval.json` has them as they are"]
    return []
