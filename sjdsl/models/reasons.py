"""Why agents that are asked in words did what they did in an episode."""

from sjdsl.models.asking import Ask, Question, ask_policy
from sjdsl.models.policy import Reply


class Reasons:
    """Asks the agents of one episode after the other, and keeps their reasons in the last one."""

    def __init__(self, ask: Ask = ask_policy) -> None:
        self._ask = ask
        self._whys: dict[tuple[int, int], str] = {}  # by step and agent

    def ask(self, question: Question) -> Reply:
        """Returns the reply to a question."""
        reply = self._ask(question)
        if question.kind == "move":
            self._whys[question.step, question.agent] = reply.why
        return reply

    def clear(self) -> None:
        """Begins another episode."""
        self._whys.clear()

    def table(self, steps: int, agents: int) -> list[list[str]] | None:
        """Returns the reason of each agent in each step, `[T][N]`, empty if it gave none; None if
        nobody was asked.
        """
        if not self._whys:
            return None
        return [
            [self._whys.get((step, agent), "") for agent in range(agents)] for step in range(steps)
        ]
