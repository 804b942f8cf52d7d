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
from bench.socialjax_original import load
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
CLIP = jnp.clip


def suite_game(checkout: Path, original: str, steps: int = 1000, **arguments: Any) -> Any:
    """Returns a game of the suite, with individual rewards, without chex and under this version of JAX."""
    chex = types.ModuleType("chex")  # of which the suite's modules use a dataclass and names of types
    chex.dataclass = dataclasses.dataclass
    chex.PRNGKey = chex.Array = chex.ArrayDevice = jax.Array
    sys.modules.setdefault("chex", chex)
    jnp.clip = clip
    return load(checkout, original)(shared_rewards=False, num_inner_steps=steps, **arguments)


def clip(x: Any, *bounds: Any, a_min: Any = None, a_max: Any = None, **named: Any) -> Array:
    """Is `jnp.clip` that also takes the names that its bounds had in older versions of JAX, which the suite uses."""
    if a_min is None:
        return CLIP(x, *bounds, **named)
    return CLIP(x, a_min, a_max)


class Bridge:
    """One game in both codes, with one environment; callers `vmap`.

    Attributes:
      name: ours. suite, ours: the environments. checkpoint: the file of a trained policy; "": there is none.
    """

    name = ""
    original = ""  # module and class in the suite
    checkpoint = ""
    agents = 7
    zap = 7  # the number of the action
    stepwise = True  # whether single steps are compared

    def __init__(self, checkout: Path) -> None:
        """Loads both."""
        self.suite = suite_game(checkout, self.original, num_agents=self.agents, **self.arguments(checkout))
        self.ours = sjdsl.make(self.name, variant="socialjax", num_agents=self.agents)
        self.module = self.ours.module
        reset = self.suite.reset.__wrapped__
        inner = {**closure(self.suite.step_env.__wrapped__), **closure(reset)}
        self.see: Callable[[Any], Array] = inner["_get_obs"]
        self.inner = inner
        moves = [*MOVES, *range(len(MOVES), self.ours.num_actions)]
        self.numbers = jnp.asarray(moves, jnp.int32)
        rows = self.module.MAP
        self.rows, self.cols = len(rows), len(rows[0])
        self.blank = self.suite.reset(jax.random.PRNGKey(0))[1]

    def arguments(self, checkout: Path) -> dict[str, Any]:
        """Returns further arguments of the suite's class."""
        del checkout
        return {}

    def cells(self, glyphs: str) -> tuple[np.ndarray, np.ndarray]:
        """Returns the rows and columns of the cells with these glyphs, in reading order."""
        return np.where([[glyph in glyphs for glyph in row] for row in self.module.MAP])

    def place(self, state: Any) -> Array:
        """Returns where our agents are, as the suite has it, `[N, 3]`: row, column, heading."""
        row, col = jnp.divmod(state.position.astype(jnp.int32), self.module.FRAME[1])
        return jnp.stack([row - self.module.PAD, col - self.module.PAD, (2 - state.heading.astype(jnp.int32)) % 4], axis=-1)

    def placed(self, state: Any, places: Array) -> Any:
        """Returns our state with its agents at these places."""
        position = (places[:, 0] + self.module.PAD) * self.module.FRAME[1] + places[:, 1] + self.module.PAD
        return state.replace(position=position.astype(jnp.int32), heading=((2 - places[:, 2]) % 4).astype(jnp.int32))

    def walked(self, key: Array, state: Any, actions: Array) -> Array:
        """Returns where our agents are after they walk, before any is sent off."""
        after, _ = self.module.walk(state, self.module.no_outcome(), self.ours.params, self.numbers[actions], key_words(key))
        return self.place(after)

    # one step from a state of the suite

    def from_suite(self, state: Any) -> Any:
        """Returns our state that is equal to one of the suite."""
        raise NotImplementedError

    def step_from(self, key: Array, state: Any, actions: Array) -> Any:
        """Returns our state after a step from a state of the suite."""
        return self.ours.step_env(key, self.from_suite(state), self.numbers[actions])[1]

    def hit(self, state: Any, actions: Array) -> Array:
        """Returns which agents the suite sent off in the step that led to a state of its own."""
        return self.inner["_interact"](jax.random.PRNGKey(0), state, actions)[0]

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Returns 1 for each sort of difference between the states after a step, else 0."""
        sent = self.hit(after, actions)
        wanted = self.wanted(before, actions)
        stay = before.reborn_locs[:, :2]
        others = ~jnp.eye(self.agents, dtype=bool)
        contested = jnp.any(jnp.all(wanted[:, None] == wanted[None], axis=-1) & others & jnp.any(wanted != stay, axis=-1)[:, None])
        moved = jnp.any(self.place(ours) != after.agent_locs, axis=-1)
        return {
            "steps with a contest by lot": contested,
            "steps after which places differ, without a contest": jnp.any(moved & ~sent) & ~contested,
        }

    def wanted(self, before: Any, actions: Array) -> Array:
        """Returns the cells to which agents want to go, `[N, 2]`."""
        module = sys.modules[type(self.suite).__module__]
        steps = jnp.where((actions >= 2) & (actions < 6), 1, 0)[:, None] * module.STEP_MOVE[jnp.minimum(actions, 7)][:, :2]
        return jnp.clip(before.reborn_locs[:, :2] + steps, 0, jnp.asarray([self.rows - 1, self.cols - 1]))

    # whole episodes

    def suite_figures(self, after: Any, rewards: Array, actions: Array) -> Figures:
        """Returns what one step of the suite adds to an episode's figures."""
        return {"return": rewards.sum() / self.agents, "sent off": gone(after).sum(), **self.shares(actions)}

    def shares(self, actions: Array) -> Figures:
        """Returns how many agents chose the game's own actions."""
        return {f"`{name}` chosen": jnp.sum(actions == number) for number, name in enumerate(self.ours.action_names) if number >= self.zap}

    def begin(self, state: Any) -> Any:
        """Returns the suite's state that shows our first state."""
        raise NotImplementedError

    def observe(self, carried: Any) -> Array:
        """Returns the suite's observations of a state of its own."""
        return self.see(carried)

    def step(self, key: Array, state: Any, carried: Any, actions: Array) -> tuple[Any, Any, Figures]:
        """Returns our next state, the suite's state that shows it, and what the step adds to an episode's figures."""
        walked = self.walked(key, state, actions)
        _, after, reward, _, _ = self.ours.step_env(key, state, self.numbers[actions])
        shown = self.show(after, walked, carried, reward, actions)
        return after, shown, {"return": reward.sum(), "sent off": gone(shown).sum(), **self.shares(actions)}

    def show(self, after: Any, walked: Array, carried: Any, reward: Array, actions: Array) -> Any:
        """Returns the suite's state that shows ours after a step; who was sent off is still seen where it walked."""
        raise NotImplementedError


def gone(state: Any) -> Array:
    """Returns which agents of a state of the suite were sent off in its last step."""
    return jnp.any(state.reborn_locs != state.agent_locs, axis=-1)


def closure(function: Any) -> dict[str, Any]:
    """Returns the variables of the functions around one that it uses."""
    return dict(zip(function.__code__.co_freevars, [cell.cell_contents for cell in function.__closure__], strict=True))


class CleanUp(Bridge):
    """Clean Up."""

    name, original = "clean_up", "cleanup.clean_up:Clean_up"
    checkpoint = "clean_up_seed30_reward_individual.pkl"

    def hit(self, state: Any, actions: Array) -> Array:
        """Its two beams have functions of their own."""
        return self.inner["_interact_fire_zapping"](jax.random.PRNGKey(0), state, actions)[0]

    def from_suite(self, state: Any) -> Any:
        """Labels of dirt are those of the list, which lasts under agents; marks and those sent off hide bare orchard cells."""
        water, orchard = self.cells("HF"), self.cells("B")
        labels = jnp.zeros((self.rows, self.cols), jnp.int16)
        labels = labels.at[tuple(state.potential_dirt_and_dirt_locs.T)].set(state.potential_dirt_and_dirt_label)
        left = jnp.zeros((self.rows, self.cols), bool).at[tuple(state.agent_locs[:, :2].T)].max(gone(state))
        hidden = (state.grid == 2) | (state.grid == 9) | left
        ours = self.module.initial_state().replace(
            step=jnp.int32(state.inner_t),
            water_state=(labels[water] == 8).astype(jnp.uint8),
            orchard_fruit=(state.grid[orchard] == 3).astype(jnp.uint8),
            orchard_hidden=hidden[orchard].astype(jnp.uint8),
        )
        return self.placed(ours, state.reborn_locs)

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Adds those of the water."""
        labels = jnp.zeros((self.rows, self.cols), jnp.int16)
        labels = labels.at[tuple(after.potential_dirt_and_dirt_locs.T)].set(after.potential_dirt_and_dirt_label)
        water = (labels[self.cells("HF")] == 8) != (ours.water_state == 1)
        found = super().differences(before, actions, after, ours)
        calm = ~found["steps with a contest by lot"]
        return {**found, "steps after which more than the two cells of a dirt draw differ": calm & (water.sum() > 2)}

    def begin(self, state: Any) -> Any:
        """No marks yet."""
        return self.draw(self.blank, state, self.place(state))

    def draw(self, carried: Any, state: Any, places: Array) -> Any:
        """Returns a state of the suite with water and apples of ours, and agents at these places."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16)
        grid = grid.at[self.cells("B")].set(jnp.where(state.orchard_fruit == 1, 3, 0).astype(jnp.int16))
        grid = grid.at[self.cells("S")].set(6)
        grid = grid.at[self.cells("HF")].set(jnp.where(state.water_state == 1, 8, 7).astype(jnp.int16))
        grid = grid.at[places[:, 0], places[:, 1]].set(self.suite._agents)
        places = places.astype(jnp.int16)
        return carried.replace(grid=grid, agent_locs=places, reborn_locs=places)

    def show(self, after: Any, walked: Array, carried: Any, reward: Array, actions: Array) -> Any:
        """The suite's own code draws the beams."""
        key = jax.random.PRNGKey(0)
        shown = self.draw(carried, after, walked)
        _, shown = self.inner["_interact_fire_zapping"](key, shown, actions)
        shown = self.inner["_interact_fire_cleaning"](key, shown, actions)
        bags = carried.agent_invs + (reward > 0).astype(jnp.int8)[:, None]
        return shown.replace(reborn_locs=self.place(after).astype(jnp.int16), agent_invs=bags)


class Harvest(Bridge):
    """Commons Harvest: Open, and with the maps of the suite's configurations the other two."""

    name, original = "harvest_open", "common_harvest.harvest_open:Harvest_open"
    checkpoint = "harvest_common_open_seed30_reward_individual.pkl"

    def from_suite(self, state: Any) -> Any:
        """Marks block the floor and hide soil, as do those sent off."""
        left = jnp.zeros((self.rows, self.cols), bool).at[tuple(state.agent_locs[:, :2].T)].max(gone(state))
        marked, soil = state.grid == 2, self.cells("A")
        ours = self.module.initial_state().replace(
            step=jnp.int32(state.inner_t),
            soil_fruit=(state.grid[soil] == 3).astype(jnp.uint8),
            soil_hidden=(marked | left)[soil].astype(jnp.uint8),
            floor_marked=marked[self.cells(".Q")].astype(jnp.uint8),
            gate_marked=marked[self.cells("P")].astype(jnp.uint8),
        )
        return self.placed(ours, state.reborn_locs)

    def differences(self, before: Any, actions: Array, after: Any, ours: Any) -> Figures:
        """Adds those of the marks."""
        marked = jnp.zeros((self.rows, self.cols), bool)
        marked = marked.at[self.cells(".Q")].set(ours.floor_marked == 1).at[self.cells("P")].set(ours.gate_marked == 1)
        found = super().differences(before, actions, after, ours)
        bare = np.isin(np.array([list(row) for row in self.module.MAP]), list(".QP"))
        marks = jnp.any(bare & (marked != (after.grid == 2)))
        return {**found, "steps after which marks differ, without a contest": marks & ~found["steps with a contest by lot"]}

    def begin(self, state: Any) -> Any:
        """No marks yet."""
        return self.draw(self.blank, state, self.place(state))

    def draw(self, carried: Any, state: Any, places: Array) -> Any:
        """Returns a state of the suite with walls and apples of ours, and agents at these places."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16).at[self.cells("#")].set(1)
        grid = grid.at[self.cells("A")].set(jnp.where(state.soil_fruit == 1, 3, 0).astype(jnp.int16))
        grid = grid.at[places[:, 0], places[:, 1]].set(self.suite._agents)
        places = places.astype(jnp.int16)
        return carried.replace(grid=grid, agent_locs=places, reborn_locs=places)

    def show(self, after: Any, walked: Array, carried: Any, reward: Array, actions: Array) -> Any:
        """The suite's own code draws the beam."""
        _, shown = self.inner["_interact"](jax.random.PRNGKey(0), self.draw(carried, after, walked), actions)
        bags = carried.agent_invs + (reward > 0).astype(jnp.int8)[:, None]
        return shown.replace(reborn_locs=self.place(after).astype(jnp.int16), agent_invs=bags)


class Closed(Harvest):
    """Commons Harvest: Closed."""

    name, checkpoint = "harvest_closed", ""

    def arguments(self, checkout: Path) -> dict[str, Any]:
        """Its map is in a configuration."""
        text = (checkout / "algorithms" / "IPPO" / "config" / f"ippo_cnn_{self.name}.yaml").read_text()
        return {"map_ASCII": re.findall(r'"([ AWQP]{20,})"', text)}


class Partnership(Closed):
    """Commons Harvest: Partnership."""

    name = "harvest_partnership"


class Territory(Bridge):
    """Territory, played by its policy; its states of the suite are not made into ours."""

    name, original = "territory", "territory.territory_env:Territory_open"
    checkpoint = "individual/territory_open_seed30.pkl"
    agents = 9
    stepwise = False

    def suite_figures(self, after: Any, rewards: Array, actions: Array) -> Figures:
        """Its individual rewards are not multiplied by the number of agents."""
        return {**super().suite_figures(after, rewards, actions), "return": rewards.sum()}

    def begin(self, state: Any) -> Any:
        """No marks yet."""
        return self.draw(self.blank, self.place(state), self.bricks(state))

    def bricks(self, state: Any) -> Array:
        """Returns the suite's numbers of the bricks: 7 free, 1000 and more for an owner, 999 cracked, 0 gone."""
        owned = jnp.where(state.brick_owner >= 0, 1000 + state.brick_owner, 7)
        return jnp.where(state.brick_damage == 0, owned, jnp.where(state.brick_damage == 1, 999, 0)).astype(jnp.int16)

    def draw(self, carried: Any, places: Array, bricks: Array) -> Any:
        """Returns a state of the suite with walls, these bricks, and agents at these places."""
        grid = jnp.zeros((self.rows, self.cols), jnp.int16).at[self.cells("#")].set(1)
        grid = grid.at[self.cells("R")].set(bricks).at[places[:, 0], places[:, 1]].set(self.suite._agents)
        places = places.astype(jnp.int16)
        return carried.replace(grid=grid, agent_locs=places, reborn_locs=places)

    def show(self, after: Any, walked: Array, carried: Any, reward: Array, actions: Array) -> Any:
        """The suite's own code draws the beam around bricks, which it would break again."""
        del reward
        bricks = self.bricks(after)
        shown = self.draw(carried, walked, jnp.where(bricks > 0, 1, 0).astype(jnp.int16))
        shown = shown.replace(claimed_coord=jnp.zeros((self.rows, self.cols), bool))
        _, shown = self.inner["_interact"](jax.random.PRNGKey(0), shown, actions)
        cells = self.cells("R")
        grid = shown.grid.at[cells].set(jnp.where(bricks > 0, bricks, shown.grid[cells]))
        return shown.replace(grid=grid, reborn_locs=self.place(after).astype(jnp.int16))


BRIDGES: dict[str, type[Bridge]] = {bridge.name: bridge for bridge in (CleanUp, Harvest, Closed, Partnership, Territory)}
