"""The settings of a run as TOML: written by each run, and read by --config."""

import sys

import numpy as np
import pytest
from commands import assertRefused, filesIn
from openmmchaintree.command.config import asTOML
from scenes import GLYCINES, readDCD, writePDB

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writePDB(tmp_path / "run.pdb", GLYCINES)
    return lambda *arguments: runCommandHere("sample", *arguments)


def settingsIn(path):
    with open(path, "rb") as file:
        content = tomllib.load(file)
    assert [*content] == ["sample"]
    return content["sample"]


def test_aRunIsRepeated(runHere, tmp_path):
    options = ("--trials", 300, "--frames", 3, "--torsions", "phi,psi", "--move", "resid 0 to 1", "--cut-disulfides")
    assert runHere("run.pdb", *options, "--json", "a.json").returncode == 0
    settings = settingsIn(tmp_path / "run-settings.toml")
    assert 1 <= settings["seed"] < 2**31  # drawn, and written all the same
    del settings["seed"]
    assert settings == {
        "structure": "run.pdb",
        "model": 0,
        "trials": 300,
        "frames": 3,
        "torsions": ["phi", "psi"],
        "move": "resid 0 to 1",
        "cut-disulfides": True,
        "json": "a.json",
    }
    assert runHere("--config", "run-settings.toml", "-o", "again", "--json", "b.json").returncode == 0
    assert np.array_equal(readDCD(tmp_path / "run.dcd"), readDCD(tmp_path / "again.dcd"))
    changed = settingsIn(tmp_path / "again-settings.toml")
    assert changed.pop("output") == "again" and changed.pop("json") == "b.json"
    del settings["json"]
    assert changed.pop("seed") == settingsIn(tmp_path / "run-settings.toml")["seed"] and changed == settings


def test_inPlace(runHere, tmp_path):
    """Repeated with --overwrite, a run leaves the file that it is repeated by as it is."""
    assert runHere("run.pdb", "--trials", 50).returncode == 0
    path = tmp_path / "run-settings.toml"
    path.write_text("# mine\n" + path.read_text())
    before = path.read_text()
    result = runHere("--config", "run-settings.toml", "--overwrite")
    assert result.returncode == 0, result.stderr
    assert path.read_text() == before
    files = filesIn(tmp_path)
    result = runHere("--config", "run-settings.toml", "--overwrite", "--trials", 60)
    assertRefused(result, tmp_path, files, "run-settings.toml: would overwrite a file that is read")


def test_optionsComeFirst(runHere, tmp_path):
    writePDB(tmp_path / "other.pdb", GLYCINES)
    (tmp_path / "c.toml").write_text('[sample]\nstructure = "run.pdb"\ntrials = 50\nframes = 2\nseed = 4\n')
    assert runHere("--config", "c.toml", "--trials", 70, "other.pdb").returncode == 0
    settings = settingsIn(tmp_path / "other-settings.toml")
    assert (settings["structure"], settings["trials"], settings["frames"], settings["seed"]) == ("other.pdb", 70, 2, 4)
    assert len(readDCD(tmp_path / "other.dcd")) == 3


def test_listsEndBeforeTheStructure(runHere, tmp_path):
    (tmp_path / "c.toml").write_text('[sample]\ntrials = 5\nforcefield = ["amber14/protein.ff14SB.xml"]\n')
    result = runHere("--config", "c.toml", "run.pdb")
    assert result.returncode == 2 and "run.pdb: --forcefield" in result.stderr  # glycines without hydrogens


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "c.toml: cannot be read (No such file or directory)"),
        ("[sample", "c.toml: is not TOML"),
        (b"\xff\xfe", "c.toml: is not TOML"),
        ("", "c.toml: settings stand in one table [sample]"),
        ("trials = 5", "c.toml: settings stand in one table [sample], but there is trials"),
        ("sample = 5", "c.toml: settings stand in one table [sample]"),
        ("[sample]\n[other]", "c.toml: settings stand in one table [sample], but there is other"),
        ("[sample]\ntrails = 5", "c.toml: trails is not a setting of this command"),
        ("[sample]\noverwrite = true", "c.toml: overwrite is not a setting of this command"),
        ("[sample]\ntrials = true", "c.toml: trials must be a value, not true or false"),
        ("[sample]\nrigid-bodies = 1", "c.toml: rigid-bodies must be true or false"),
        ("[sample]\ntrials = 1979-05-27", "c.toml: trials must be a text, a number or a list of these"),
        ('[sample]\noutput = "a\\u0000"', "c.toml: output has a character that no argument may have, NUL"),
        ("[sample]\nforcefield = []", "c.toml: forcefield must be a text, a number or a list of these"),
        ("[sample]\ntrials = 0", "c.toml: trials: 0 is not in the range"),
        ("[sample]\ntrials = 1.5", "c.toml: trials: '1.5' is not a whole number"),
        ("[sample]\ntrials = [[5]]", "c.toml: trials must be a text, a number or a list of these"),
        ("[sample]\nforcefield = [true]", "c.toml: forcefield must be a text, a number or a list of these"),
        ("[sample]\ntrials = " + 5000 * "9", "c.toml: is not TOML (Exceeds the limit"),
        ("[sample]\ntrials = " + 1000 * "[" + 1000 * "]", "c.toml: is not TOML of settings (lists or tables within"),
        ("[sample]\n" + 50000 * "a." + "a = 5", "c.toml: is not TOML of settings (lists or tables within"),
        ("[sample." + 1000 * "'a'." + "a]", "c.toml: is not TOML of settings (lists or tables within"),
        ("#" * 1000001, "c.toml: settings take at most 1,000,000 bytes"),
        ('[sample]\nconfig = "c.toml"', "c.toml: config is not a setting of this command"),
        ('[sample]\nscheduler = "tcp://127.0.0.1:1"', "c.toml: scheduler is not a setting of this command"),
        ("[sample]\nover = true", "c.toml: over is not a setting of this command"),
        ("[sample.sample]\ntrials = 5", "c.toml: sample is not a setting of this command"),
        ('[sample]\ntrajectories = "--overwrite"', "c.toml: trajectories: invalid choice: '--overwrite'"),
        ('[sample]\ntorsions = ["phi", "pi"]', "c.toml: torsions: 'pi' is not one of"),
        ('[sample]\nmove = "--fix"', "--move: "),
        ('[sample]\nstructure = "missing.pdb"', "missing.pdb: there is no such file; names in c.toml are relative"),
    ],
)
def test_badSettings(runHere, tmp_path, content, words):
    if content is not None:
        (tmp_path / "c.toml").write_bytes(content if isinstance(content, bytes) else content.encode())
    files = filesIn(tmp_path)
    assertRefused(runHere("--config", "c.toml"), tmp_path, files, words)


def test_outputsAreNotTheSettings(runHere, tmp_path):
    (tmp_path / "c.json").write_text("[sample]\ntrials = 5\n")
    files = filesIn(tmp_path)
    result = runHere("run.pdb", "--config", "c.json", "--json", "c.json", "--overwrite")
    assertRefused(result, tmp_path, files, "c.json: would overwrite a file that is read")


@pytest.mark.parametrize(
    "name", ["structure", "move", "json", "forcefield", "torsions", "trials", "temperatures", "trajectories", "model"]
)
def test_valuesAreData(runHere, tmp_path, name):
    """Whatever they look like: none becomes an option, and nothing is overwritten."""
    mine = tmp_path / "mine-topology.pdb"
    mine.write_text("mine")
    for value in ("--overwrite", "--overwr", "-h", "--", "--config", "--scheduler=tcp:", "@c.toml"):
        settings = {"structure": "run.pdb", "trials": 5, "output": "mine", name: value}
        for content in (settings, settings | {name: [value]}, settings | {name: [value, value]}):
            (tmp_path / "c.toml").write_text(asTOML(content))
            result = runHere("--config", "c.toml")
            assertRefused(result, tmp_path, ["c.toml", mine.name, "run.pdb"])
            assert name in result.stderr or mine.name in result.stderr
            assert mine.read_text() == "mine"


def test_aNameLikeAnOption(runHere, tmp_path):
    (tmp_path / "c.toml").write_text('[sample]\nstructure = "run.pdb"\ntrials = 5\noutput = "--overwrite"\n')
    assert runHere("--config", "c.toml").returncode == 0
    settings = settingsIn(tmp_path / "--overwrite-settings.toml")
    assert settings["output"] == "--overwrite" and (tmp_path / "--overwrite.dcd").exists()


def test_abbreviatedOptions(runHere, tmp_path):
    (tmp_path / "c.toml").write_text('[sample]\ntrials = 7\nstructure = "run.pdb"\n')
    assert runHere("--conf", "c.toml", "--mod", 0, "--frames", 1).returncode == 0
    settings = settingsIn(tmp_path / "run-settings.toml")
    assert settings["trials"] == 7 and settings["frames"] == 1
