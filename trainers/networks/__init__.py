"""From observations to action logits and values: networks, layers, and which agents share them."""
