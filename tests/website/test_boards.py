"""The boards of the gallery: an episode of each game."""

from website.boards import Board, played, rules_of


def test_a_board_shows_the_first_steps_of_an_episode() -> None:
    """Of a game with policies, which its agents follow in turn, and of one without."""
    for name in ("coins", "territory"):
        start, *steps = played(rules_of(Board(name, name)), steps=3)
        assert not start.actions
        assert [moment.snapshot.step for moment in steps] == [1, 2, 3]
        assert all(len(moment.actions) == len(moment.reward) for moment in steps)
