"""Games of SocialJax beside ours: states of one made into states of the other."""

import dataclasses
import re
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

import sjdsl
from bench.socialjax_original import clip, load
from sjdsl.interop.socialjax import ACTIONS
from sjdsl.runtime.random_bits import key_words

ORIGINALS = {  # by the suite's id: module and class, agents, steps of an episode
    "coin_game": ("coin_game.coin_game:CoinGame", 2, 1000),
    "harvest_common_open": ("common_harvest.harvest_open:Harvest_open", 7, 1000),
    "clean_up": ("cleanup.clean_up:Clean_up", 7, 1000),
    "coop_mining": ("coop_mining.coop_mining:CoopMining", 6, 1000),
    "gift": ("gift.gift:Gift", 5, 1000),
    "mushrooms": ("mushrooms.mushrooms:Mushrooms", 5, 1000),
    "pd_arena": ("pd_arena.pd_arena:PD_Arena", 4, 1000),
    "territory_open": ("territory.territory_env:Territory_open", 9, 1000),
    "lb_foraging": ("lb_foraging.lb_foraging:LevelBasedForaging", 4, 100),
}
MOVES = ACTIONS["turned round"]
Figures = dict[str, Array]


def suite_game(checkout: Path, original: str, steps: int = 1000, **arguments: Any) -> Any:
    """Returns a game of the suite with individual rewards, without chex, under this version of JAX."""
    # The suite's modules use only its dataclass and names of types.
    chex = types.ModuleType("chex")
    chex.dataclass = dataclasses.dataclass
    chex.PRNGKey = chex.Array = chex.ArrayDevice = jax.Array
    sys.modules.setdefault("chex", chex)
    jnp.clip = clip
    return load(checkout, original)(shared_rewards=False, num_inner_steps=steps, **arguments)


def closure(function: Any) -> dict[str, Any]:
    """Returns the variables that a function uses of those around it, by name."""
    values = [cell.cell_contents for cell in function.__closure__]
    return dict(zip(function.__code__.co_freevars, values, strict=True))


def sent_off(state: Any) -> Array:
    """Returns which agents of a state of the suite were hit, bool `[N]`: they are still seen at `agent_locs`, and begin the next step at `reborn_locs`."""
    return jnp.any(state.reborn_locs != state.agent_locs, axis=-1)


class Bridge:
    """One game in both codes; its functions are of one environment, and callers `vmap` them.

    Attributes:
      name: of our game. original: module and class in the suite. agents: how many play.
      checkpoint: the file of a trained policy; "": there is none.
      zap: the number of the first action that is no move.
      stepwise: whether single steps are compared.
      suite, ours: the environments. see: the suite's observations of one of its states.
    """

    name = ""
    original = ""
    checkpoint = ""
    agents = 7
    zap = 7
    stepwise = True

    def __init__(self, checkout: Path) -> None:
        """Loads both."""
        arguments = self.arguments(checkout)
        self.suite = suite_game(checkout, self.original, num_agents=self.agents, **arguments)
        self.ours = sjdsl.make(self.name, variant="socialjax", num_agents=self.agents)
        self.module = self.ours.module
        step = self.suite.step_env.__wrapped__
        reset = self.suite.reset.__wrapped__
        self.inner = {**closure(step), **closure(reset)}
        self.see: Callable[[Any], Array] = self.inner["_get_obs"]
        moves = [*MOVES, *range(len(MOVES), self.ours.num_actions)]
        self.numbers = jnp.asarray(moves, jnp.int32)
        self.rows = len(self.module.MAP)
        self.cols = len(self.module.MAP[0])
        self.blank = self.suite.reset(jax.random.PRNGKey(0))[1]

    def arguments(self, checkout: Path) -> dict[str, Any]:
        """Returns further arguments of the suite's class."""
        del checkout
        return {}

    def cells(self, glyphs: str) -> tuple[np.ndarray, np.ndarray]:
        """Returns the rows and columns of the cells with these glyphs, in reading order."""
        return np.where([[glyph in glyphs for glyph in row] for row in self.module.MAP])

    def board(self, values: Array, places: Array) -> Array:
        """Returns a map of zeros and these values at these places, `[H, W]`."""
        zeros = jnp.zeros((self.rows, self.cols), values.dtype)
        return zeros.at[places[:, 0], places[:, 1]].max(values)

    def place(self, state: Any) -> Array:
        """Returns where our agents are, in the suite's numbers, `[N, 3]`: row, column, heading."""
        row, col = jnp.divmod(state.position.astype(jnp.int32), self.module.FRAME[1])
        heading = (2 - state.heading.astype(jnp.int32)) % 4
        return jnp.stack([row - self.module.PAD, col - self.module.PAD, heading], axis=-1)

    def with_places(self, state: Any, places: Array) -> Any:
        """Returns our state with its agents at these places."""
        row = places[:, 0].astype(jnp.int32) + self.module.PAD
        position = row * self.module.FRAME[1] + places[:, 1] + self.module.PAD
        heading = (2 - places[:, 2]) % 4
        return state.replace(position=position.astype(jnp.int32), heading=heading.astype(jnp.int32))

    # one step from a state of the suite

    def from_suite(self, state: Any) -> Any:
        """Returns our state that is equal to one of the suite."""
        raise NotImplementedError

    def step_from(self, key: Array, state: Any, actions: Array) -> Any:
        """Returns our state after a step from a state of the suite."""
        return self.ours.step_env(key, self.from_suite(state), self.numbers[actions])[1]

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Returns 1 for each sort of difference between the states after a step, else 0."""
        wanted = self.wanted(before, actions)
        others = ~jnp.eye(self.agents, dtype=bool)
        same_target = jnp.all(wanted[:, None] == wanted[None], axis=-1) & others  # [N, N]
        moving = jnp.any(wanted != before.reborn_locs[:, :2], axis=-1)
        contested = jnp.any(same_target & moving[:, None])
        elsewhere = jnp.any(self.place(ours) != after.agent_locs, axis=-1)
        differ = jnp.any(elsewhere & ~self.hit(after, actions))
        return {
            "steps with a contest by lot": contested,
            "steps after which the others' places differ, without a contest": differ & ~contested,
        }

    def hit(self, after: Any, actions: Array) -> Array:
        """Returns which agents the suite's beams hit in the step that led to its state `after`."""
        return self.inner["_interact"](jax.random.PRNGKey(0), after, actions)[0]

    def wanted(self, before: Any, actions: Array) -> Array:
        """Returns the cells to which agents want to go, `[N, 2]`."""
        module = sys.modules[type(self.suite).__module__]
        moving = (actions >= 2) & (actions < 6)
        steps = module.STEP_MOVE[jnp.minimum(actions, 7)][:, :2]
        steps = jnp.where(moving[:, None], steps, 0)
        last = jnp.asarray([self.rows - 1, self.cols - 1])
        return jnp.clip(before.reborn_locs[:, :2] + steps, 0, last)

    # whole episodes

    def suite_return(self, rewards: Array) -> Array:
        """Returns the sum of the agents' rewards, which the suite multiplies by their number."""
        return rewards.sum() / self.agents

    def figures(self, shown: Any, total: Array, actions: Array) -> Figures:
        """Returns what a step that ends in a state of the suite adds to an episode's figures."""
        figures = {"return": total, "agents hit": sent_off(shown).sum()}
        for number, name in enumerate(self.ours.action_names):
            if number >= self.zap:
                figures[f"`{name}` chosen"] = jnp.sum(actions == number)
        return figures

    def step(self, key: Array, state: Any, shown: Any, actions: Array) -> tuple[Any, Any, Figures]:
        """Returns our next state, the suite's state that shows it, and what the step adds to the figures.

        Who was hit is still seen where it walked.
        """
        numbers = self.numbers[actions]
        outcome = self.module.no_outcome()
        walked, _ = self.module.walk(state, outcome, self.ours.params, numbers, key_words(key))
        _, after, reward, _, _ = self.ours.step_env(key, state, numbers)
        shown = self.draw(shown, after, self.place(walked))
        shown = self.mark_beams(shown, after, actions)
        shown = shown.replace(
            reborn_locs=self.place(after).astype(jnp.int16),
            agent_invs=shown.agent_invs + self.newly_carried(reward),
        )
        return after, shown, self.figures(shown, reward.sum(), actions)

    def begin(self, state: Any) -> Any:
        """Returns the suite's state that shows our first state, without marks."""
        return self.draw(self.blank, state, self.place(state))

    def draw(self, shown: Any, state: Any, places: Array) -> Any:
        """Returns a state of the suite with the map of ours, and agents at these places."""
        grid = self.grid_without_agents(state)
        grid = grid.at[places[:, 0], places[:, 1]].set(self.suite._agents)
        places = places.astype(jnp.int16)
        return shown.replace(grid=grid, agent_locs=places, reborn_locs=places)

    def grid_without_agents(self, state: Any) -> Array:
        """Returns the suite's numbers of what is on the map in our state, but for agents, int16 `[H, W]`."""
        raise NotImplementedError

    def mark_beams(self, shown: Any, state: Any, actions: Array) -> Any:
        """Returns a state of the suite with the marks of its own beams; `state` is ours after the step."""
        del state
        return self.inner["_interact"](jax.random.PRNGKey(0), shown, actions)[1]

    def newly_carried(self, reward: Array) -> Array:
        """Returns what agents add to what the suite has them carry, int8 `[N, 1]`."""
        return (reward > 0).astype(jnp.int8)[:, None]


class CleanUp(Bridge):
    """Clean Up."""

    name = "clean_up"
    original = "cleanup.clean_up:Clean_up"
    checkpoint = "clean_up_seed30_reward_individual.pkl"

    def dirty(self, state: Any) -> Array:
        """Returns where a state of the suite has dirt, bool `[H, W]`: its list has it under agents, too."""
        labels = state.potential_dirt_and_dirt_label
        return self.board(labels, state.potential_dirt_and_dirt_locs) == 8

    def from_suite(self, state: Any) -> Any:
        """Returns our equal state: marks, and agents that were hit, hide bare cells of the orchard."""
        orchard = self.cells("B")
        hit = self.board(sent_off(state), state.agent_locs)
        hidden = (state.grid == 2) | (state.grid == 9) | hit
        ours = self.module.initial_state().replace(
            step=jnp.int32(state.inner_t),
            water_state=self.dirty(state)[self.cells("HF")].astype(jnp.uint8),
            orchard_fruit=(state.grid[orchard] == 3).astype(jnp.uint8),
            orchard_hidden=hidden[orchard].astype(jnp.uint8),
        )
        return self.with_places(ours, state.reborn_locs)

    def hit(self, after: Any, actions: Array) -> Array:
        """Returns which agents zaps hit: cleaning beams hit none."""
        return self.inner["_interact_fire_zapping"](jax.random.PRNGKey(0), after, actions)[0]

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Adds the differences of the water."""
        water = self.dirty(after)[self.cells("HF")] != (ours.water_state == 1)
        figures = super().differences(before, actions, after, ours)
        calm = ~figures["steps with a contest by lot"]
        more = calm & (water.sum() > 2)
        return {**figures, "steps after which more than the two cells of a dirt draw differ": more}

    def grid_without_agents(self, state: Any) -> Array:
        """Returns the map with apples, river and dirt."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16)
        grid = grid.at[self.cells("B")].set(
            jnp.where(state.orchard_fruit == 1, 3, 0).astype(jnp.int16)
        )
        grid = grid.at[self.cells("S")].set(6)
        return grid.at[self.cells("HF")].set(
            jnp.where(state.water_state == 1, 8, 7).astype(jnp.int16)
        )

    def mark_beams(self, shown: Any, state: Any, actions: Array) -> Any:
        """Adds the marks of both sorts of beam, zaps first."""
        del state
        key = jax.random.PRNGKey(0)
        _, shown = self.inner["_interact_fire_zapping"](key, shown, actions)
        return self.inner["_interact_fire_cleaning"](key, shown, actions)


class Harvest(Bridge):
    """Commons Harvest: Open."""

    name = "harvest_open"
    original = "common_harvest.harvest_open:Harvest_open"
    checkpoint = "harvest_common_open_seed30_reward_individual.pkl"

    def from_suite(self, state: Any) -> Any:
        """Returns our equal state: marks block the floor; marks, and agents that were hit, hide soil."""
        soil = self.cells("A")
        marked = state.grid == 2
        hit = self.board(sent_off(state), state.agent_locs)
        ours = self.module.initial_state().replace(
            step=jnp.int32(state.inner_t),
            soil_fruit=(state.grid[soil] == 3).astype(jnp.uint8),
            soil_hidden=(marked | hit)[soil].astype(jnp.uint8),
            floor_marked=marked[self.cells(".Q")].astype(jnp.uint8),
            gate_marked=marked[self.cells("P")].astype(jnp.uint8),
        )
        return self.with_places(ours, state.reborn_locs)

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Adds the differences of the marks."""
        floor = self.cells(".Q")
        gates = self.cells("P")
        marked = after.grid == 2
        floor_differs = jnp.any(marked[floor] != ours.floor_marked)
        differ = floor_differs | jnp.any(marked[gates] != ours.gate_marked)
        figures = super().differences(before, actions, after, ours)
        calm = ~figures["steps with a contest by lot"]
        return {**figures, "steps after which marks differ, without a contest": differ & calm}

    def grid_without_agents(self, state: Any) -> Array:
        """Returns the map with walls and apples."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16).at[self.cells("#")].set(1)
        return grid.at[self.cells("A")].set(
            jnp.where(state.soil_fruit == 1, 3, 0).astype(jnp.int16)
        )


class Closed(Harvest):
    """Commons Harvest: Closed."""

    name = "harvest_closed"
    checkpoint = ""

    def arguments(self, checkout: Path) -> dict[str, Any]:
        """Returns the map, which the suite keeps in a configuration."""
        file = checkout / "algorithms" / "IPPO" / "config" / f"ippo_cnn_{self.name}.yaml"
        return {"map_ASCII": re.findall(r'"([ AWQP]{20,})"', file.read_text())}


class Partnership(Closed):
    """Commons Harvest: Partnership."""

    name = "harvest_partnership"


class Territory(Bridge):
    """Territory; single steps aren't compared."""

    name = "territory"
    original = "territory.territory_env:Territory_open"
    checkpoint = "individual/territory_open_seed30.pkl"
    agents = 9
    stepwise = False

    def suite_return(self, rewards: Array) -> Array:
        """Returns the sum of the rewards: here the suite multiplies none."""
        return rewards.sum()

    def bricks(self, state: Any) -> Array:
        """Returns the suite's numbers of the bricks: 7 free, 1000 and more for an owner, 999 cracked, 0 gone."""
        owned = jnp.where(state.brick_owner >= 0, 1000 + state.brick_owner, 7)
        cracked = jnp.where(state.brick_damage == 1, 999, 0)
        return jnp.where(state.brick_damage == 0, owned, cracked).astype(jnp.int16)

    def grid_without_agents(self, state: Any) -> Array:
        """Returns the map with walls and bricks."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16).at[self.cells("#")].set(1)
        return grid.at[self.cells("R")].set(self.bricks(state))

    def mark_beams(self, shown: Any, state: Any, actions: Array) -> Any:
        """Adds the marks. Beams end at bricks, but must not break them again: walls stand in for them."""
        cells = self.cells("R")
        bricks = self.bricks(state)
        walls = jnp.where(bricks > 0, 1, shown.grid[cells]).astype(jnp.int16)
        shown = shown.replace(
            grid=shown.grid.at[cells].set(walls),
            claimed_coord=jnp.zeros((self.rows, self.cols), bool),
        )
        shown = super().mark_beams(shown, state, actions)
        marked = jnp.where(bricks > 0, bricks, shown.grid[cells])
        return shown.replace(grid=shown.grid.at[cells].set(marked))

    def newly_carried(self, reward: Array) -> Array:
        """Returns zeros: nothing is carried."""
        del reward
        return jnp.zeros((self.agents, 1), jnp.int8)


BRIDGES: dict[str, type[Bridge]] = {
    bridge.name: bridge for bridge in (CleanUp, Harvest, Closed, Partnership, Territory)
}
