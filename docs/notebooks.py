"""Execute the handbook's notebooks again: ``python -m docs.notebooks [FOLDER]``, in their places by default.

What they show is kept, so that they are read without running; `tests/docs/test_notebooks.py` executes them
and compares what they print.
"""

import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parent / "notebooks"
TIMEOUT = 600
"""s, longest that a cell may take."""


def executed(path: Path) -> nbformat.NotebookNode:
    """Notebook with the outputs of its cells, run in an empty folder.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell fails.
    """
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(
            notebook, timeout=TIMEOUT, kernel_name="python3", resources={"metadata": {"path": folder}}
        )
        client.execute()
    for cell in notebook.cells:
        # when something ran is no part of what it shows
        cell.metadata.pop("execution", None)
    notebook.metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python"},
    }
    return notebook


def main() -> None:
    """Execute all notebooks."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else NOTEBOOKS
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        nbformat.write(executed(path), folder / path.name)
        print(folder / path.name)


if __name__ == "__main__":
    main()
