"""The checks of all bundled games: each passes, and each fails after a deliberate fault (`mutations.py`).

On few examples, and `expect` over few short episodes on a small map; the whole test is `sjdsl test` on each game. The faults are looked for
with other trajectories by `pytest tests/properties/test_games.py -k fault --play-seed N`.
"""

import re
import shutil
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, games_folder, main_games
from sjdsl.properties import Effort, GameFamily, verify_properties

from .mutations import MUTATIONS, Mutation

FEW = Effort(examples=4, compiled=False)
STEPS, EPISODES = 40, 3
SMALL = {  # a map on which the policies of the expectations have something to do, and how many agents play on it
    "coins": (("PCCCP", "CCCCC"), 2),
    "harvest_open": (("QQPP", "AAAA"), 2),
    "clean_up": (("PPBB", "FHFH", "SBBB"), 2),
    "coop_mining": (("POOP", "OOOO"), 2),
    "gift_refinement": (("PTTP", "TTTT"), 2),
    "mushrooms": (("..RG", "BO..", "...."), 2),
    "pd_arena": (("PPPP", ".CD.", ".CD."), 2),
    "stag_hunt": (("PPPP", ".CD.", ".CD."), 2),
    "chicken": (("PPPP", ".CD.", ".CD."), 2),
    "allelopathic_harvest": (("...g", "rb.b", "g..."), 2),
    "predator_prey": (("XXPP", "aagn", "XPPX"), 4),
    "territory": (("PRPR", "RPRP"), 2),
    "stag_chase": (("....", "....", "...."), 2),
    "open_harvest": (("1111", "PPPP", "...."), 2),
    "open_clean_up": (("PPPP", "1234", "FFFS", "BBBB"), 3),
}
OFTEN = {  # what is rare in the file and must happen in a short episode
    "ferry": (("basket   : count = 4", "basket   : count = 1"),),
    "coins": (("probability = 0.0005", "probability = 0.1"),),
    "territory": (
        ("probability = 0.01 ", "probability = 0.5 "),
        ("param drying : steps       = 25", "param drying : steps = 2"),
    ),
}


@cache
def folder_of(game: str, changes: tuple[tuple[str, str], ...], base: Path) -> Path:
    """Returns a folder with the games, one of them changed, in the rules that stand before its variants."""
    folder = base / f"{game}_{abs(hash(changes))}"
    shutil.copytree(games_folder(), folder, ignore=shutil.ignore_patterns("__pycache__"))
    path = folder / f"{game}.sj"
    text = path.read_text(encoding="utf-8")
    rules = text.partition("\n  variant ")[0]
    variants = text[len(rules) :]
    for before, after in changes:
        assert rules.count(before) == 1, (
            f"{game}.sj has {rules.count(before)} of `{before}` before its variants"
        )
        rules = rules.replace(before, after)
    path.write_text(rules + variants, encoding="utf-8")
    return folder


def shortened(folder: Path, game: str) -> GameFamily:
    """Returns a game for its expectations: few short episodes, on a small map if one is given."""
    for path in folder.glob("*.sj"):
        text = re.sub(
            r"(param length +: steps +=) \d+", rf"\1 {STEPS}", path.read_text(encoding="utf-8")
        )
        text = re.sub(r"episode \d+\b", f"episode {STEPS}", text)
        for before, after in OFTEN.get(path.stem, ()):
            text = text.replace(before, after)
        path.write_text(
            re.sub(r"over \d+ episodes", f"over {EPISODES} episodes", text), encoding="utf-8"
        )
    rows, agents = SMALL.get(game, (None, None))
    return GameFamily(
        read_source(folder / f"{game}.sj"),
        overrides=Overrides(num_agents=agents, rows=rows, row_spans=()),
    )


def number_of(family: GameFamily, check_text: str) -> int:
    """Returns the index of the check that begins so."""
    checks = family.own.checks
    found = [
        i
        for i, check in enumerate(checks)
        if family.text_of(check).startswith(check_text)
        or check.kind == check_text.split()[0] == "symmetric"
    ]
    assert len(found) == 1, f"{check_text}: {len(found)} checks begin so"
    return found[0]


SLOW = {  # whose checks take seconds, and one with the rules of stag_hunt
    "chicken",
    "clean_up",
    "coop_mining",
    "gift_refinement",
    "harvest_closed",
    "harvest_partnership",
    "mushrooms",
    "open_clean_up",
}
SLOW_EXPECTATIONS = {"open_clean_up", "stag_chase"}


def without(slow: set[str], games: Iterable[str]) -> list[Any]:
    """Returns the games, of which the slow ones come with the thorough tests."""
    marks = {game: [pytest.mark.thorough] if game in slow else [] for game in games}
    return [pytest.param(game, marks=marks[game]) for game in games]


@pytest.mark.parametrize("game", without(SLOW, main_games()))
def test_checks_pass(game: str) -> None:
    family = GameFamily(read_source(find_game(game)))
    played = [i for i, check in enumerate(family.own.checks) if check.kind != "expect"]
    report = verify_properties(family, FEW, played)
    assert [v.text for v in report.verdicts if not v.passed] == []


@pytest.mark.parametrize("game", without(SLOW_EXPECTATIONS, SMALL))
def test_expectations_pass_on_the_small_map(game: str, tmp_path: Path) -> None:
    """What the faults are compared with: without a fault these short episodes meet every expectation."""
    family = shortened(folder_of(game, (), tmp_path), game)
    expects = [i for i, check in enumerate(family.own.checks) if check.kind == "expect"]
    assert [v.text for v in verify_properties(family, FEW, expects).verdicts if not v.passed] == []


LONG = {  # faults that are looked for for two seconds or more, or in the compiled game; of sorts of checks that fail in other games, too
    ("pd_arena", "always count(agent where agent.resting"),
    ("coop_mining", "always count(rock where rock.ore is not partial and"),
    ("predator_prey", "always caught == eaten"),
    ("territory", "always count(brick where brick.owner is nobody"),
    ("clean_up", "monotone growth falling in dirt"),
    ("harvest_open", "once apples == 0"),
    ("gift_refinement", "always count(agent where sum(agent.post)"),
    ("clean_up", "always dirt >= 0"),
    ("open_clean_up", "monotone growth falling in dirt"),
}


def in_each_run(mutation: Mutation) -> bool:
    """Returns whether a fault is quickly found, and is the first listed of its game and of the sort of its check."""
    return (mutation.game, mutation.check) not in LONG and mutation == next(
        m
        for m in MUTATIONS
        if (m.game, m.check.split()[0]) == (mutation.game, mutation.check.split()[0])
    )


@pytest.mark.parametrize(
    "mutation",
    [pytest.param(m, marks=[] if in_each_run(m) else pytest.mark.thorough) for m in MUTATIONS],
    ids=lambda m: f"{m.game}: {m.check}",
)
def test_a_fault_fails_its_check(
    mutation: Mutation, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    folder = folder_of(mutation.game, mutation.changes, tmp_path)
    source = read_source(folder / f"{mutation.game}.sj")
    if mutation.refused:
        with pytest.raises(CompileError) as refused:
            GameFamily(source)
        assert "SJ212" in {d.code for d in refused.value.diagnostics}
        return
    short = mutation.check.startswith("expect") or in_each_run(mutation)
    family = shortened(folder, mutation.game) if short else GameFamily(source)
    effort = Effort(
        seed=request.config.getoption("--play-seed"), compiled=not in_each_run(mutation)
    )
    (verdict,) = verify_properties(family, effort, [number_of(family, mutation.check)]).verdicts
    assert verdict.passed is False
    assert verdict.trace or verdict.how == "decided"


def test_every_check_of_every_game_has_a_fault() -> None:
    listed = {(m.game, m.check) for m in MUTATIONS}
    for game in main_games():
        family = GameFamily(read_source(find_game(game)))
        for check in family.own.checks:
            assert check.origin is not None
            home, text = Path(check.origin.file).stem, family.text_of(check)
            assert any(home == g and text.startswith(p) for g, p in listed), (
                f"{home}.sj: no fault in mutations.py for `{text}`"
            )
