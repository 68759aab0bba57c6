"""Checkpoints of runs that somebody else has made up: one line, and nothing is written."""

import copy
import json
import shutil
import zipfile
from hashlib import sha256

import commands
import pytest
from commands import assertRefused, filesIn
from openmmchaintree.replicas import checkpointfile
from scenes import GLYCINES, writePDB

ODD = (None, True, -1, 1.5, 10**30, float("nan"), "", "--overwrite", [[]], {"a": 1})


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A folder with a run that has come to its end, and a file of the user's."""
    folder = tmp_path_factory.mktemp("finished")
    writePDB(folder / "run.pdb", GLYCINES)
    options = ("--replicas", 2, "--trials", 30, "--frames", 3, "--seed", 1, "--json", "a.json", "--workers", 1)
    assert commands.run("sample", "run.pdb", *options, folder=folder).returncode == 0
    (folder / "mine.json").write_text("mine")
    return folder


@pytest.fixture
def run(finished, runCommandHere, tmp_path):
    shutil.copytree(finished, tmp_path, dirs_exist_ok=True)
    return lambda *arguments: runCommandHere("sample", "--resume", "run.checkpoint", *arguments)


def places(value, path=()):
    """Yield the path of each value within dictionaries and lists: of long lists only of the first one."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value[:1]) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


def changed(header, path, *value):
    """Return a copy of a header with another value at a path, or without it."""
    if not path:
        return value[0] if value else {}
    result = copy.deepcopy(header)
    owner = result
    for key in path[:-1]:
        owner = owner[key]
    if value:
        owner[path[-1]] = value[0]
    else:
        del owner[path[-1]]
    return result


def craft(path, header, checkpoints):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("run.json", header if isinstance(header, (str, bytes)) else json.dumps(header))
        for replica, checkpoint in checkpoints.items():
            archive.writestr(str(replica), checkpoint)


def test_anyValue(run, tmp_path, monkeypatch):
    """Each value is missing, or another one: the run is refused in a line, or what was changed does not matter."""
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    before = {name: (tmp_path / name).read_bytes() for name in filesIn(tmp_path) if name != path.name}
    accepted = set()
    for place in places(header):
        for value in ((), *((odd,) for odd in ODD)):
            craft(path, changed(header, place, *value), checkpoints)
            crafted = path.read_bytes()
            monkeypatch.setattr(
                "openmmchaintree.command.sample.Sampling", None
            )  # takes long; not reached, or not called
            try:
                result = run()
            except TypeError as error:
                assert "'NoneType' object is not callable" in str(error)
                accepted.add(place)
                continue
            finally:
                monkeypatch.undo()
                monkeypatch.chdir(tmp_path)
            assert result.returncode == 2 and len(result.stderr.splitlines()) == 1, (place, value, result.stderr)
            assert path.read_bytes() == crafted
    for name, content in before.items():
        assert (tmp_path / name).read_bytes() == content
    assert filesIn(tmp_path) == sorted([*before, path.name])
    assert {place[0] for place in accepted if place} <= {
        *("state", "settings", "index", "reports", "madeBy", "model", "digests")
    }


STATE = [
    *(("round",), ("temperatureOf",), ("temperatureOf", 0), ("wasHotLast",), ("roundTrips",), ("attempted",)),
    *(("counts",), ("counts", 0), ("counts", 0, 0, 0), ("countsOfReplica",), ("outerTests",), ("outerTests", 0)),
    *(("seconds",), ("wallSeconds",)),
]


@pytest.mark.parametrize("place", STATE)
def test_states(run, tmp_path, place):
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    for value in (-1, 10**30, "x", [-1], {}):
        craft(path, changed(header, ("state", *place), value), checkpoints)
        files = filesIn(tmp_path)
        words = "run.checkpoint: is not a checkpoint of this command: state.", "is missing"
        assertRefused(run(), tmp_path, files, *words)


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("model",), "0" * 64, "run.checkpoint: is of a run from another structure"),
        (("index",), [0, 0], "run-index.csv: is not the index that the run has written"),
        (("index",), [10**15, 5], "run-index.csv: is not the index that the run has written"),
        (
            ("settings", "output"),
            "../run",
            "--resume run.checkpoint: the run writes its checkpoints to ../run.checkpoint",
        ),
        (("settings", "json"), "/dev/shm/a.json", "run.checkpoint: json /dev/shm/a.json is outside of its folder"),
        (("settings", "notes"), "../a.txt", "run.checkpoint: notes ../a.txt is outside of its folder"),
        (
            ("settings", "replicas"),
            10**9,
            "replicas: 1000000000 is more than 10,000; the environment variable CHAINTREE_MAX_REPLICAS raises",
        ),
        (("settings", "trials"), 10**15, "run-index.csv: is not the index that the run has written"),
        (("temporary",), "../mine.json", "temporary is missing or wrong in it"),
        (("settings", "scheduler"), "tcp://127.0.0.1:1", "scheduler is not a setting of this command"),
    ],
)
def test_wrong(run, tmp_path, place, value, words):
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    if place[-1] == "trials":
        header["settings"]["frames"] = 10**9
    craft(path, changed(header, place, value), checkpoints)
    before = {name: (tmp_path / name).read_bytes() for name in filesIn(tmp_path)}
    assertRefused(run(), tmp_path, sorted(before), words)
    assert before == {name: (tmp_path / name).read_bytes() for name in before}


def test_theRunsReports(run, tmp_path):
    """Files that a checkpoint claims to have written are not overwritten elsewhere."""
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "their.json").write_text("theirs")
    header["reports"] = [sha256(b"theirs").hexdigest()]
    header["settings"]["json"] = "inner/their.json"
    craft(path, header, checkpoints)
    assertRefused(run(), tmp_path, filesIn(tmp_path), "outside of its folder; give --json once more to write there")
    assert (tmp_path / "inner" / "their.json").read_text() == "theirs"


@pytest.mark.parametrize(
    "text",
    ["", "[]", "5", "null", "[" * 100000, '{"version": 2}', '{"version": 2, "digests": []}', b"\xff", "9" * 5000],
)
def test_noHeader(run, tmp_path, text):
    craft(tmp_path / "run.checkpoint", text, {})
    assertRefused(run(), tmp_path, filesIn(tmp_path), "run.checkpoint: is ")


def test_replicas(run, tmp_path):
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    for names in (["0"], ["0", "1", "2"], ["0", "-1"], ["0", "01"], ["0", "x"], ["0", "run.json"]):
        held = {name: checkpoints.get(int(name) if name.isdigit() else 0, b"") for name in names if name != "run.json"}
        digests = {name: sha256(content).hexdigest() for name, content in held.items()}
        craft(path, {**header, "digests": digests if "run.json" not in names else {"run.json": "0" * 64}}, held)
        assertRefused(run(), tmp_path, filesIn(tmp_path), "run.checkpoint: is not a checkpoint of this command")


def test_aBomb(run, tmp_path, monkeypatch):
    monkeypatch.setenv("CHAINTREE_MAX_MEGABYTES", "1")
    with zipfile.ZipFile(tmp_path / "run.checkpoint", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("run.json", b" " * 2000000)
    assertRefused(run(), tmp_path, filesIn(tmp_path), "run.checkpoint: holds, decompressed, more than 1 MB")
