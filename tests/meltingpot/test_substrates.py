"""The table of substrates: which of Melting Pot's are there, that each builds without a warning, and the page made of it."""

import shutil
from pathlib import Path

import pytest

from bench.game_pages import build_of, page_problems
from sjdsl.compiler import ast
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import bundled, find_game, main_games, melting_pot_games
from sjdsl.library.substrates import Substrate, substrates, written_substrates
from tests.games.test_game_texts import SOURCE, all_sections, lines_of, lines_within

MOST_LINES = 160  # of a file; its maps are files of their own
PAGE = Path(__file__).parents[2] / "docs" / "meltingpot.md"
# Source: `SUBSTRATES` in meltingpot/configs/substrates/__init__.py; two parts of a name stand for all their endings.
NAMES = {
    "allelopathic_harvest": ["open"],
    "bach_or_stravinsky_in_the_matrix": ["arena", "repeated"],
    "boat_race": ["eight_races"],
    "chemistry": [
        *("three_metabolic_cycles", "three_metabolic_cycles_with_plentiful_distractors"),
        *("two_metabolic_cycles", "two_metabolic_cycles_with_distractors"),
    ],
    "chicken_in_the_matrix": ["arena", "repeated"],
    "clean_up": [],
    "coins": [],
    "collaborative_cooking": [
        "asymmetric",
        "circuit",
        "cramped",
        "crowded",
        "figure_eight",
        "forced",
        "ring",
    ],
    "commons_harvest": ["closed", "open", "partnership"],
    "coop_mining": [],
    "daycare": [],
    "externality_mushrooms": ["dense"],
    "factory_commons": ["either_or"],
    "fruit_market": ["concentric_rivers"],
    "gift_refinements": [],
    "hidden_agenda": [],
    "paintball": ["capture_the_flag", "king_of_the_hill"],
    "predator_prey": ["alley_hunt", "open", "orchard", "random_forest"],
    "prisoners_dilemma_in_the_matrix": ["arena", "repeated"],
    "pure_coordination_in_the_matrix": ["arena", "repeated"],
    "rationalizable_coordination_in_the_matrix": ["arena", "repeated"],
    "running_with_scissors_in_the_matrix": ["arena", "one_shot", "repeated"],
    "stag_hunt_in_the_matrix": ["arena", "repeated"],
    "territory": ["inside_out", "open", "rooms"],
}
ALL = [
    f"{family}__{ending}" if ending else family
    for family, endings in NAMES.items()
    for ending in endings or [""]
]


def test_the_table_has_every_name() -> None:
    assert list(substrates()) == ALL
    assert len(ALL) == 49


def test_every_substrate_is_written() -> None:
    assert [entry.name for entry in substrates().values() if not entry.game] == []


@pytest.mark.parametrize("entry", written_substrates(), ids=lambda entry: entry.name)
def test_a_substrate_builds_without_a_warning(entry: Substrate) -> None:
    made = build_of(entry)
    assert [str(warning) for warning in made.warnings] == []
    assert made.game.title
    assert not entry.roles or len(entry.roles) == made.game.agents.number


def test_every_file_is_a_substrate() -> None:
    """No game of the folder is left out of the table, and no two folders have a game of one name."""
    assert set(melting_pot_games()) <= {entry.game for entry in written_substrates()}
    assert len(set(bundled())) == len(main_games()) + len(melting_pot_games())
    for name in melting_pot_games():
        assert parse(read_source(find_game(name))).game.name.text == name


def test_families_are_found_by_name_and_meant_by_near_names() -> None:
    assert find_game("territory_open").parent.name == "meltingpot"
    assert find_game("territory").parent.name == "games"
    with pytest.raises(FileNotFoundError, match="did you mean `territory_open`"):
        find_game("teritory_open")
    with pytest.raises(FileNotFoundError, match="no bundled game `meltingpot/territory_open`"):
        find_game("meltingpot/territory_open")


def test_each_difference_is_a_sentence() -> None:
    """The page has a row for each game that differs; a colon follows the names of some of its substrates."""
    games = {entry.game for entry in written_substrates()}
    section = PAGE.read_text(encoding="utf-8").partition("## What differs")[2].partition("\n## ")[0]
    rows = [
        line.strip("| ").split(" | ") for line in section.splitlines() if line.startswith("| `")
    ]
    assert {row[0].strip("`") for row in rows} <= games
    for game, *texts in rows:
        for text in texts:
            assert text.endswith("."), f"{game}: {text[-80:]}"


def test_the_page_is_up_to_date() -> None:
    assert page_problems(PAGE) == [], "run `make docs`"


def test_a_page_of_something_else_is_found(tmp_path: Path) -> None:
    pictures = tmp_path / "pictures" / "meltingpot"
    pictures.mkdir(parents=True)
    for picture in (PAGE.parent / "pictures" / "meltingpot").glob("*.png"):
        shutil.copy(picture, pictures)
    stray = pictures / "stray.png"
    stray.write_bytes(b"")
    (tmp_path / "meltingpot.md").write_text(
        PAGE.read_text(encoding="utf-8").replace("| `boat_race__eight_races` |", "| `another` |"),
        encoding="utf-8",
    )
    assert page_problems(tmp_path / "meltingpot.md") == [
        f"{stray}: of no game",
        f"{tmp_path / 'meltingpot.md'}: not what the games say",
    ]


@pytest.mark.parametrize("game", melting_pot_games())
def test_a_family_is_short(game: str) -> None:
    assert len(find_game(game).read_text(encoding="utf-8").splitlines()) <= MOST_LINES


@pytest.mark.parametrize("game", melting_pot_games())
def test_each_size_and_param_says_where_it_is_from(game: str) -> None:
    """On one of its lines, or on the line of a comment above it."""
    source = read_source(find_game(game))
    lines = {line.number: line for line in lines_of(source.text)}
    for section in all_sections(parse(source).game.sections):
        if isinstance(section, ast.Constant):
            rows = lines_within(source, section.span)
            above = lines.get(min(rows) - 1)
            said = [lines[row].comment for row in rows] + (
                [above.comment] if above and not above.code.strip() else []
            )
            assert any(map(SOURCE.search, said)), section.name.text
