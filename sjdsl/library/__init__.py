"""Games by name or file, their parameters, and the environments made from them."""
