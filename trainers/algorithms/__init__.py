"""How agents learn: PPO and value decomposition, and the parts that they share."""
