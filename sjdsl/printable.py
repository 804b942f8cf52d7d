"""Text of others that is printed: of a file, or of a language model."""


def printable(text: str, lines: bool = False) -> str:
    """Returns a text with escape codes for characters that aren't printable.

    Such characters might control the terminal, and a line break might forge a line of ours.

    Args:
      lines: whether line breaks stay.
    """
    return "".join(
        character
        if character.isprintable() or (lines and character == "\n")
        else ascii(character)[1:-1]
        for character in text
    )
