"""Random games of numbers that float32 rounds: beside 2^24, infinite, and numbers of agents that sizes say.

Their proofs are of four kinds: ranges of fields whose guards compare whole numbers with reals, ramps whose ends are beside 2^24,
symmetries of agents that are named by numbers, and bounds of reals that leave float32.
"""

from random import Random

GAME = """sj 1
game numbers "Numbers" {{
  size players : count = {players}
  size guests : count = 1 in 1 .. 2
  param large : number = 1000000000 in -1000000000 .. 1000000000
  param lim : number = {base} in {low} .. {high}
  param one : number = 4 in 0.9 .. 4
  param begin : count = {least} in {least} .. {most}
  param finish : count = {most} in {least} .. {most}
  episode 20
  kind grass "."
  map {{ "...." "...." "...." }}
  field n : {low} .. {high} = {base}
  field m : {low} .. {high} = {base}
  field j : 0 .. 5 = 0
{fields}
  field pot : reward = 1
  field pan : reward = -1
  agents {number} {{
    acts stay, forward, vote(agent)
    field votes : 0 .. 5 capped = 0
{forbids}
  }}
{defines}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{
    each agent where agent chose vote {{ add 1 to agent.vote.votes }}
{rules}
  }}
  checks {{
    require begin < finish
    require lim < lim{sum}
    symmetric agents
{checks}
  }}
}}
"""
LARGE = 2**24
COMPARED = (
    "{n} <= {c}",
    "{n} < {c}",
    "{c} >= {n}",
    "{n} == {c}",
    "{n} in {a} .. {c}",
    "not ({n} > {c})",
    "not ({n} >= {c} + {one})",
)
SUM = " + one" * 20
ENDS = (
    ("n", "m"),
    ("n", "m + 1"),
    ("begin", "finish"),
    ("lim", "lim + one"),
    ("lim", f"lim{SUM}"),
    ("n * 1.0", "m * 1.0"),
)
REALS = (
    "pot", "pan", "pot * 0", "pot - pot", "pot + pan", "min(pot, 5)", "max(pot, 1)", "max(pot * 0, 1)", "min(max(pot, 0), 5)", "-pot",
    "pot / (max(pan, 0) + 1)", "(pot + 1) / (max(pot, 0) + 1)", "abs(pan)", "large * large", "large * large * large * large * large",
    "large * large * large * large * large * 0", "max(large * large * large * large * large, 1)", "min(one, 1)", "one - one", "one * 0",
    "sum(one over agent)", "max(sum(large * large * large * large over agent), 2)", "ramp(lim, 0, one)", "min(large, 5) * one", "sum(pot * 0 over agent)", "sum(large * large * large * large over agent)",
    "ramp(pot, 0, 1)", "ramp(large, 0, max(pan, 1) + 1)", "round(min(max(pot, 0), 5))", "max(min(pot * large, 3), 2)", "min(pot, pan) - min(pan, pot)",
)  # fmt: skip


def numbers_game(random: Random, checks: int) -> str:
    """Returns the text of a game with so many checks of each of the first two kinds, and of reals twice as many."""
    base = random.choice((LARGE, LARGE, LARGE, 2 * LARGE, -LARGE, 100))
    fields, made, defines = list[str](), list[str](), list[str]()
    rules = random.choice(([], ["    add pot * 1000000 to pot  add pan * large to pan"]))
    for i in range(checks):
        most = random.randint(2, 9)
        fields.append(f"  field k_{i} : 0 .. {most} = 0")
        rules.append("    " + _guarded(random, base, most, i))
        made.append(f"    always k_{i} {random.choice((f'<= {most}', f'in 0 .. {most}', '>= 0'))}")
        made.append("    " + _ramp(random))
        zero, one = random.choice(ENDS)
        defines += [f"  define value_{i} = ramp(n, {zero}, {one})", f"  define argument_{i} = n"]
        made.append(
            f"    monotone value_{i} {random.choice(('rising', 'falling'))} in argument_{i}"
        )
        made += ["    " + _bound(random) for _ in range(2)]
    players, number, forbids = _agents(random)
    return GAME.format(
        base=base,
        low=base - 8,
        high=base + 8,
        least=abs(base) - 8,
        most=abs(base) + 8,
        sum=SUM,
        players=players,
        number=number,
        forbids=forbids,
        fields="\n".join(fields),
        rules="\n".join(rules),
        defines="\n".join(defines),
        checks="\n".join(made),
    )


def _guarded(random: Random, base: int, most: int, i: int) -> str:
    """Returns a `set` of a field that is in its range by what a guard says of `n`, if that is exact."""
    first = base - random.randint(0, 6)
    last = first + most + random.choice((0, 0, 0, 1, -1))
    number = random.choice(("n", "n", "n", "n + j", "m + j", "n * one"))
    lower = f"{number} >= {first}" if "one" not in number else f"n >= {first}"
    value = f"{number.removesuffix(' * one')} - {_said(first)}"
    written = random.choice(("{}", "{}.0", "{}.0", "{} + 0.0", "{} + j - j * 1.0")).format(last)
    upper = random.choice(COMPARED).format(
        n=number, c=written, a=first, one=random.choice(("1", "1.0"))
    )
    if random.random() < 0.3:
        return f"when {lower} {{ when not ({upper}) {{ set j = 0 }} otherwise {{ set k_{i} = {value} }} }}"
    return f"when {lower} and {upper} {{ set k_{i} = {value} }}"


def _ramp(random: Random) -> str:
    """Returns that a ramp is from 0 to 1, where its ends differ."""
    zero, one = random.choice(ENDS)
    value = random.choice(("n", "m", "lim", zero, one))
    ramp = f"ramp({value}, {zero}, {one})"
    bounded = random.choice((f"{ramp} <= 1", f"{ramp} >= 0", f"{ramp} in 0 .. 1"))
    guard = random.choice(
        (f"not ({zero} < {one}) or ", f"{zero} >= {one} or ", f"{zero} == {one} or ", "")
    )
    return f"always {guard}{bounded}"


def _bound(random: Random) -> str:
    """Returns a bound of a real that may leave float32, or that it stays the same."""
    value = random.choice(REALS)
    if random.random() < 0.1:
        return f"conserved {value}"
    other = random.choice(("0", "1", "2", "3", "5", "0 - 1", "6"))
    return f"always {random.choice(('{v} <= {c}', '{v} >= {c}', 'not ({v} > {c})', '{v} != {c}', '{v} in 0 .. {c}')).format(v=value, c=other)}"


def _agents(random: Random) -> tuple[str, str, str]:
    """Returns the value and limits of the size `players`, the number of agents, and what they are forbidden."""
    own = random.choice((1, 1, 2, 3))
    players = random.choice((f"{own}", f"{own} in 1 .. 4", f"{own} in {own} .. {own}"))
    number = random.choice(("players", "players", "players * 1", "players + guests", "guests"))
    least = {"players + guests": own + 1, "guests": 1}.get(number, own)
    named = random.randint(1, least)
    votes = random.choice(
        ("vote", "vote(x)", ", ".join(f"vote({i})" for i in range(named)), "vote(0)")
    )
    when = random.choice(("step >= 0", "agent.votes < 3", "step < 10"))
    return players, number, f"    forbid {votes} when {when}"


def _said(number: int) -> str:
    return f"({number})" if number < 0 else f"{number}"
