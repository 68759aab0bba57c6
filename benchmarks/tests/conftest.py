"""What the tests of the scripts start from."""

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1]

# The scripts with their modules, and what tests of the package's own commands use.
sys.path[:0] = [str(BENCHMARKS), str(BENCHMARKS.parent / "python" / "tests")]

from commands import callMain  # noqa: E402


@pytest.fixture
def runScriptHere(tmp_path, monkeypatch, capsys):
    """A function that runs a script's `main` within this process, in tmp_path, where no structures lie ready."""

    def run(main, *arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.delenv("CHAINTREE_TEST_DATA", raising=False)
        return callMain(main, arguments, capsys)

    return run
