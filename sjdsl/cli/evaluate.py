"""`sjdsl evaluate`: prints what a policy earns, compared with a random policy in the same episodes, or as a few agents among scripted ones."""

import math
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import SEED, EnvironmentOptions, environment_options, make_environment, named_in, written_options
from sjdsl.cli.film import check_film, save_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import check_policy, code_option, warnings_as_notes
from sjdsl.cli.provenance import provenance_of
from sjdsl.cli.scenarios import OR_A_GAME, evaluate_in_scenarios
from sjdsl.cli.stages import LOADING, stages
from sjdsl.trainers.policy_names import UNTRAINED, split_name

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Estimate, Evaluation

OF_ANY_RUN = ("run", "episodes", "seed", "greedy", "which", "film", "scenario", "allow_code")  # parameters that make sense without --game
STORED = ".safetensors"


@click.command("evaluate")
@click.argument("run", metavar="RUN|POLICY")
@click.option("--game", metavar="GAME", help="The game in which all agents play POLICY.")
@click.option("--scenario", metavar="NAME|all", help="Play RUN among the policies of a scenario of the game, or A,B.")
@click.option("--episodes", type=click.IntRange(min=1), metavar="N", default=30, show_default=True, help="Episodes to play.")
@click.option("--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episodes.")
@click.option("--greedy/--drawn", default=None, help="Take the best action, or draw one.  [default: drawn; greedy with vdn]")
@click.option("--which", type=click.Choice(["last", "best"]), help="The last policy of a run, or its best, as in RUN@best.")
@click.option("--film", metavar="FILE", help="Also draw an episode: a .gif, .mp4 or .html.")
@click.option("-o", "output", metavar="FILE|DIR", help="Where the figures go: a .json of --game, a folder of --scenario.")
@code_option
@environment_options
def command(
    run: str,
    game: str | None,
    scenario: str | None,
    episodes: int,
    seed: int,
    greedy: bool | None,
    which: str | None,
    film: str | None,
    output: str | None,
    options: EnvironmentOptions,
) -> None:
    """Evaluates the policy of RUN, or any POLICY in a GAME, beside a random one; writes the figures of RUN to a file in it.

    RUN is a folder that `sjdsl train` wrote, or one of its policies: RUN@best, RUN@UPDATE; of several seeds each is evaluated. POLICY is
    random, stay, a policy of the game's file, a .safetensors file, or FILE.py:FUNCTION. With --scenario there is a score between random
    agents, 0, and the best scripted ones, 1; the same command goes on with a stopped one.
    """
    path, named = split_name(run)
    if game is None:
        _check_without_game(scenario)
    if which is not None and named not in (which, "last"):
        raise click.UsageError(f"{run} names one policy and --which {which} another; leave one of them out")
    if scenario is not None:
        if film is not None or greedy is not None:
            raise click.UsageError(f"{'--film' if film is not None else '--greedy' if greedy else '--drawn'} is not for --scenario")
        chosen = f"{run}@{which}" if which is not None and path == Path(run) else run
        evaluate_in_scenarios(chosen, scenario, game, episodes, seed, output, options)
        return
    if film is not None:
        check_film(Path(film))
        require_folder_of(Path(film))
    if game is not None:
        if which is not None:
            raise click.UsageError(f"--which is for a run, and `{run}` is to be a policy of its own")
        env, policy = _evaluate_policy(run, game, episodes, seed, greedy, output, options)
    else:
        provenance = provenance_of(path, OR_A_GAME)
        with stages(LOADING), named_in(path):
            env = make_environment(provenance)
        folders = sorted(path.glob("seed_*")) or [path]
        for folder in folders:
            evaluate_run(folder, env, episodes, seed, greedy, which or named)
        list_files(path)
        policy = stored_policy(folders[0], env, greedy, which or named) if film is not None else None
    if film is not None:
        with stages("drawing an episode") as say:
            done = save_film(env, policy, Path(film), env.episode_length, seed, say=say)
        click.echo(done)


def _check_without_game(scenario: str | None) -> None:
    """Raises UsageError for options that mean nothing without --game."""
    given = written_options(*OF_ANY_RUN)
    if "-o" in given and scenario is None:
        raise click.UsageError("-o is for --scenario and --game; without them the figures of a run are written to its folder")
    for option in given:
        if option != "-o":
            raise click.UsageError(f"{option} is for --game; without it a run plays in the game that it was trained in")


def evaluate_run(path: Path, env: "Environment", episodes: int, seed: int, greedy: bool | None = None, which: str | int = "last") -> None:
    """Prints the returns of the trained and of a random policy with their intervals, and stores the trained one's in the run's folder."""
    from sjdsl.trainers import save_evaluation

    def save(played: "Evaluation") -> None:
        name = "evaluation.json" if which == "last" else f"evaluation_{which}.json"  # none takes the place of another's
        save_evaluation(played, path / name, {"policy": which, "seed": seed, "greedy": greedy})

    what = {"last": "", "best": ", the best policy"}.get(str(which), f", the policy of update {which}")
    _compare(env, "trained", stored_policy(path, env, greedy, which), episodes, seed, save, what)


def _evaluate_policy(
    policy: str, game: str, episodes: int, seed: int, greedy: bool | None, output: str | None, options: EnvironmentOptions
) -> tuple["Environment", Any]:
    """Prints what a policy that isn't a run earns; writes the figures to `output`, if given. Returns the environment and the policy."""
    _check_policy(policy, options.check(game), greedy, output)
    with stages(LOADING):
        env = options.make(game)
        from sjdsl.experiments import find_pool
        from sjdsl.trainers import find_policy, save_evaluation
        from sjdsl.trainers.run_folder import describe_game

        with warnings_as_notes():
            (player,) = find_pool(policy, env).players  # which refuses the policy of another game
            found = player.policy_of(player.parameters) if greedy is None else find_policy(policy, env, greedy)

    def save(played: "Evaluation") -> None:
        if output is not None:
            about = {"policy": policy, "digest": player.digest, "game": describe_game(env), "seed": seed, "greedy": greedy}
            save_evaluation(played, output, about)

    _compare(env, policy, found, episodes, seed, save)
    if output is not None:
        click.echo(f"\n{output}")
    return env, found


def _check_policy(policy: str, game: "ir.Game", greedy: bool | None, output: str | None) -> None:
    """Refuses, before JAX is loaded, what can be refused by then."""
    path, _ = split_name(policy)
    named = policy in (*UNTRAINED, *(declared.name for declared in game.policies))
    if path.is_dir() and not named:
        raise click.UsageError(
            f"--game is for a policy that is no run, or for --scenario; {path} is a folder, and a run is evaluated in its own game. "
            "In another form of it, name the file of a policy, such as RUN/policies/last.safetensors"
        )
    check_policy(policy, game)
    if greedy is not None and (named or path.suffix != STORED):
        raise click.UsageError(f"{'--greedy' if greedy else '--drawn'} is for trained policies, and `{policy}` is none")
    if output is not None:
        if Path(output).suffix != ".json":
            raise click.UsageError(f"-o names the file for the figures, which must end in .json; `{output}` does not")
        require_folder_of(Path(output))


def _compare(
    env: "Environment", name: str, policy: Any, episodes: int, seed: int, save: Callable[["Evaluation"], None], what: str = ""
) -> None:
    """Plays episodes with a policy and, in the same episodes, with a random one; prints a table of both. `what`: stands in its title."""
    from sjdsl.trainers import evaluate, random_policy, summarise
    from sjdsl.trainers.evaluation import evaluation_key

    key = evaluation_key(seed)
    with stages(f"compiling and playing {episodes} episodes of {'the trained policy' if name == 'trained' else name}") as say:
        played = evaluate(env, policy, key, episodes)
        save(played)
        columns = {name: summarise(played)}
        if name != "random":
            say(f"compiling and playing {episodes} episodes of a random policy")
            columns["random"] = summarise(evaluate(env, random_policy(env), key, episodes))
    _echo_table(env, columns, episodes, what)
    earned = [_interval(figures["collective return"]) for figures in columns.values()]
    click.echo(f"return {earned[0]}" + (f" against {earned[1]} of a random policy" if len(earned) > 1 else ""))


def _echo_table(env: "Environment", columns: Mapping[str, "Mapping[str, Estimate]"], episodes: int, what: str) -> None:
    """Prints the figures of all agents together, a column for each policy."""
    undeclared = {f"{'final' if measure.mean else 'mean'} {measure.name}" for measure in env.game.measures}
    names = [name for name in next(iter(columns.values())) if name.startswith("return of") or " of agent " not in name]
    rows = [(name, *(_interval(figures[name]) for figures in columns.values())) for name in names if name not in undeclared]
    rows = [("", *columns), *rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    click.echo(f"\n{env.title or env.name}{what}: means of {episodes} episodes with their 95 % confidence intervals")
    for row in rows:
        click.echo("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _interval(figure: "Estimate") -> str:
    """Returns `97.3 [95.1, 99.4]`; what some episode does not define has no mean."""
    if math.isnan(figure.mean):
        return "not defined"
    return f"{figure.mean:.4g} [{figure.low:.4g}, {figure.high:.4g}]"


def stored_policy(source: Path, env: "Environment", greedy: bool | None = None, which: str | int = "last") -> Any:
    """Returns the policy in the folder of a run or in a file; what is to be said about it is said in a line."""
    from sjdsl.trainers import load_policy
    from sjdsl.trainers.run_state import run_state

    with warnings_as_notes():
        state = run_state(source) if source.is_dir() and not isinstance(which, int) else None
        for update in state.diverged.values() if state is not None else ():
            warnings.warn(
                f"{source} has failed: its loss was not finite in update {update}, and this is its policy of before", stacklevel=2
            )
        if state is not None and state.unfinished:
            warnings.warn(f"{source} is not known to have ended its training: {state.unfinished}", stacklevel=2)
        return load_policy(source, env, greedy=greedy, which=which)


def list_files(run_dir: Path) -> None:
    """Prints the files of a run."""
    files = sorted(path for path in run_dir.iterdir() if path.is_file())
    click.echo(f"\n{run_dir}/")
    for path in files:
        click.echo(f"  {path.name}  {path.stat().st_size / 1000:.1f} kB")
    for folder in sorted(path for path in run_dir.iterdir() if path.is_dir()):
        inside = sorted(path.name for path in folder.iterdir() if path.suffix != ".json")
        what = "of update " if folder.name == "checkpoints" and inside else ""
        click.echo(f"  {folder.name}/  {what}{', '.join(inside)}")
