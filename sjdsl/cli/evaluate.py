"""`sjdsl evaluate`: prints the returns of a policy, compared with a random policy in the same episodes."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import SEED, make_environment, named_in
from sjdsl.cli.evaluate_policy import evaluate_policy
from sjdsl.cli.evaluation_table import echo_table, interval
from sjdsl.cli.film import check_film, save_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import code_option, warnings_as_notes
from sjdsl.cli.provenance import provenance_of
from sjdsl.cli.scenarios import OR_A_GAME, check_scenario_options, evaluate_in_scenarios, scenario_options
from sjdsl.cli.stages import LOADING, stages
from sjdsl.trainers.policy_names import split_name

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment


@click.command("evaluate")
@click.argument("run", metavar="RUN|POLICY")
@click.option("--episodes", type=click.IntRange(min=1), metavar="N", default=30, show_default=True, help="Episodes to play.")
@click.option("--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episodes.")
@click.option(
    "--greedy/--drawn",
    default=None,
    help="Take the best action, or draw one; by default policies of ippo, mappo and irat draw their actions, those of vdn take the best.",
)
@click.option(
    "--which", type=click.Choice(["last", "best"]), help="The last policy of a run, which is the default, or its best; as in RUN@best."
)
@click.option("--film", metavar="FILE", help="Also draw an episode: a .gif or .mp4, or an .html page.")
@code_option
@scenario_options
def command(
    run: str,
    episodes: int,
    seed: int,
    greedy: bool | None,
    which: str | int | None,
    film: str | None,
    scenario: str | None,
    game: str | None,
    output: str | None,
    **described: Any,
) -> None:
    """Evaluates the policy of RUN, or any POLICY in a GAME, and a random one; writes the figures of RUN to a file in it.

    RUN is a folder that `sjdsl train` wrote, or one of its policies: RUN@best, RUN@UPDATE; of several seeds, each is evaluated.
    The file is evaluation.json for the last policy, evaluation_best.json or evaluation_UPDATE.json for another.

    With --game GAME all agents of the game play POLICY, which is no run: random, stay, a policy of the game's file, a .safetensors
    file, or FILE.py:FUNCTION. The figures are written where -o FILE says.

    With --scenario the agents of RUN play among the policies of a scenario, with a score between random agents, 0, and the best
    scripted ones, 1. The file is scenarios.json, and the same command goes on with a stopped one. With --game GAME, RUN may be any policy.
    """

    check_scenario_options(scenario, game, output, described)
    path, named = split_name(run)
    if which is not None and named not in (which, "last"):
        raise click.UsageError(f"{run} names one policy and --which {which} another; leave one of them out", click.get_current_context())
    if scenario is not None:
        if film is not None or greedy is not None:
            unfit = "--film" if film is not None else "--greedy" if greedy else "--drawn"
            raise click.UsageError(f"{unfit} is not for --scenario", click.get_current_context())
        policy = f"{run}@{which}" if which is not None and path == Path(run) else run
        evaluate_in_scenarios(policy, scenario, game, episodes, seed, output, described)
        return
    given, which = which, which or named
    if film is not None:
        check_film(Path(film))
        require_folder_of(Path(film))
    if game is not None:
        if given is not None:
            raise click.UsageError(f"--which is for a run, and `{run}` is to be a policy of its own", click.get_current_context())
        evaluate_policy(run, game, episodes, seed, greedy, film, output, described)
        return
    provenance = provenance_of(path, OR_A_GAME)
    with stages(LOADING), named_in(path):
        env = make_environment(provenance)
    folders = sorted(path.glob("seed_*")) or [path]
    for folder in folders:
        evaluate_run(folder, env, episodes, seed, greedy, which)
    list_files(path)
    if film is not None:
        policy = stored_policy(folders[0], env, greedy, which)
        with stages("drawing an episode") as say:
            done = save_film(env, policy, Path(film), env.episode_length, seed, say=say)
        click.echo(done)


def evaluate_run(path: Path, env: "Environment", episodes: int, seed: int, greedy: bool | None = None, which: str | int = "last") -> None:
    """Prints the returns of the trained and of a random policy with their intervals, and stores the trained one's."""
    from sjdsl.trainers import evaluate, random_policy, save_evaluation, summarise
    from sjdsl.trainers.evaluation import evaluation_key

    key = evaluation_key(seed)
    policy = stored_policy(path, env, greedy, which)
    with stages(f"compiling and playing {episodes} episodes of the trained policy") as say:
        trained = evaluate(env, policy, key, episodes)
        save_evaluation(trained, path / evaluation_file(which), {"policy": which, "seed": seed, "greedy": greedy})
        say(f"compiling and playing {episodes} episodes of a random policy")
        chance = summarise(evaluate(env, random_policy(env), key, episodes))
    figures = summarise(trained)
    played = {"last": "", "best": ", the best policy"}.get(str(which), f", the policy of update {which}")
    echo_table(env, {"trained": figures, "random": chance}, episodes, played)
    earned, guessed = interval(figures["collective return"]), interval(chance["collective return"])
    click.echo(f"trained return {earned} against {guessed} of a random policy")


def evaluation_file(which: str | int) -> str:
    """Returns the name of the file for the figures of a policy: none takes the place of another's."""
    return "evaluation.json" if which == "last" else f"evaluation_{which}.json"


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
