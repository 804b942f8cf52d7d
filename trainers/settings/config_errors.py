"""Error messages for wrong configurations."""

import re
from collections.abc import Collection, Container, Mapping
from typing import Any

from sjdsl.near_names import either, meant, nearest


class ConfigError(Exception):
    """A wrong key or value; the message has a line for each fault."""


# What a value must be, by pydantic's type of fault; `{}` is filled from the fault's context.
EXPECTED: Mapping[str, str] = {
    "greater_than": "more than {gt}",
    "greater_than_equal": "at least {ge}",
    "less_than_equal": "at most {le}",
    "literal_error": "{expected}",
    "value_error": "{error}",
    "too_short": "one number or more",
    **dict.fromkeys(("int_parsing", "int_type", "int_from_float"), "a whole number"),
    **dict.fromkeys(("float_parsing", "float_type", "finite_number"), "a finite number"),
    **dict.fromkeys(("bool_parsing", "bool_type"), "true or false"),
}


# What other libraries call a setting: CleanRL, Stable-Baselines3, RLlib, PureJaxRL, JaxMARL.
SYNONYMS: Mapping[str, str] = {
    "learning_rate": "lr step_size alpha",
    "anneal_learning_rate": "anneal_lr lr_decay lr_schedule",
    "entropy_coefficient": "ent_coef ent_coeff ent_weight entropy",
    "value_coefficient": "vf_coef vf_coeff vf_loss_coeff critic_coef",
    "clip_epsilon": "clip clip_eps clip_param clip_range clip_coef",
    "clip_value_loss": "clip_vloss clip_range_vf vf_clip_param",
    "gamma": "discount discount_factor discount_rate",
    "gae_lambda": "gae lam lambda lambda_",
    "num_epochs": "epochs update_epochs k_epochs ppo_epochs",
    "num_minibatches": "batch_size minibatch_size mini_batches",
    "num_steps": "rollout_length unroll_length horizon n_step",
    "num_envs": "envs environments parallel_envs num_workers",
    "total_timesteps": "steps timesteps max_steps total_steps",
    "max_gradient_norm": "grad_clip clip_grad clip_grad_norm",
    "adam_epsilon": "eps adam_eps opt_eps",
    "network_width": "hidden_size hidden_dim hidden_units width",
    "sharing": "parameter_sharing share_params share_parameters",
    "memory": "rnn lstm gru recurrent",
    "target_rate": "tau polyak",
    "target_update_every": "target_update_interval target_network_frequency",
    "epsilon_fraction": "exploration_fraction eps_decay",
    "buffer_size": "replay_size memory_size",
}


def synonym(key: str, known: Container[str]) -> str:
    """Returns the end of a message about a key that another library has for a known one, else ""."""
    for name, synonyms in SYNONYMS.items():
        if key in synonyms.split() and name in known:
            return f"; did you mean `{name}`?"
    return ""


def meant_key(key: str, known: Collection[str]) -> str:
    """Returns the end of a message about an unknown key: its synonym or the nearest known keys, ""
    if there are none."""
    return synonym(key, known) or meant(key, known, "")


def sentence_of(
    fault: Mapping[str, Any], known: Mapping[str, Any], keys_of: Mapping[str, Mapping[str, Any]]
) -> str:
    """Returns one of pydantic's faults as a sentence.

    Args:
      known: the configuration's keys.
      keys_of: those of every algorithm.
    """
    key = str(fault["loc"][0]) if fault["loc"] else "config"
    kind = fault["type"]
    if kind == "extra_forbidden":
        owners = [algorithm for algorithm, keys in keys_of.items() if key in keys]
        if owners:
            where = f"here: it is one of {' and '.join(owners)}"
            return f"unknown key `{key}` {where}{synonym(key, known)}"
        suggestion = meant_key(key, known) or "; `sjdsl train --keys` lists the keys"
        return f"unknown key `{key}`{suggestion}"
    need = fault["msg"]
    if kind in EXPECTED:
        need = EXPECTED[kind].format(**fault.get("ctx", {}))
    sentence = f"`{key}` must be {need}, not {fault['input']!r}"
    if isinstance(fault["input"], str):
        known_values = re.findall(r"'([^']+)'", need)  # if there are only some
        near = nearest(fault["input"], known_values)
        if near:
            return f"{sentence}; did you mean {either(near)}?"
    return sentence
