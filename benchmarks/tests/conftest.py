"""What the tests of the benchmarks start from."""

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1]

# The benchmarks, and what tests of the package use.
sys.path[:0] = [str(BENCHMARKS), str(BENCHMARKS.parent / "python" / "tests")]

from commands import callMain  # noqa: E402


@pytest.fixture
def runHere(tmp_path, monkeypatch, capsys):
    """A function that runs the `main` of a benchmark here, in tmp_path, where no structures lie ready."""

    def run(main, *arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.delenv("CHAINTREE_TEST_DATA", raising=False)
        return callMain(main, arguments, capsys)

    return run


@pytest.fixture
def runQuickly(runHere, tmp_path):
    """A function that runs a `main` quickly with all outputs, and once more with --read: the outputs must be the same.

    It returns the machine, the entries and the tables in Markdown.
    """
    from report import readCSV

    def run(main, *arguments, picture=True):
        outputs = ["--markdown", "a.md", *(["--picture", "a.png"] if picture else [])]
        result = runHere(main, "--quick", *arguments, "--csv", "a.csv", *outputs)
        assert result.returncode == 0, result.stdout + result.stderr
        outputs = ["--markdown", "b.md", *(["--picture", "b.png"] if picture else [])]
        assert runHere(main, "--read", "a.csv", *outputs).returncode == 0
        for kind in ("md", "png") if picture else ("md",):
            first = (tmp_path / f"a.{kind}").read_bytes()
            assert first == (tmp_path / f"b.{kind}").read_bytes()
        assert not picture or first.startswith(b"\x89PNG")
        machine, entries = readCSV(tmp_path / "a.csv")
        for entry in entries:
            assert 0 <= entry["least"] <= entry["microseconds"] <= entry["most"]
        tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
        for table in tables:
            lines = [line for line in table.splitlines() if line.startswith("|")]
            assert len(lines) >= 3 and len({line.count("|") for line in lines}) == 1
            assert f"\n{table[: table.index('*')]}" in result.stdout
        return machine, entries, tables

    return run
