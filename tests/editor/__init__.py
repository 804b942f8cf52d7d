"""What editors ask about a text: positions, names, completion, messages, and a client that asks over standard input and output."""
