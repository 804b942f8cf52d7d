"""SECURITY.md is true sentence by sentence: each has the tests that would fail if it were not."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.test_prose import paragraphs

ROOT = Path(__file__).parents[2]
TEXT, FILES, REPLAYS, READING, LINKS = (
    f"security/test_{name}.py"
    for name in ("generated_text", "files", "replays", "reading", "links")
)
POLICIES, ACCESS, CHILD = (
    "trainers/test_policy_safety.py",
    "studio/test_access.py",
    "studio/test_child.py",
)
LIMITS, PAGE, SERVER = (
    "compiler/test_limits.py",
    "render/test_episode_page.py",
    "editor/test_server.py",
)
# How a sentence begins -> its tests, or why it needs none: it warns, and promises nothing.
WARNS = "warns"
HELD_BY: dict[str, tuple[str, ...] | str] = {
    "**A game is data": (f"{READING}::test_commands_that_read_run_nothing",),
    "A CODE file contains no Python": (f"{READING}::test_commands_that_read_run_nothing",),
    "CODE and the language server parse": (
        f"{READING}::test_commands_that_read_run_nothing",
        f"{READING}::test_the_language_server_runs_nothing",
    ),
    "A game names other files": (
        "compiler/test_error_cases.py::test_case",
    ),  # errors/SJ112_file_outside.sj
    "Links there may lead": (
        f"{LINKS}::test_a_link_inside_the_folder",
        f"{LINKS}::test_links_to_another_package",
        f"{LINKS}::test_a_link_out_of_the_folder_is_refused",
    ),
    "Only regular files": (f"{LINKS}::test_what_is_no_file_is_not_waited_for",),
    "Sizes are limited": (f"{LIMITS}::test_one_message",),
    "**Compiled games** are": (f"{TEXT}::test_the_texts_of_a_game_become_no_code",),
    "Only names, numbers": (
        f"{TEXT}::test_the_texts_of_a_game_become_no_code",
        f"{TEXT}::test_the_name_of_a_file_becomes_no_code",
    ),
    "The cache of compiled games": (f"{TEXT}::test_what_is_cached_does_not_depend_on_the_file",),
    "A game may still take": WARNS,
    "**The studio** listens": (f"{READING}::test_the_studio_listens_on_this_machine_alone",),
    "It answers only its own page": (
        f"{ACCESS}::test_the_page_wants_the_token",
        f"{ACCESS}::test_other_hosts_and_origins_are_refused_whatever_they_know",
    ),
    "It reads and writes games": (
        f"{ACCESS}::test_only_games_and_maps_inside_the_folder_are_read",
        f"{ACCESS}::test_nothing_else_is_written",
        f"{FILES}::test_saving_in_the_studio_writes_nothing_elsewhere",
    ),
    "Outside it, it reads only": (
        f"{ACCESS}::test_only_games_and_maps_inside_the_folder_are_read",
        f"{ACCESS}::test_the_language_server_reads_no_other_folder",
        f"{ACCESS}::test_the_command_opens_bundled_games_as_examples_and_others_in_its_folder",
        f"{ACCESS}::test_nothing_else_is_written",
        f"{FILES}::test_saving_in_the_studio_writes_nothing_elsewhere",
    ),
    "Compiling and playing have limits": (f"{CHILD}::test_what_takes_too_long_is_stopped",),
    "**Files are written**": (
        f"{FILES}::test_what_fails_leaves_what_was_there_and_nothing_else",
        f"{FILES}::test_a_link_is_replaced_and_not_followed",
        f"{FILES}::test_permissions_are_kept",
        f"{FILES}::test_files_are_written_in_one_place",
    ),
    "A new one has the permissions": (f"{FILES}::test_a_new_file_has_those_of_the_umask",),
    "Logs and locks are": (f"{FILES}::test_what_is_changed_in_place_is_no_link",),
    "Links to folders": WARNS,
    "The command": (f"{FILES}::test_formatting_through_a_link_formats_the_file",),
    "**Stored policies** are": (
        f"{POLICIES}::test_no_byte_of_the_tensors_can_change",
        "trainers/test_checkpoints.py::test_no_byte_can_change",
    ),
    "Loading one imports nothing": (
        f"{POLICIES}::test_code_that_only_the_files_of_a_policy_name_does_not_run",
        f"{POLICIES}::test_a_reward_of_ones_own_is_no_part_of_acting",
        f"{POLICIES}::test_whatever_a_stranger_writes_is_a_message",
    ),
    "Its JSON and its numbers": (
        f"{POLICIES}::test_no_byte_of_the_description_can_change",
        f"{POLICIES}::test_a_policy_without_digests_is_refused",
    ),
    "Digests detect damage": WARNS,
    "**Episodes and data sets**": (f"{REPLAYS}::test_an_array_that_lies_is_refused",),
    "Their sizes are checked": (
        f"{REPLAYS}::test_a_small_file_cannot_take_much_memory",
        f"{REPLAYS}::test_bytes_of_a_data_set_change",
        f"{REPLAYS}::test_a_damaged_episode_is_a_message",
        f"{FILES}::test_reading_stops_at_the_limit",
    ),
    "An episode, or the folder": (
        f"{REPLAYS}::test_no_line_of_another_file_is_printed",
        f"{REPLAYS}::test_a_folder_of_a_run_shows_no_other_file_either",
    ),
    "**Pages** of episodes": (
        f"{PAGE}::test_texts_of_a_game_stay_texts",
        f"{READING}::test_a_report_shows_names_as_texts",
    ),
    "None of them becomes": (f"{READING}::test_a_page_has_no_more_elements_for_any_title",),
    "**What does run code": (f"{POLICIES}::test_what_the_caller_names_runs",),
    "Functions that only the files of a policy": (
        f"{POLICIES}::test_resuming_runs_no_code_that_only_the_folder_names",
        f"{POLICIES}::test_a_callback_that_only_the_folder_names_does_not_run",
    ),
}


def sentences(prose: str) -> Iterator[str]:
    """Yields the sentences of a paragraph; code and a list of code count as one word, a link as its text."""
    prose = re.sub(r"(`+)(?:.+?)\1", "CODE", prose)
    prose = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", prose)
    prose = re.sub(r"CODE(, CODE)+", "CODE", prose)
    yield from re.split(r"(?<=[.!?])[)\"*]*\s+(?=\(|[\"'*\[]*[A-Z0-9]|\w )", prose)


def promised() -> list[str]:
    text = (ROOT / "SECURITY.md").read_text("utf-8")
    part = text.split("## What you can rely on")[1].split("## What counts")[0]
    return [sentence for paragraph in paragraphs(part) for sentence in sentences(paragraph)]


def test_every_sentence_is_held_by_a_test() -> None:
    found = promised()
    for sentence in found:
        assert [start for start in HELD_BY if sentence.startswith(start)] != [], sentence
    assert [
        start for start in HELD_BY if not any(sentence.startswith(start) for sentence in found)
    ] == []


@pytest.mark.parametrize(
    "name", sorted({name for names in HELD_BY.values() if names != WARNS for name in names})
)
def test_the_tests_are_there(name: str) -> None:
    file, _, function = name.partition("::")
    assert re.search(
        rf"^(async )?def {function}\b", (ROOT / "tests" / file).read_text("utf-8"), re.MULTILINE
    )
