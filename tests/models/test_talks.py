"""The account of calls: those that fail, those under way at the end, and those of earlier commands."""

import json
import time
from multiprocessing.pool import ThreadPool
from pathlib import Path
from typing import Any

import pytest

from sjdsl.models import LimitReached, Limits, Message, Model, ModelError, Talks
from sjdsl.models.account import most_tokens
from sjdsl.models.asking import Question
from sjdsl.models.files import Price

from .folders import recorded_calls
from .server import Server, serving

ASKED = Message("the rules", "what is seen", ("stay", "forward"), ("stay", "forward"))
STAY = '{"why": "", "goal": "", "note": {"op": "none"}, "action": "stay"}'


def model(server: Server) -> Model:
    return Model("luna", url=server.url, model="luna", price=Price(1, 10), retries=0, timeout=0.3)


def question(policy: Model, episode: int) -> Question:
    return Question(episode, 0, 0, 0, "move", policy, ASKED)


def ask(policy: Model, episodes: list[int], folder: Path, limits: Limits | None = None) -> None:
    """Asks once in each episode, as a command does."""
    with Talks(folder, limits) as talks:
        for episode in episodes:
            talks.part("a")(question(policy, episode))


@pytest.mark.parametrize(
    ("fault", "is_billed"), [(400, False), (503, False), ("slow", True), ("cut", True)]
)
def test_a_call_that_may_be_billed_counts_at_its_most(
    fault: int | str, is_billed: bool, tmp_path: Path
) -> None:
    """For this command and for later ones; a call that the server refuses is free."""
    with serving(Server(lambda _: STAY, ["ok", fault])) as server:
        luna = model(server)
        with pytest.raises(ModelError, match="luna at http"):
            ask(luna, [0, 1], tmp_path)
        file = tmp_path / "talks/unanswered.json"
        assert file.exists() == is_billed
        if is_billed:
            most = luna.dollars(most_tokens(ASKED), 0, luna.max_tokens)
            assert json.loads(file.read_text()) == {"calls": 1, "dollars": most}
        limits = Limits(calls=2 + is_billed)
        with pytest.raises(LimitReached, match=f"{2 + is_billed} calls were made"):
            ask(luna, [0, 1, 2], tmp_path, limits)
        assert len(server.requests) == 3
        limits = Limits(budget=2 * luna.dollars(100, 60, 10) + 1.5 * luna.dollars(0, 0, 4000))
        if is_billed:
            with pytest.raises(LimitReached, match="for 1 calls that were never answered"):
                ask(luna, [2], tmp_path, limits)
        else:
            ask(luna, [2], tmp_path, limits)


def test_a_server_that_was_not_reached_bills_nothing(tmp_path: Path) -> None:
    nowhere = Server(lambda _: "", url="http://127.0.0.1:9/v1")
    with pytest.raises(ModelError, match="Connection error"):
        ask(model(nowhere), [0], tmp_path)
    assert not (tmp_path / "talks/unanswered.json").exists()


def test_at_a_limit_replies_under_way_are_kept(tmp_path: Path) -> None:
    def slowly(_: dict[str, Any]) -> str:
        time.sleep(0.2)
        return STAY

    with serving(Server(slowly)) as server:
        luna = model(server)
        limits = Limits(parallel=4, calls=6)
        questions = [question(luna, episode) for episode in range(9)]
        with pytest.raises(LimitReached), Talks(tmp_path, limits) as talks, ThreadPool(4) as pool:
            list(pool.imap_unordered(talks.part("a"), questions))  # raises as soon as one does
        assert len(server.requests) == 6 == recorded_calls(tmp_path)
    assert not (tmp_path / "talks/unanswered.json").exists()


def test_a_damaged_account_is_refused(tmp_path: Path) -> None:
    (tmp_path / "talks").mkdir()
    (tmp_path / "talks/unanswered.json").write_text("[]")
    with pytest.raises(ModelError, match=r"unanswered.json is damaged; remove it"):
        Talks(tmp_path).__enter__()
