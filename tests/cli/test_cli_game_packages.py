"""Games of installed packages: found by name everywhere, without importing them; clashes and broken packages are said, and stop no other."""

import sys
from pathlib import Path

import pytest
from command_line import Sjdsl
from installed_packages import game, install, register

import sjdsl as package
from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.library.games_folder import GamesClash, by_release, find_game, game_problems


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder where packages are installed. The bundled games are three small ones here, as a list of all the real ones takes seconds."""
    for file in ("coins.sj", "clean_up.sj", "meltingpot/daycare.sj"):
        path = tmp_path / "bundled" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(game(path.stem))
    monkeypatch.setattr("sjdsl.library.games_folder.games_folder", lambda: tmp_path / "bundled")
    (tmp_path / "site").mkdir()
    monkeypatch.syspath_prepend(tmp_path / "site")
    return tmp_path / "site"


def test_a_game_is_found_by_name(place: Path, sjdsl: Sjdsl) -> None:
    home = install(place, "river_games", {"river.sj": game("river")})
    assert find_game("river") == find_game("river_games:river") == home / "river.sj"
    assert sjdsl("check", "river").status == 0
    assert "A River" in sjdsl("doc", "river").out
    assert "generated/river.py" in sjdsl("compile", "river").out
    assert package.make("river").num_agents == 2
    assert "river_games" not in sys.modules


@pytest.mark.parametrize("name", ["river", "river_games:river"])
def test_a_run_knows_its_game_by_name(place: Path, folder: Path, name: str) -> None:
    """A path into the folder of a package would be another one after the next installation, or on another machine."""
    install(place, "river_games", {"river.sj": game("river")})
    assert EnvironmentOptions().describe(name)["game"] == name
    assert EnvironmentOptions().describe("orchard.sj")["game"] == str((folder / "orchard.sj").resolve())


def test_the_list_says_where_each_comes_from(place: Path, sjdsl: Sjdsl) -> None:
    install(place, "river_games", {"river.sj": game("river"), "lake.sj": game("lake")}, version="2.1")
    shown = sjdsl("list")
    assert shown.status == 0
    assert shown.err == ""
    *_, theirs, last = shown.out.split("\n\n")
    assert last.startswith("`sjdsl doc GAME`")
    assert [line.split()[0] for line in theirs.splitlines()] == ["of", "lake", "river"]
    assert theirs.splitlines()[0] == "of river-games 2.1"


def test_an_extended_game_and_its_map_are_read_beside_it(place: Path) -> None:
    more = 'sj 1\ngame lake extends "river.sj" { map "maps/lake.txt" }\n'
    install(place, "river_games", {"river.sj": game("river"), "lake.sj": more, "maps/lake.txt": "....\n....\n"})
    assert package.make("lake").observation_shape == package.make("river").observation_shape


def test_a_package_inside_another_is_not_imported_either(place: Path) -> None:
    home = install(place, "river_games.small", {"brook.sj": game("brook")})
    assert find_game("brook") == home / "brook.sj"
    assert not [name for name in sys.modules if name.startswith("river_games")]


def test_two_packages_with_one_name_are_named_both(place: Path, sjdsl: Sjdsl) -> None:
    river, lake = (install(place, name, {"pond.sj": game("pond"), f"{name}.sj": game(name)}) for name in ("river", "lake"))
    said = (
        f"2 games are called `pond`: one of lake 1.0 ({lake}/pond.sj) and one of river 1.0 ({river}/pond.sj); "
        "write `lake:pond` or `river:pond`, or uninstall one of them"
    )
    with pytest.raises(GamesClash) as caught:
        find_game("pond")
    assert str(caught.value) == said
    with pytest.raises(ValueError, match="2 games are called `pond`"):
        package.make("pond")
    refused = sjdsl("check", "pond")
    assert refused.status == 1
    assert refused.err == f"error: {said}\n"
    assert find_game("lake:pond") == lake / "pond.sj"
    assert find_game("river:pond") == river / "pond.sj"
    assert find_game("river") == river / "river.sj", "other games of these packages can be used"
    shown = sjdsl("list")
    assert shown.status == 1
    assert said in shown.err
    assert "\nlake:pond " in shown.out
    assert "\nriver:pond " in shown.out
    assert shown.out.count("clean_up ") == 1


def test_a_bundled_name_is_no_exception(place: Path, sjdsl: Sjdsl) -> None:
    install(place, "river", {"coins.sj": game("coins")})
    with pytest.raises(GamesClash, match=r"one of sjdsl 0\.1\.0 \(.*coins\.sj\) and one of river 1\.0 .*`sjdsl:coins` or `river:coins`"):
        find_game("coins")
    assert sjdsl("check", "sjdsl:coins").status == 0
    assert package.make("river:coins").name == package.make("sjdsl:coins").name == "coins"
    assert "clean_up" in by_release()["sjdsl 0.1.0"]
    assert by_release()["river 1.0"] == ["river:coins"]


def test_one_folder_with_two_entry_points_is_no_clash(place: Path) -> None:
    install(place, "river", {"pond.sj": game("pond")})
    register(place, "river-again", "again", "river")
    assert find_game("pond") == place / "river/pond.sj"
    assert game_problems() == []


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("gone", "there is no package of that name: install broken 1.0 again, or remove it"),
        ("gone.inner", "there is no package of that name"),
        ("lonely", "that is a single module: a package is wanted, a folder with `.sj` files in it"),
        ("empty", "there are no `.sj` files in "),
        ("river:games", "a package's name is wanted there, without `:`"),
    ],
)
def test_a_broken_package_is_said_and_stops_no_other(place: Path, sjdsl: Sjdsl, value: str, said: str) -> None:
    install(place, "river", {"pond.sj": game("pond")})
    (place / "lonely.py").write_text("")
    (place / "empty").mkdir()
    (place / "empty/__init__.py").write_text("")
    register(place, "broken", "broken", value)
    assert find_game("pond") == place / "river/pond.sj"
    shown = sjdsl("list")
    assert shown.status == 1
    assert shown.err.startswith(f"error: broken 1.0 offers games by the entry point `broken = {value}`, and ")
    assert said.replace("install broken 1.0 again", "install broken again") in shown.err
    assert "\npond " in shown.out
    unknown = sjdsl("check", "salmon")
    assert "there is no bundled or installed game `salmon`" in unknown.err
    assert "note: broken 1.0 offers games" in unknown.err, "what is missing may be what is broken"


def test_a_file_that_does_not_compile_is_said(place: Path, sjdsl: Sjdsl) -> None:
    install(place, "river", {"pond.sj": game("pond"), "bad.sj": "sj 1\ngame bad { episode 3 }\n"})
    shown = sjdsl("list")
    assert shown.status == 1
    assert "\npond " in shown.out
    assert "error: the game `bad` has " in shown.err
    assert "`sjdsl check bad` shows what to change" in shown.err
    assert sjdsl("check", "bad").status == 1


def test_the_misspelt_name_of_an_installed_game(place: Path, sjdsl: Sjdsl) -> None:
    install(place, "river", {"waterfall.sj": game("waterfall")})
    assert "did you mean `waterfall`?" in sjdsl("check", "waterfal").err
    assert "did you mean `river:waterfall`?" in sjdsl("check", "river:waterfal").err
