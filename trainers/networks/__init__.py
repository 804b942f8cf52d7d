"""From observations to action logits and values: networks, their layers, and which agents share them."""
