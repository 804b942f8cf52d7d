"""Laws between runs (metamorphic tests): what must not change when a game, a state or its random draws change in a known way."""
