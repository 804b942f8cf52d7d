"""`sjdsl evaluate`: prints what a policy earns beside a random policy in the same episodes, or as
focal agents among scripted ones."""

import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import (
    EnvironmentOptions,
    environment_options,
    make_environment,
    without_quoting_game,
    written_options,
)
from sjdsl.cli.episode_options import episodes_option, seed_option
from sjdsl.cli.film import check_film, save_film
from sjdsl.cli.folders import require_folder_of, require_writable
from sjdsl.cli.model_options import Asking, model_options
from sjdsl.cli.next_commands import allowing, echo_next, repeated_options
from sjdsl.cli.policies import check_policy, code_option, warnings_as_notes
from sjdsl.cli.provenance import arguments_of_run
from sjdsl.cli.scenarios import OR_A_GAME, evaluate_in_scenarios
from sjdsl.cli.stages import LOADING, stages
from sjdsl.library.tasks import replaced_tasks, splits_of
from sjdsl.models import Limits
from sjdsl.trainers.policies.estimates import difference, estimate
from sjdsl.trainers.policies.stored_evaluation import RETURN, read_evaluation
from sjdsl.trainers.runs.seeds_in_words import seeds_in_words, seeds_of_each
from sjdsl.trainers.settings.extensions import allowed_code
from sjdsl.trainers.settings.policy_names import UNTRAINED, split_name

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Estimate, Evaluation

# Parameters that are allowed without --game.
WITHOUT_GAME = (
    "run", "episodes", "seed", "greedy", "film", "scenario", "allow_code", "tasks", "split",
    "problem", "parallel", "budget", "calls", "dry_run", "status",
)  # fmt: skip
# Parameters that say which form of a game is played.
OF_GAME = ("variant", "map_file", "agents", "params", "tasks", "split", "problem")
STORED = ".safetensors"


@click.command("evaluate")
@click.argument("run", metavar="RUN|POLICY")
@click.option(
    "--game",
    metavar="GAME",
    help="The game in which all agents play POLICY, or where the game of RUN is now.",
)
@click.option(
    "--scenario", metavar="NAME|all", help="Play RUN in a scenario of the game, or in several: A,B."
)
@episodes_option(30, "Episodes to play.")
@seed_option("Seed of the episodes.")
@click.option(
    "--greedy/--drawn",
    default=None,
    help="Take the best action, or draw one.  [default: drawn; greedy with vdn]",
)
@click.option("--film", metavar="FILE", help="Also draw an episode: a .gif, .mp4 or .html.")
@click.option(
    "-o",
    "output",
    metavar="FILE|DIR",
    help="Where results go: a .json with --game, a folder with --scenario.",
)
@code_option
@environment_options
@model_options
def command(
    run: str,
    game: str | None,
    scenario: str | None,
    episodes: int,
    seed: int,
    greedy: bool | None,
    film: str | None,
    output: str | None,
    options: EnvironmentOptions,
    asking: Asking,
) -> None:
    """Evaluates the policy of RUN, or any POLICY in a GAME, beside a random one; the results of RUN
    go to a file in its folder.

    RUN is a folder that `sjdsl train` wrote (each of its seeds is evaluated), RUN@best or
    RUN@UPDATE. POLICY is random, stay, a policy of the game's file, a .safetensors file, or
    FILE.py:FUNCTION. --scenario gives a score between 0, random agents, and 1, the best scripted
    ones.
    """
    if game is None:
        _refuse_options_for_game(scenario)
    if scenario is not None:
        if film is not None:
            raise click.UsageError("--film shows no scenario: leave out one of the two")
        if greedy is not None:
            raise click.UsageError(
                f"{_greedy_option(greedy)} is not for --scenario: leave out one of the two"
            )
        evaluate_in_scenarios(run, scenario, game, episodes, seed, output, options, asking)
        if game is None:
            _echo_next(run, None, _more_of_run(run))
        return
    if asking != Asking(Limits()):
        raise click.UsageError(
            "--parallel, --budget, --calls, --dry-run and --status are for --scenario"
        )
    if film is not None:
        check_film(Path(film))
        require_folder_of(Path(film))
    if game is not None and not _is_run(run, game):
        env, policy = _evaluate_policy(run, game, episodes, seed, greedy, output, options)
        training = f"sjdsl train {shlex.quote(game)}{repeated_options(*OF_GAME)}"
        commands = [(f"{training} --preset two_cores", "agents that learn in this game")]
    else:
        path, which = split_name(run)
        arguments = arguments_of_run(path, OR_A_GAME, game, options.map)
        with stages(LOADING), without_quoting_game(path):
            env = make_environment(replaced_tasks(arguments, _of_one_side(options)))
        folders = sorted(path.glob("seed_*")) or [path]
        for folder in folders:
            require_writable(folder)
        for note in notes_on_training(path, which):
            click.echo(f"note: {note}", err=True)
        results = [
            evaluate_run(folder, env, episodes, seed, greedy, which, options) for folder in folders
        ]
        _print_over_seeds(results)
        list_files(path)
        policy = stored_policy(folders[0], env, greedy, which) if film is not None else None
        commands = _more_of_run(run)
    if film is not None:
        with stages("drawing an episode") as say:
            players = [run] * env.num_agents
            length = env.episode_length
            summary = save_film(env, policy, Path(film), length, seed, say, players=players)
        click.echo(summary)
    if env.game.scenarios:
        focal = f"sjdsl evaluate {shlex.quote(run)} --scenario all{_options_of_policy()}"
        commands.insert(0, (focal, "a score among the scripted agents of the game's file"))
    _echo_next(run, film, commands)


def _more_of_run(run: str) -> list[tuple[str, str]]:
    """Returns commands for a run that has been evaluated, each with its purpose."""
    path = shlex.quote(str(split_name(run)[0]))
    return [
        (f"sjdsl plot {path} -o curves.png", "how it learnt"),
        (f"sjdsl report {path} -o report", "its results as a page of tables and pictures"),
    ]


def _echo_next(policy: str, film: str | None, others: Sequence[tuple[str, str]]) -> None:
    """Prints two commands for a policy that has been evaluated: a film, unless there is one, and
    the first of the others."""
    commands = [*others]
    if film is None:
        file = re.sub(r"\W+", "_", Path(policy).name).strip("_")
        filming = f"sjdsl evaluate {shlex.quote(policy)}{_options_of_policy()} --film {file}.gif"
        commands.insert(0, (filming, "the same, with an episode on film"))
    echo_next(*commands[:2])


def _options_of_policy() -> str:
    """Returns the options with which this command has found the policy and made its game."""
    return repeated_options("game", *OF_GAME) + allowing(allowed_code())


def _refuse_options_for_game(scenario: str | None) -> None:
    """Raises UsageError for an option on the command line that needs --game."""
    for option in written_options(*WITHOUT_GAME):
        if option != "-o":
            raise click.UsageError(
                f"{option} is for --game; without it, a run plays in the game it was trained in"
            )
        if scenario is None:
            raise click.UsageError(
                "-o is for --scenario and --game; without them, the results of a run go to its "
                "folder"
            )


def _greedy_option(greedy: bool) -> str:
    return "--greedy" if greedy else "--drawn"


def _is_run(policy: str, game: str) -> bool:
    """Whether a text names a run, which is evaluated in its own game.

    Raises UsageError for an option that doesn't apply to runs.
    """
    path, _ = split_name(policy)
    if not path.is_dir() or _is_declared(policy, EnvironmentOptions().check(game)):
        return False
    for option in written_options(*WITHOUT_GAME, "game", "map_file"):
        raise click.UsageError(
            f"{option} is for a policy that isn't a run; {path} is a folder, and a run is "
            "evaluated in its own game. To evaluate it in another form of the game, name the file "
            "of a policy, such as RUN/policies/last.safetensors"
        )
    return True


def _is_declared(policy: str, game: "ir.Game") -> bool:
    """Whether a text is the name of an untrained policy, or of one that the game's file
    declares.
    """
    return policy in UNTRAINED or any(policy == declared.name for declared in game.policies)


def evaluate_run(
    path: Path,
    env: "Environment",
    episodes: int,
    seed: int,
    greedy: bool | None = None,
    which: str | int = "last",
    options: EnvironmentOptions | None = None,
) -> dict[str, "Estimate"]:
    """Prints the returns of a trained and of a random policy with their intervals.

    Stores those of the trained one in the run's folder, unless there is an evaluation of the same
    policy in more episodes already, or the user has chosen the tasks. Returns the differences to
    held-out tasks by split.
    """
    from sjdsl.trainers import save_evaluation
    from sjdsl.trainers.policies.policy_file import policy_path, update_of

    file = path / ("evaluation.json" if which == "last" else f"evaluation_{which}.json")

    options = options or EnvironmentOptions()

    def save(evaluation: "Evaluation", of_splits: Mapping[str, Any]) -> None:
        """Stores an evaluation in the run, unless it holds a longer one of the same policy."""
        if _of_one_side(options):
            click.echo(f"{file} is of the tasks of the run, and stays as it is", err=True)
            return
        update = update_of(policy_path(path, which))
        stored = read_evaluation(file)
        if stored is not None and stored.episodes > episodes and stored.update == update:
            click.echo(
                f"{file} already holds an evaluation of this policy in {stored.episodes} episodes, "
                "and is kept; delete it to store this one",
                err=True,
            )
            return
        about = {"policy": which, "update": update, "seed": seed, "greedy": greedy, **of_splits}
        save_evaluation(evaluation, file, about)

    titles = {"last": "", "best": ", the best policy"}
    title = titles.get(str(which), f", the policy of update {which}")
    policy = partial(stored_policy, path, greedy=greedy, which=which)
    held_out = _held_out(env, options)
    return _compare(env, "trained", policy, episodes, seed, save, title, held_out)


def _evaluate_policy(
    policy: str,
    game: str,
    episodes: int,
    seed: int,
    greedy: bool | None,
    output: str | None,
    options: EnvironmentOptions,
) -> tuple["Environment", Any]:
    """Prints what a policy that isn't a run earns, and writes it to `output`, unless it is None.

    Returns the environment and the policy.
    """
    of_game = replace(options, split=_of_one_side(options).get("split"))
    _check_policy(policy, of_game.check(game), greedy, output)
    with stages(LOADING):
        env = of_game.make(game)
        from sjdsl.experiments import find_pool
        from sjdsl.trainers import find_policy, save_evaluation
        from sjdsl.trainers.policies.loading import refuse_host
        from sjdsl.trainers.runs.run_folder import describe_game

        refuse_host(policy)
        with warnings_as_notes():
            (player,) = find_pool(policy, env).players  # refuses a policy of another game
            act = player.policy_of(player.parameters)
            if greedy is not None:
                act = find_policy(policy, env, greedy)

    def policy_for(played: "Environment") -> Any:
        if played is env:
            return act
        with warnings_as_notes():
            return find_policy(policy, played, greedy)

    def save(evaluation: "Evaluation", of_splits: Mapping[str, Any]) -> None:
        """Stores an evaluation where `--output` says."""
        if output is not None:
            about = {
                "policy": policy,
                "digest": player.digest,
                "game": describe_game(env),
                "seed": seed,
                "greedy": greedy,
                **of_splits,
            }
            save_evaluation(evaluation, output, about)

    held_out = _held_out(env, options)
    _compare(env, policy, policy_for, episodes, seed, save, held_out=held_out)
    if output is not None:
        click.echo(f"\n{output}")
    return env, act


def _check_policy(policy: str, game: "ir.Game", greedy: bool | None, output: str | None) -> None:
    """Checks the options as far as possible before JAX loads."""
    path, _ = split_name(policy)
    check_policy(policy, game)
    if greedy is not None and (_is_declared(policy, game) or path.suffix != STORED):
        raise click.UsageError(
            f"{_greedy_option(greedy)} is for trained policies, and `{policy}` isn't one"
        )
    if output is not None:
        if Path(output).suffix != ".json":
            raise click.UsageError(
                f"-o names the file for the results, which must end in .json; `{output}` doesn't"
            )
        require_folder_of(Path(output))


def _of_one_side(options: EnvironmentOptions) -> dict[str, Any]:
    """Returns the tasks that the user has chosen, which alone are played; without them, training
    and held-out tasks are compared."""
    if options.tasks is None and options.problem is None:
        return {}
    return options.of_tasks


def _held_out(env: "Environment", options: EnvironmentOptions) -> dict[str, "Environment"]:
    """Returns the environments of the held-out tasks to compare with, by split."""
    from sjdsl.library.factory import with_other_tasks

    if _of_one_side(options):
        return {}
    if env.tasks != "training":
        if options.split is not None:
            raise click.UsageError(_why_nothing_is_compared(env))
        return {}
    splits = splits_of(env.game.task) if options.split is None else (options.split,)
    try:
        return {split: with_other_tasks(env, "held_out", split) for split in splits}
    except ValueError as error:
        raise click.ClickException(str(error)) from None


def _why_nothing_is_compared(env: "Environment") -> str:
    """Returns why --split alone says nothing in an environment of other than training tasks."""
    task = env.game.task
    if task is None:
        return f"--split is for games with a task, and {env.name} has none"
    if not splits_of(task):
        return f"--split is for games that hold tasks out, and {env.name} holds out none"
    match env.tasks:
        case "all":
            played = "all tasks"
        case "held_out":
            played = f"held-out tasks, {env.split}"
        case _:
            fields = ", ".join(f"{name}={value}" for name, value in env.tasks.items())
            played = f"tasks with {fields}"
    return (
        "--split alone compares held-out tasks with training tasks, and the run is one on "
        f"{played}: to play the tasks of the split, add --tasks held_out"
    )


def _compare(
    env: "Environment",
    name: str,
    policy_for: Callable[["Environment"], Any],
    episodes: int,
    seed: int,
    save: Callable[["Evaluation", Mapping[str, Any]], None],
    title: str = "",
    held_out: Mapping[str, "Environment"] | None = None,
) -> dict[str, "Estimate"]:
    """Plays episodes with a policy and the same episodes with a random one; prints a table of both.

    Args:
      policy_for: returns the policy in an environment.
      save: stores what the policy earns, and what it earns in held-out tasks.
      title: follows the game's name in the title of the table.
      held_out: environments with held-out tasks by split, which are compared with `env`.

    Returns the differences of the returns in `env` and in those.
    """
    from sjdsl.experiments.summaries import in_columns
    from sjdsl.trainers import evaluate, random_policy, summarise
    from sjdsl.trainers.policies.evaluation import evaluation_key

    key = evaluation_key(seed)
    whose = "the trained policy" if name == "trained" else name
    differences: dict[str, Estimate] = {}
    sides = [("tasks", "collective return", "training minus these")]
    of_splits = {}
    with stages(f"compiling and playing {episodes} episodes of {whose}") as say:
        evaluation = evaluate(env, policy_for(env), key, episodes)
        returns_of_training = evaluation.collective_returns
        columns = {name: summarise(evaluation)}
        sides.append(("training", str(columns[name][RETURN]), ""))
        for split, other in (held_out or {}).items():
            say(f"compiling and playing {episodes} episodes of held-out tasks, {split}")
            of_split = evaluate(other, policy_for(other), key, episodes)
            figures = summarise(of_split)
            difference_ = difference(returns_of_training, of_split.collective_returns)
            differences[split] = difference_
            side = f"held out, {split}"
            sides.append((side, str(figures[RETURN]), str(difference_)))
            of_splits[split] = {
                "summary": {figure: asdict(value) for figure, value in figures.items()},
                "training_minus_held_out": asdict(difference_),
            }
        save(evaluation, {"held_out": of_splits} if of_splits else {})
        if name != "random":
            say(f"compiling and playing {episodes} episodes of a random policy")
            columns["random"] = summarise(evaluate(env, random_policy(env), key, episodes))
    rows = [("", *columns)]
    for figure in columns[name]:
        if _is_listed(figure, env.game):
            intervals = [str(column[figure]) for column in columns.values()]
            rows.append((figure, *intervals))
    click.echo(
        f"\n{env.title or env.name}{title}: means of {episodes} episodes with their "
        f"95 % confidence intervals\n{in_columns(rows)}"
    )
    if differences:
        click.echo(f"\n{in_columns(sides)}")
    returns = [str(column[RETURN]) for column in columns.values()]
    baseline = f" against {returns[1]} of a random policy" if len(returns) > 1 else ""
    click.echo(f"return {returns[0]}{baseline}")
    return differences


def _print_over_seeds(results: Sequence[Mapping[str, "Estimate"]]) -> None:
    """Prints the differences of training and held-out tasks over the training seeds of a run."""
    import numpy as np

    if len(results) < 2:
        return
    for split in results[0]:
        means = np.array([of_seed[split].mean for of_seed in results])
        click.echo(
            f"training minus held out, {split}, over {len(results)} training seeds: "
            f"{estimate(means)}"
        )


def _is_listed(figure: str, game: "ir.Game") -> bool:
    """Whether the table has a figure: of agents only the return, and of a measure only what it
    declares (its mean or its final value)."""
    if " of agent " in figure and not figure.startswith("return of"):
        return False
    for measure in game.measures:
        undeclared = f"final {measure.name}" if measure.mean else f"mean {measure.name}"
        if figure == undeclared:
            return False
    return True


def stored_policy(
    source: Path, env: "Environment", greedy: bool | None = None, which: str | int = "last"
) -> Any:
    """Returns the policy in the folder of a run or in a file; warnings about it are printed as
    notes.
    """
    from sjdsl.trainers import load_policy

    with warnings_as_notes():
        return load_policy(source, env, greedy=greedy, which=which)


def notes_on_training(run_dir: Path, which: str | int) -> Iterator[str]:
    """Yields what a reader of an evaluation should know about the training of the run: that it
    hasn't ended, or which seeds diverged."""
    from sjdsl.trainers.runs.run_state import run_state

    if isinstance(which, int):  # the policy of this update may be from before a seed diverged
        return
    state = run_state(run_dir)
    if state is None:
        return
    for update, seeds in seeds_of_each(state.diverged.items()).items():
        yield (
            f"{seeds_in_words(seeds)} of {run_dir} diverged (non-finite loss) in update {update}; "
            "the policy before that update is played"
        )
    if state.unfinished:
        yield f"{run_dir} may not have finished its training: {state.unfinished}"


def list_files(run_dir: Path) -> None:
    """Prints the files and folders of a run in one line."""
    paths = sorted(run_dir.iterdir(), key=lambda path: (path.is_dir(), path.name))
    names = [f"{path.name}/" if path.is_dir() else path.name for path in paths]
    click.echo(f"\n{run_dir}/: {', '.join(name for name in names if not name.startswith('.'))}")
