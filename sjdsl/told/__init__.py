"""What a player is told of a game, and what it is told at each step, in words.

The text is made of the typed rules, and each message of an agent's own token planes, so that nothing
hidden can be in it.
"""

from sjdsl.told.message import Past, message
from sjdsl.told.rules import told
from sjdsl.told.window import Window

__all__ = ["Past", "Window", "message", "told"]
