"""Identifiers of generated code.

Valid names, different from Python's keywords and from the module's own.
"""

import keyword
import re
from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields, marking_phases

_KERNELS = {
    "bits": "as_bits from_bits has_member pack size_of_large_set size_of_set unpack",
    "counting": "count_near occupied segment_sum times_in",
    "neighbourhood": "entries_at looked_up over_neighbours",
    "random_bits": "below dealt_values next_threshold ranks random_bits random_bits_at threshold unit",
    "fields": "StateField",
    "geometry": "around_edges blocking cells_of inside lane_reach near_masks neighbours next_cells "
    "numbers_among own_cell own_cells view_cells view_offsets view_steps view_steps_around painted "
    "reading_order shape_offsets site_numbers values_of",
    "movement": "resolve",
    "placing": "best_ranks choose come_back drawn_by_lot member_of outranking "
    "pair pair_reached pick pick_of_large_set pick_of_set pick_of_sets place",
    "planes": "TokenPlane",
    "reductions": "all_of any_of argmax_of count_of max_of min_of sum_of",
    "rows": "entry highest lowest mix one_hot ramp shifted",
    "exact_reals": "divided exact_mix exact_ramp exact_sum exactly fixed_point rounded "
    "sum_in_order",
    "elementary": "exact_root exponential logarithm powered root",
    "steering": "gains is_one_of",
    "line_of_sight": "nearest_in_lanes reached",
    "torus": "cells_on joined_edges shorter_way",
    "egocentric_windows": "fill look_fields look_number paint planes_of windows",
    "tasks": "candidate_key drawn_row numbered_key with_entries",
    "writing": "add_at add_to_entry set_at set_entry",
}
# What generated code may call, by module.
KERNELS = {f"sjdsl.runtime.{module}": tuple(names.split()) for module, names in _KERNELS.items()}
RESERVED = {
    "state", "out", "params", "actions", "key", "jnp", "struct", "start", "reset", "step",
    "observe", "measures", "tick", "allowed", "allowed_actions", "episode_length", "initial_state",
    "no_outcome", "default_params", "next_trial", "trial_length", "draw_task",
    "task_of_side", "task_numbers",
    *keyword.kwlist,
    *(name for names in KERNELS.values() for name in names),
}  # fmt: skip
STATE = ("step", "position", "heading", "moved", "away", "away_pool", "away_facing")
# What State has of each mover beside its fields.
POSE = ("position", "moved", "away", "away_pool", "away_facing")
_IDENTIFIER = re.compile(r"[a-z_][a-z0-9_]*")
_TAKEN = {"replace"}  # a method of flax.struct dataclasses


@dataclass
class Names:
    """Hands out names of one scope, each once; what is asked for twice gets a number."""

    taken: set[str] = field(default_factory=set)

    def fresh(self, wanted: str) -> str:
        """Returns `wanted`, or `wanted_2`, `wanted_3`, …"""
        name = wanted
        number = 1
        while name in self.taken:
            number += 1
            name = f"{wanted}_{number}"
        self.taken.add(name)
        return name


def identifier(name: str) -> str:
    """Returns the name if it is an ASCII identifier; anything else is a bug of the compiler."""
    assert _IDENTIFIER.fullmatch(name), name
    return name


def param_attribute(name: str) -> str:
    """Returns the attribute of Params or Outcome for a name of the game.

    A word of Python gets a `_` behind it.
    """
    return identifier(name) + ("_" if keyword.iskeyword(name) or name in _TAKEN else "")


def phase_function(name: str) -> str:
    """Returns the name of the function of a phase use.

    A name that the module needs itself gets `_phase` behind it.
    """
    return identifier(name) + ("_phase" if name in RESERVED else "")


def attribute_name(field: ir.VarField) -> str:
    """Returns the name of a field in State: `soil_fruit`, `agent_bag`, `world_trials`."""
    return identifier(f"{field.held_by.name}_{field.name}")


def attribute_of(name: str, entity_type: ir.EntityType) -> str:
    """Returns the attribute of State for a fact about all agents, or all movers of a type.

    `position`, or `deer_position`.
    """
    return identifier(f"{entity_type.name}_{name}") if entity_type.what == "mover" else name


def state_names(game: ir.Game) -> list[tuple[str, ir.Node]]:
    """Returns every attribute of State that comes from a name of the game, with its declaration."""
    fields: list[tuple[str, ir.Node]] = [
        (attribute_name(field), field) for field in all_fields(game)
    ]
    fields += [
        (attribute_of(name, movers.entity_type), movers) for movers in game.movers for name in POSE
    ]
    return fields + [(f"mark_{phase.name}", phase) for phase in marking_phases(game)]
