"""The formatter: changes the spaces and line ends of a `.sj` text, not its tokens and comments."""

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import read_tree
from sjdsl.files import line_end
from sjdsl.format.layout import lay_out
from sjdsl.format.lines import render
from sjdsl.format.structure import read_structure
from sjdsl.format.tokens import Tokens, read_gaps


def format_source(source: Source) -> str:
    """Returns a formatted text of at most 140 columns, which ends with one line end.

    Line ends are those of the file. A line is longer only if nothing in it can be broken.
    Formatting the result again changes nothing.

    Raises:
      CompileError: with every syntax error of the file.
    """
    tokens, tree = read_tree(source)
    structure = read_structure(tokens, tree)
    lines = lay_out(Tokens(tokens, structure, read_gaps(source.text, tokens)))
    text = render(lines).replace("\n", line_end(source.text))
    formatted_tokens, _ = read_tree(Source(source.name, text))
    assert formatted_tokens == tokens, "formatting changed the tokens of the file"
    return text
