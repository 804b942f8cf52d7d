"""`sjdsl evaluate POLICY --game GAME`: what a policy that is no run earns when all agents of a game play it."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import check_environment, describe_environment, make_environment, read_assignments
from sjdsl.cli.evaluation_table import echo_table, interval
from sjdsl.cli.film import save_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import check_policy, warnings_as_notes
from sjdsl.cli.stages import LOADING, stages
from sjdsl.trainers.policy_names import UNTRAINED, split_name

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.runtime.env import Environment

STORED = ".safetensors"


def evaluate_policy(
    policy: str, game: str, episodes: int, seed: int, greedy: bool | None, film: str | None, output: str | None, described: dict[str, Any]
) -> None:
    """Prints what a policy, and a random one, earn in the same episodes; writes the policy's figures to `output`, if given.

    Raises:
      UsageError: the policy is a run, which has its own game; or an option is not for such a policy. ClickException: there is none of that
      name, or a file cannot be written. ExperimentError, PolicyError: the policy does not fit the game.
    """
    described["params"] = read_assignments(described["params"])
    checked = check_environment(game, **described)
    _check(policy, checked, greedy, output)
    with stages(LOADING) as say:
        env = make_environment(describe_environment(game, **described))
        from sjdsl.trainers import evaluate, random_policy, save_evaluation, summarise
        from sjdsl.trainers.evaluation import evaluation_key
        from sjdsl.trainers.run_folder import describe_game

        found, digest = _found(policy, env, greedy)
        key = evaluation_key(seed)
        say(f"compiling and playing {episodes} episodes of {policy}")
        played = evaluate(env, found, key, episodes)
        if output is not None:
            about = {"policy": policy, "digest": digest, "game": describe_game(env), "seed": seed, "greedy": greedy}
            save_evaluation(played, output, about)
        columns = {policy: summarise(played)}
        if policy != "random":
            say(f"compiling and playing {episodes} episodes of a random policy")
            columns["random"] = summarise(evaluate(env, random_policy(env), key, episodes))
    echo_table(env, columns, episodes)
    earned = [interval(figures["collective return"]) for figures in columns.values()]
    click.echo(f"return {earned[0]}" + (f" against {earned[1]} of a random policy" if len(earned) > 1 else ""))
    if output is not None:
        click.echo(f"\n{output}")
    if film is not None:
        with stages("drawing an episode") as say:
            done = save_film(env, found, Path(film), env.episode_length, seed, say=say)
        click.echo(done)


def _check(policy: str, game: "ir.Game", greedy: bool | None, output: str | None) -> None:
    """Refuses, before JAX is loaded, what can be refused by then."""
    context = click.get_current_context(silent=True)
    path, _ = split_name(policy)
    named = policy in (*UNTRAINED, *(declared.name for declared in game.policies))
    if path.is_dir() and not named:
        raise click.UsageError(
            f"--game is for a policy that is no run, or for --scenario; {path} is a folder, and a run is evaluated in its own game. "
            "In another form of it, name the file of a policy, such as RUN/policies/last.safetensors",
            context,
        )
    check_policy(policy, game)
    if greedy is not None and (named or path.suffix != STORED):
        raise click.UsageError(f"{'--greedy' if greedy else '--drawn'} is for trained policies, and `{policy}` is none", context)
    if output is None:
        return
    if Path(output).suffix != ".json":
        raise click.UsageError(f"-o names the file for the figures, which must end in .json; `{output}` does not", context)
    require_folder_of(Path(output))


def _found(policy: str, env: "Environment", greedy: bool | None) -> tuple[Any, str | None]:
    """Returns a policy and the digest of what it is stored, or written, in; one of another game is refused, as in experiments."""
    from sjdsl.experiments import find_pool
    from sjdsl.trainers import find_policy

    with warnings_as_notes():
        (player,) = find_pool(policy, env).players
    if greedy is None:
        return player.policy_of(player.parameters), player.digest
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they were said
        return find_policy(policy, env, greedy), player.digest
