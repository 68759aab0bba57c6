"""The files of a release agree: its version, its notes, its citation, and the conda recipe."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]


@pytest.fixture
def copy(tmp_path):
    """A folder with a copy of the files that release notes are made from."""
    (tmp_path / ".ci").mkdir()
    for name in (".ci/release-notes", "CMakeLists.txt", "CHANGELOG.md"):
        shutil.copy(PROJECT / name, tmp_path / name)
    return tmp_path


def version():
    return re.search(r"VERSION ([0-9.]+)\n", (PROJECT / "CMakeLists.txt").read_text())[1]


def recipe():
    return (PROJECT / "conda" / "recipe.yaml").read_text()


def notes(folder, *arguments):
    return subprocess.run([folder / ".ci" / "release-notes", *arguments], capture_output=True, text=True)


def writeChangelog(folder, heading):
    (folder / "CHANGELOG.md").write_text(f"# Changelog\n\n{heading}\n\n- New.\n  More.\n\n## 0.1.0\n\n- Old.\n")


def test_filesHaveThisVersion():
    assert re.search(r"^version: (\S+)$", (PROJECT / "CITATION.cff").read_text(), re.MULTILINE)[1] == version()
    assert (
        re.search(r"^  version: (\S+)$", (PROJECT / "conda" / "recipe.yaml").read_text(), re.MULTILINE)[1] == version()
    )
    headings = re.findall(r"^## (.*)$", (PROJECT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert headings[0] in (version(), f"{version()} (unreleased)")


def test_notesAreTheSectionOfTheVersion(copy):
    writeChangelog(copy, f"## {version()}")
    result = notes(copy, version())
    assert (result.returncode, result.stdout) == (0, "- New.\n  More.\n")


def test_noNotesForAnotherVersion(copy):
    writeChangelog(copy, "## 9.9.9")
    result = notes(copy, "9.9.9")
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr == f"CMakeLists.txt has version {version()}, not 9.9.9\n"


@pytest.mark.parametrize("heading", ["## {} (unreleased)", "## 9.9.9", "## {}0"])
def test_noNotesWithoutASection(copy, heading):
    heading = heading.format(version())
    writeChangelog(copy, heading)
    result = notes(copy, version())
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr == f'CHANGELOG.md begins with "{heading}", not "## {version()}"\n'


def test_noNotesWithoutAVersion(copy):
    assert notes(copy).returncode == 2


def test_theCondaRecipeHasTheExtras():
    """conda has no extras, so that its package needs what [tools] needs."""
    listed = re.search(r"^tools = \[\n(.*?)^\]", (PROJECT / "pyproject.toml").read_text(), re.MULTILINE | re.DOTALL)[1]
    listed = {re.match("[a-z0-9-]+", text)[0] for text in re.findall('"(.*?)"', listed)}
    run = re.search(r"^  run:\n(.*?)^  run_constraints:", (PROJECT / "conda" / "recipe.yaml").read_text(), re.M | re.S)[
        1
    ]
    named = {{"matplotlib-base": "matplotlib", "msgpack-python": "msgpack"}.get(name, name) for name in run.split()}
    assert listed <= named
