"""One deliberate fault for each check of each game: changes of its text after which that check, and not only another, must fail.

A check that `extends` inherits is listed with the file that states it.
"""

from typing import NamedTuple


class Mutation(NamedTuple):
    """`check`: how the check begins. `changes`: text -> text, each found once."""

    game: str
    check: str
    changes: tuple[tuple[str, str], ...]

    @property
    def refused(self) -> bool:
        """Whether the compiler itself says so."""
        return self.check.startswith("require")


def _by_index(before: str) -> tuple[str, str]:
    """Returns a change after which only agent 0 is paid."""
    return before, f"when agent.index == 0 {{ {before} }}"


# By game and check: what is written, and what is put there; then the same of further changes.
FAULTS: dict[str, dict[str, tuple[str, ...]]] = {
    "coins": {
        "conserved count(agent)": ("give harm to owner", "remove owner"),
        "always count(agent on tile": ("      set tile.coin = none\n", ""),
        "symmetric agents": _by_index("give coin to agent"),
        "require coin + harm < 0": ("harm    : reward      = -2", "harm : reward = -1"),
        "expect own_coins > other_coins": (
            "{ tally own_coins for agent }",
            "{ tally other_coins for agent }",
        ),
    },
    "harvest_open": {
        "once apples == 0": ("case near { 0: 0,", "case near { 0: regrow_1,"),
        "always count(agent on soil": ("      set soil.fruit = none\n", ""),
        "symmetric agents": _by_index("give apple to agent"),
        "require regrow_1 <= regrow_2": ("probability = 0.001", "probability = 0.01"),
        "expect eaten > 0": ("tally eaten for agent", "tally hits for agent"),
        "expect hits == 0": (
            "where zapper chose zap {\n      mark beam of zapper\n      each",
            "{ each",
        ),
    },
    "clean_up": {
        "always dirt >= 0": ("always dirt >= 0 and dirt <= 1", "always dirt >= 0 and dirt <= 0.5"),
        "monotone growth falling in dirt": (
            "ramp(dirt, spoiled_at, perfect_at)",
            "ramp(dirt, perfect_at, spoiled_at)",
        ),
        "symmetric agents": _by_index("give apple to agent"),
        "require perfect_at < spoiled_at": ("fraction    = 0.0 ", "fraction = 0.5 "),
        "always count(agent on orchard": ("{ set orchard.fruit = none  give", "{ give"),
        "always count(water where": (
            "set water.state = clean  set water.cleaners = nobody",
            "set water.state = clean",
        ),
        "expect eaten == 0": ("best_rate * ramp(dirt, spoiled_at, perfect_at)", "0.9"),
        "expect hits == 0": (
            "where zapper chose zap {\n      mark beam of zapper\n      each agent",
            "{ each agent",
        ),
    },
    "coop_mining": {
        "always count(rock where rock.ore is not partial and": (
            "      set rock.ore = none\n",
            "      set rock.ore = none  set rock.left = patience\n",
        ),
        "always count(rock where rock.miners": (
            "      set rock.ore = none\n      set rock.miners = nobody\n",
            "      set rock.ore = none\n",
        ),
        "symmetric agents": (
            "give iron_pays to winner",
            "when winner.index == 0 { give iron_pays to winner }",
        ),
        "require fewest <= most": ("count       = 2 in 1", "count = 5 in 1"),
        "always gold_mined >= fewest": (
            "tally iron_mined for winner",
            "tally gold_mined for winner",
        ),
        "expect iron_mined == 0": (
            "where miner chose mine {",
            "{",
            "probability = 0.0004 ",
            "probability = 0.5 ",
        ),
    },
    "gift_refinement": {
        "symmetric agents": _by_index("add 1 to agent.bag[raw]"),
        "require yields[raw] > 1": ("{ raw: 3, cut: 3, fine: 1 }", "{ raw: 1, cut: 3, fine: 1 }"),
        "require becomes[raw]": ("{ raw: cut, cut: fine,", "{ raw: raw, cut: fine,"),
        "always count(agent where sum(agent.post)": ("      set agent.post[level] = 0\n", ""),
        "expect received == 0": (
            "where giver chose gift and sum(giver.bag) > 0",
            "where sum(giver.bag) > 0",
            "probability = 0.0002",
            "probability = 0.5",
        ),
        "expect consumed == 0": (
            "each agent where agent chose consume {",
            "each agent {",
            "probability = 0.0002",
            "probability = 0.5",
        ),
    },
    "mushrooms": {
        "symmetric agents": _by_index("give eater[meal] to agent"),
        "require eater[red] > eater[green]": (
            "{ red: 1, green: 0, blue: 0,",
            "{ red: 0.3, green: 0, blue: 0,",
        ),
        "require eater[red] < players": ("green: 2 / players", "green: 0.1"),
        "expect hits == 0": (
            "where zapper chose zap {\n      mark beam of zapper\n      each",
            "{ each",
        ),
        "always sum(trials) == 0": ("    set trials[what] = 0\n", ""),
    },
    "pd_arena": {
        "symmetric agents": _by_index("add 1 to agent.bag[patch.class]"),
        "require rest_lo <= rest_hi": ("steps       = 10 in", "steps = 150 in"),
        "always count(agent where agent.resting": (
            "set one.bag = 0  send one to gate",
            "set one.bag = 0",
        ),
        "expect met == 0": ("where row chose interact and ready(row)", "where ready(row)"),
        "require prisoners_dilemma(payoff)": ("{ coop: 5, defect: 1 }", "{ coop: 2, defect: 1 }"),
        "expect collected[coop]": ("tally collected[patch.class]", "tally collected[defect]"),
    },
    "stag_hunt": {
        "require stag_hunt(payoff)": ("stag: 4, hare: 0", "stag: 1, hare: 0"),
        "expect collected[stag]": (
            "with seek patch where patch.class is stag",
            "with seek patch where patch.class is hare",
        ),
    },
    "chicken": {
        "require chicken(payoff)": ("dove: 5, hawk: 0", "dove: 1, hawk: 0"),
        "expect collected[dove]": (
            "with seek patch where patch.class is dove",
            "with seek patch where patch.class is hawk",
        ),
    },
    "allelopathic_harvest": {
        "symmetric agents": (
            "set agent.empty = loading",
            "when agent.index == 0 { set agent.empty = loading }",
        ),
        "expect banished == 0": ("where zapper chose zap {", "{"),
        "require liked > disliked": ("disliked : reward = 1", "disliked : reward = 3"),
        "expect planted[red] == 0": (
            "tally planted[sower.bag] for sower",
            "tally planted[red] for sower",
        ),
    },
    "predator_prey": {
        "symmetric agents": (
            "phase gather {",
            "phase gather { each agent where agent.index == 0 { give 1 to agent } ",
        ),
        "require acorn > apple": ("acorn   : reward      = 18", "acorn : reward = 0"),
        "expect caught == 0": (
            "each agent on tree where",
            "each agent { tally caught for agent }  each agent on tree where",
        ),
        "always caught == eaten": (
            "tally caught for hunter  tally eaten for target",
            "tally caught for hunter",
        ),
    },
    "territory": {
        "symmetric agents": (
            "tally claimed for winner",
            "when winner.index == 0 { tally claimed for winner }",
        ),
        "always count(brick where brick.owner is nobody": (
            "set b.owner = nobody  set b.paint = none",
            "set b.owner = nobody",
        ),
        "always count(brick where brick.damage == strikes": (
            "(b.damage == strikes or b.owner.hits == strikes)",
            "b.owner.hits == strikes",
        ),
        "expect paid > 0": ("tally paid for b.owner", "tally gone for b.owner"),
        "expect blows == 0": (
            "each agent as zapper where zapper chose zap {",
            "each agent as zapper {",
        ),
    },
    "lb_foraging": {
        "symmetric agents": (
            "tally shared for agent",
            "when agent.index == 0 { tally shared for agent }",
        ),
        "always count(floor where": ("food > 0) <= foods", "food > 0) <= foods - 1"),
        "always shared >= taken": ("        tally taken\n", "        tally taken by 5\n"),
        "require worth > 0": ("param worth     : reward = 1 ", "param worth     : reward = 0 "),
        "expect taken > 0": (
            "        tally taken\n",
            "        when strength > 99 { tally taken }\n",
        ),
        "expect taken == 0": (
            "each agent in beside of floor where agent chose load { give -penalty",
            "each agent in beside of floor { give -penalty",
        ),
    },
    "stag_chase": {
        "symmetric agents": ("give game_ to a", "when a.index == 0 { give game_ to a }"),
        "always all (stag where before": (
            "phase tire { each stag {",
            "phase tire { each stag { when stag.bolts == 2 { set stag.bolts = 0 }",
        ),
        "require venison": ("venison : reward = 5 ", "venison : reward = 1 "),
        "expect felled == 0": (
            "let hunters = count(agent as a where near(a, stag) and a chose strike)",
            "let hunters = count(agent as a where near(a, stag))",
        ),
        "expect felled > 0": (
            "        tally felled\n",
            "        when step > 999 { tally felled }\n",
        ),
        "expect felled < caught": ("tally caught for a", "when step > 999 { tally caught for a }"),
    },
    "ferry": {
        "symmetric agents": (
            "tally crossed for agent",
            "when agent.index == 0 { tally crossed for agent }",
        ),
        "require price[0]": ("{ 0: 10, 1: 9,", "{ 0: 1, 1: 9,"),
        "always sold_ <= grown": ("tally grown for agent", "tally sold_ for agent"),
        "expect sold_ > 0": ("add 1 to sold[0]  tally sold_ for agent", "add 1 to sold[0]"),
        "expect sold_ == 0": (
            "tally grown for agent",
            "tally grown for agent  tally sold_ for agent",
        ),
    },
    "reputation": {
        "require least <= most": ("least   : reward      = 2 ", "least : reward = 7 "),
        "require least > effort": ("effort  : reward      = 1 ", "effort : reward = 3 "),
        "always all (agent where agent.days": ("agent.days in 0 .. 3", "agent.days in 0 .. 0"),
        "always illnesses >= healed": ("tally healed for b", "tally healed by 3 for b"),
        "expect healed == 0 with never": ("tally illnesses for agent", "tally healed for agent"),
        "expect healed > 0": ("tally healed for b  ", ""),
        "expect healed == 0 with defector": ("tally illnesses for agent", "tally healed for agent"),
    },
    "open_harvest": {
        "require pace_least": ("rot_least   : steps       = 2 ", "rot_least : steps = 9 "),
        "require regrow_1": ("probability = 0.001 ", "probability = 0.01 "),
        "require pay[best]": ("reward      = { best: 1,", "reward = { best: 0.4,"),
        "always count(agent on tree": (
            "set tree.taken = tree.fruit  set tree.fruit = bare",
            "set tree.taken = tree.fruit",
        ),
        "always not before(dead)": ("case near(cell) { 0: 0,", "case near(cell) { 0: regrow_3,"),
        "symmetric agents": _by_index("give pay[value] to agent"),
        "expect hits == 0": (
            "each agent as zapper where zapper chose zap {",
            "each agent as zapper {",
        ),
    },
    "open_clean_up": {
        "always dirt >= 0": ("always dirt >= 0 and dirt <= 1", "always dirt >= 0 and dirt <= 0.5"),
        "monotone growth falling in dirt": (
            "ramp(dirt, spoiled_at, perfect_at)",
            "ramp(dirt, perfect_at, spoiled_at)",
        ),
        "symmetric agents": _by_index("give apple to agent"),
        "require perfect_at < spoiled_at": ("fraction    = 0.0 ", "fraction = 0.5 "),
        "always count(agent on orchard": ("{ set orchard.fruit = none  give", "{ give"),
        "always not any (agent where agent.newer": (
            "set agent.older = agent.newer  set agent.newer =",
            "set agent.older =",
        ),
        "expect cleared == 0": ("tally shots for cleaner", "tally cleared for cleaner"),
        "expect eaten == 0": ("best_rate * ramp(dirt, spoiled_at, perfect_at)", "0.9"),
        "expect eaten > 0": ("tally eaten for agent", "when step > 999 { tally eaten for agent }"),
    },
}
MUTATIONS = [
    Mutation(game, check, tuple(zip(texts[::2], texts[1::2], strict=True)))
    for game, faults in FAULTS.items()
    for check, texts in faults.items()
]
