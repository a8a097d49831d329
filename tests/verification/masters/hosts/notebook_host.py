"""Makes FMPy's notebook of an FMU and executes it: a simulation with all start values, and a plot; argument:
the FMU."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
from fmpy.util import create_jupyter_notebook
from nbclient import NotebookClient

PATIENCE = 250  # s, for one cell

with TemporaryDirectory() as folder:
    path = Path(folder, "notebook.ipynb")
    create_jupyter_notebook(sys.argv[1], str(path))
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=PATIENCE, kernel_name="python3").execute()
plots = [output for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
if len(plots) != 1:
    raise SystemExit(f"error: {len(plots)} plots in the notebook, not 1")
