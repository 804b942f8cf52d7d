"""A player that reads nothing but the text of its messages: a patient harvester.

    sjdsl crossplay open_harvest --policies examples/text_player.py:patient greedy --mix pairs --episodes 1

It eats an apple only where three others are near, so that apples grow again, and of each hue only
at the stages that have paid best so far, as its messages say.
"""

import re

from sjdsl.models import HostPolicy, Message, Reply

NEAR = 2  # the Euclidean distance within which apples help an apple to grow again
KEEP = 3  # apples that must be near one that is eaten
HEADINGS = ("north", "east", "south", "west")
AROUND = ((1, 0), (0, 1), (-1, 0), (0, -1))  # by quarter turns: ahead, right, behind, left
STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}  # north, east, south, west
APPLE = re.compile(r"tree hue=(\w+) fruit=(unripe|ripe|overripe)")
PAID = re.compile(rf"{APPLE.pattern}: (\S+) \(\d+x\)")
END = re.compile(rf"^({'|'.join(STEPS)}) -> (.*)$", re.MULTILINE)

Place = tuple[int, int]  # steps ahead, steps to the right
Apple = tuple[str, str]  # its hue and its stage


def apples_in(text: str) -> dict[Place, Apple]:
    """Returns the apples in the window of a message."""
    window, _, rest = text.partition("WHAT YOU SEE NOW:\n")[2].partition("\nLegend: ")
    meanings = dict(entry.split(" ", 1) for entry in rest.partition(".\n")[0].split("; "))
    header, *rows = window.splitlines()
    columns = [signed(name, "L", "R") for name in header.split()]
    apples = {}
    for row in rows:
        name, codes = re.fullmatch(r"(beside you|\d+ ahead|\d+ behind) +(.*)", row).groups()
        ahead = 0 if name == "beside you" else signed(name, " behind", " ahead")
        for right, code in zip(columns, codes.split(), strict=True):
            match = APPLE.fullmatch(meanings.get(code, ""))
            if match:
                apples[ahead, right] = match.groups()
    return apples


def signed(name: str, less: str, more: str) -> int:
    """Returns -3 for `3L`, 3 for `3R`."""
    number = int(name.removesuffix(less).removesuffix(more))
    return -number if name.endswith(less) else number


def paid_best(text: str) -> set[Apple]:
    """Returns of each hue the stage that paid best, once it is known to pay the most, and all
    stages of hues of which less is known."""
    pays = {(hue, stage): float(pay) for hue, stage, pay in PAID.findall(text)}
    return {apple for apple, pay in pays.items() if pay >= 1}


def near(place: Place, apples: dict[Place, Apple]) -> int:
    """Returns how many other apples are near a place."""
    return sum(0 < distance(place, other) <= NEAR**2 for other in apples)


def distance(one: Place, other: Place) -> int:
    """Returns the square of the distance."""
    return (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2


class Patient(HostPolicy):
    """Waits where few apples are left."""

    def decide(self, agent: int, message: Message) -> Reply:
        """Steps toward the nearest apple that it would eat, and onto no other."""
        del agent
        text = message.text
        ends = dict(END.findall(text))
        heading = re.search(r"agent\.heading = (\w+)", text)
        if heading is None or not ends:
            return Reply("stay", why="nothing is said of where steps lead")
        apples = apples_in(text)
        best = paid_best(text)
        known = {hue for hue, _ in best}
        wanted = [
            place
            for place, apple in apples.items()
            if near(place, apples) >= KEEP and (apple in best or apple[0] not in known)
        ]
        turned = HEADINGS.index(heading[1])
        steps = {}
        for name, end in ends.items():
            place = AROUND[(STEPS[name] - turned) % 4]
            is_open = not end.startswith("blocked") and "is there" not in end
            if is_open and (place in wanted or place not in apples):
                steps[name] = place
        if not steps:
            return Reply("stay", why="each step leads onto an apple that should hang on")
        if not wanted:
            last = re.search(r"^1 ago: (\w+)", text, re.MULTILINE)
            looks = last is not None and last[1] == "turn_right"
            if apples or not looks:
                return Reply("turn_right", why="the apples here should hang on; what is elsewhere?")
            return Reply(min(steps), why="nothing is here")
        goal = min(wanted, key=lambda place: distance((0, 0), place))
        action = min(steps, key=lambda name: distance(goal, steps[name]))
        return Reply(action, why="three others are near it", goal=f"the apple at {goal}")


patient = Patient()
