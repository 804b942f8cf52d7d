"""What editors ask about a text: pure functions from texts and positions to structures of the Language Server Protocol (LSP)."""
