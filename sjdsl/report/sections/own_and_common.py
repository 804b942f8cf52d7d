"""What common reward changes: individual against common reward in each game, by Welch's t-test."""

from collections.abc import Sequence

from sjdsl.report.cells import settings_between
from sjdsl.report.comparing import Pair, compared_table
from sjdsl.report.contents import Contents, Game, in_folder, sweeps_of
from sjdsl.report.evidence import RandomRow
from sjdsl.report.figure_text import bounded
from sjdsl.report.page import Section
from sjdsl.report.published import difficulty
from sjdsl.report.ways import common, individual

AXIS = "--axis reward=individual,common"
REWARDS = "runs/rewards"  # where the sweep that is named for empty cells puts its runs


def own_and_common(contents: Contents) -> Section:
    """Returns the section of IPPO with individual and with common reward."""
    lines: list[Pair] = []
    for game in contents.games:
        own, shared = (None if game.setting is None else contents.index.returns(game.setting, way) for way in (individual, common))
        lines.append(((game.label, difficulty(game.published), _random_text(_random(contents, game))), own, shared))
    table = compared_table(
        "own_and_common",
        "Collective return of IPPO",
        ("game", "the paper calls it", "random policy, over episodes"),
        ("individual", "common"),
        lines,
    )
    text = [
        "Where common reward earns the group more, agents that learnt from their own reward ended worse for the group, after so many steps. "
        "Whether the game is a dilemma is asked below, by Schelling diagrams. p is of each game alone, and not corrected for their number.",
        *_below_random(contents, lines),
    ]
    for column, cells in (("individual", [own for _, own, _ in lines]), ("common", [shared for _, _, shared in lines])):
        text += settings_between(column, {said[0]: cell for (said, _, _), cell in zip(lines, cells, strict=True)})
    missing = [game.asked for game, line in zip(contents.games, lines, strict=True) if None in line[1:]]
    fill = sweeps_of(missing if lines else [("coins", "")], AXIS, REWARDS)
    return Section("Individual and common reward", tuple(text), (table,) if lines else (), fill=fill)


def pools(name: str, form: str) -> tuple[str, str]:
    """Returns the folders in which that sweep leaves what has learnt in a game from common reward, and from individual reward."""
    cells = f"{in_folder(REWARDS, form)}/cells/{name}_reward"
    return f"{cells}-common", f"{cells}-individual"


def _random(contents: Contents, game: Game) -> RandomRow | None:
    """Returns what a random policy earns under the same rules."""
    if game.setting is None or game.setting.params:
        return None
    return contents.index.random(game.setting.game, game.setting.hash)


def _random_text(found: RandomRow | None) -> str:
    return "" if found is None else bounded(found.mean, found.low, found.high)


def _below_random(contents: Contents, lines: Sequence[Pair]) -> list[str]:
    """Returns which cells have a smaller mean than a random policy, as a paragraph."""
    below = []
    for game, (_, *cells) in zip(contents.games, lines, strict=True):
        random = _random(contents, game)
        means = {name: None if cell is None else cell.estimate for name, cell in zip(("individual", "common"), cells, strict=True)}
        names = [name for name, found in means.items() if random is not None and found is not None and found.mean < random.mean]
        below += [f"{game.label} ({', '.join(names)})"] if names else []
    if not below:
        return []
    return [
        f"Below the return of a random policy are: {'; '.join(below)}. "
        "Where things grow again, agents that have only learnt to harvest fast can leave less than those that know nothing."
    ]
