"""`sjdsl doc` and `sjdsl diff`: what they print, write and refuse."""

from pathlib import Path

from command_line import Sjdsl


def test_a_sheet_is_printed_or_written(sjdsl: Sjdsl, folder: Path) -> None:
    printed = sjdsl("doc orchard.sj")
    assert printed.status == 0
    assert printed.out.startswith("# A Small Orchard\n")
    assert "| `apple` | 1 | reward | 0 to 5 |" in printed.out
    Path("sheets").mkdir()
    written = sjdsl("doc orchard.sj -o sheets/orchard.md")
    assert written.status == 0
    assert (folder / "sheets" / "orchard.md").read_text() == printed.out
    assert [path.name for path in (folder / "sheets").iterdir()] == ["orchard.md"]


def test_a_variant_has_a_sheet_of_its_own(sjdsl: Sjdsl) -> None:
    shown = sjdsl("doc orchard.sj --variant rich").out
    assert "variant `rich`" in shown
    assert "| `apple` | 2 | reward | 0 to 5 |" in shown


def test_what_a_player_is_told(sjdsl: Sjdsl) -> None:
    printed = sjdsl("doc orchard.sj --told --agent 1 --step 2")
    assert printed.status == 0
    text, _, message = printed.out.partition("---- the message to agent 1 after 2 steps\n")
    assert text.startswith("YOUR AIM\n")
    assert "You are agent 1." in text
    assert "2 ago: " in message
    assert "3 ago: " not in message
    assert "WHAT YOU SEE NOW:" in message
    first = sjdsl("doc orchard.sj --told --step 2").out
    assert first == sjdsl("doc orchard.sj --told --agent 0 --step 2").out


def test_what_was_not_allowed_counts_as_stay(sjdsl: Sjdsl) -> None:
    game = Path("orchard.sj")
    rule = "moves relative  field hot : 0 .. 1 = 0  forbid turn_left when agent.hot == 0"
    game.write_text(game.read_text().replace("moves relative", rule))
    message = sjdsl("doc orchard.sj --told --step 5").out.partition("LAST STEPS")[2]
    assert "ago: stay, reward 0; turn_left was not allowed\n" in message
    assert "ago: turn_left" not in message


def test_what_cannot_be_told_is_refused(sjdsl: Sjdsl) -> None:
    assert "--agent and --step go with --told" in sjdsl("doc orchard.sj --agent 1").err
    assert "there is no 9" in sjdsl("doc orchard.sj --told --agent 9").err
    too_late = sjdsl("doc orchard.sj --told --step 5000")
    assert "the episode is over after 6 steps" in too_late.err
    at_the_end = sjdsl("doc orchard.sj --told --step 6")
    assert at_the_end.err == too_late.err
