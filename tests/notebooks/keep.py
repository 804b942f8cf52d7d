"""Runs the notebooks of examples/ and keeps what they print and show: `make notebooks`."""

import re

import nbformat

from tests.notebooks.test_notebooks import EXAMPLES, NOTEBOOKS, executed

TEMPORARY = re.compile(r"/tmp/\w+/")  # where a notebook writes: another folder each time


def main() -> None:
    for name in NOTEBOOKS:
        notebook = executed(name)
        notebook.metadata.pop("language_info", None)  # the version of this Python
        for cell in notebook.cells:
            cell.metadata.clear()
            for output in cell.get("outputs", ()):
                if output.output_type == "stream":
                    output.text = TEMPORARY.sub("", output.text)
        nbformat.write(notebook, EXAMPLES / f"{name}.ipynb")


if __name__ == "__main__":
    main()
