"""The formatter: one layout of a `.sj` text with the same tokens and comments, and other spaces and line ends."""

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import read_tree
from sjdsl.files import line_end
from sjdsl.format.layout import lay_out
from sjdsl.format.lines import render
from sjdsl.format.structure import read_structure
from sjdsl.format.tokens import Tokens, read_gaps


def format_source(source: Source) -> str:
    """Returns the text of a file as it should be laid out: at most 140 columns, ended by one line end, of the sort that the file has.

    A line is longer only where it holds nothing that can be broken. Formatting the result changes nothing.
    Raises CompileError with every syntax error of the file.
    """
    tokens, tree = read_tree(source)
    text = render(
        lay_out(Tokens(tokens, read_structure(tokens, tree), read_gaps(source.text, tokens)))
    )
    text = text.replace("\n", line_end(source.text))
    assert read_tree(Source(source.name, text))[0] == tokens, (
        "formatting changed the words of the file"
    )
    return text
