"""Laws between runs: what must stay the same, or change in step, when a game, a state or its luck is changed in a known way."""
