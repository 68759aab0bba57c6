"""Replicas and clashes by the workers of a Dask scheduler: real processes, some of which are killed."""

import json
import os
import socket
import subprocess
import sys
import time
from contextlib import suppress
from threading import Thread

import pytest
from commands import assertRefused, filesIn, run
from openmm import app, unit
from openmmchaintree.command.outputs.replicafiles import ReplicaFiles
from openmmchaintree.replicas import cluster
from scenes import writeDCD, writeSmallStructures
from test_replicas import PROTEIN, contents

distributed = pytest.importorskip("distributed")

OPTIONS = ("run.pdb", "--replicas", 3, "--trials", 120000, "--frames", 12, "--seed", 3, "--checkpoint-interval", 0)


class Dask:
    """A scheduler and its workers, processes of this machine. As a context manager it ends them."""

    def __init__(self, folder, workers=2, port=0):
        self._folder = folder
        self._file = folder / "scheduler.json"
        self._file.unlink(missing_ok=True)
        self.workers = []
        where = ("--host", "127.0.0.1", "--port", port, "--no-dashboard", "--scheduler-file", self._file)
        self.scheduler = self._start("scheduler", *where)
        self.address = self._waitForAddress()
        for _ in range(workers):
            self.addWorker()
        self.waitForWorkers(workers)

    def addWorker(self, **environment):
        where = (self.address, "--host", "127.0.0.1", "--no-dashboard", "--no-nanny", "--nthreads", 1)
        self.workers.append(self._start("worker", *where, "--local-directory", self._folder, **environment))
        return self.workers[-1]

    def waitForWorkers(self, count):
        with distributed.Client(self.address, set_as_default=False) as client:
            while len(client.scheduler_info(n_workers=-1)["workers"]) != count:
                time.sleep(0.05)

    def _start(self, kind, *arguments, **environment):
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *map(str, arguments)]
        return subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, **environment}
        )

    def _waitForAddress(self):
        while True:
            assert self.scheduler.poll() is None
            with suppress(FileNotFoundError, ValueError):
                return json.loads(self._file.read_text())["address"]
            time.sleep(0.05)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    with Dask(tmp_path_factory.mktemp("dask")) as dask:
        yield dask


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return runCommandHere


@pytest.fixture
def whole(runHere, tmp_path):
    """What a run on this machine writes."""
    if not WHOLE:
        assert runHere("sample", *OPTIONS, "-o", "whole").returncode == 0
        WHOLE.update(contents(tmp_path, "whole"))
    return WHOLE


WHOLE = {}


def doAfter(monkeypatch, frames, act):
    """Do something once a run has `frames` frames."""
    honest = ReplicaFiles.add

    def add(files, *arguments):
        nonlocal frames
        frames -= 1
        if frames == 0:
            act()
        honest(files, *arguments)

    monkeypatch.setattr(ReplicaFiles, "add", add)


def kill(process):
    process.kill()
    process.wait()


def test_replicas(dask, runHere, tmp_path, whole):
    result = runHere("sample", *OPTIONS, "-o", "run", "--scheduler", dask.address, "--json", "a.json")
    assert result.returncode == 0 and result.stderr == ""
    assert contents(tmp_path, "run") == whole
    assert f"replicas: 3 by 2 workers of {dask.address}" in result.stdout
    assert "scheduler" not in (tmp_path / "run-settings.toml").read_text()


def test_exchange(dask, runHere, tmp_path):
    options = ("dipeptide.pdb", "--temperatures", "300:500:3", "--forcefield", PROTEIN, "--trials", 2400)
    options += ("--trials-per-exchange", 400, "--frames", 6, "--seed", 3)
    assert runHere("sample", *options, "-o", "whole").returncode == 0
    result = runHere("sample", *options, "-o", "run", "--scheduler", dask.address)
    assert result.returncode == 0, result.stderr
    assert len(contents(tmp_path, "run")) == 4 and contents(tmp_path, "run") == contents(tmp_path, "whole")


def test_clashes(dask, runHere, tmp_path, villin):
    """Of a trajectory that is damaged at its end, so that all that a search can say has come over the wire."""
    with open(tmp_path / "villin.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    writeDCD(tmp_path / "villin", villin.topology, [(1 - 0.02 * frame) * villin.positions for frame in range(9)])
    path = tmp_path / "villin.dcd"
    path.write_bytes(path.read_bytes()[:-5])
    found = []
    for options in ([], ["--scheduler", dask.address]):
        result = runHere("clashes", "villin.pdb", "villin.dcd", "--json", "a.json", "--overwrite", *options)
        assert result.returncode == 2 and "villin.dcd: frame 8 (from 0) is cut off; the results" in result.stderr
        found.append((result.stdout, result.stderr, (tmp_path / "a.json").read_bytes()))
    assert found[0] == found[1] and "8 frames" in found[0][0]


def test_aWorkerIsKilled(dask, runHere, tmp_path, whole, monkeypatch):
    """Right after it got something to do that only it was to do: another one does it."""
    dask.addWorker()
    dask.waitForWorkers(3)
    with distributed.Client(dask.address, set_as_default=False) as client:
        pids = client.run(os.getpid)
    honest, killed = cluster.Cluster.submit, []

    def submit(cluster, *arguments, worker=None, **options):
        task = honest(cluster, *arguments, worker=worker, **options)
        if worker is not None and not killed:
            killed.extend(process for process in dask.workers if process.pid == pids[worker])
            kill(killed[0])
        return task

    monkeypatch.setattr(cluster.Cluster, "submit", submit)
    result = runHere("sample", *OPTIONS, "-o", "run", "--scheduler", dask.address)
    assert result.returncode == 0, result.stderr
    assert len(killed) == 1 and f"by 3 workers of {dask.address}" in result.stdout
    assert contents(tmp_path, "run") == whole


def test_theSchedulerIsRestarted(runHere, tmp_path_factory, tmp_path, whole, monkeypatch):
    """The run ends with one line, and continues from its checkpoint with the workers present then."""
    folder = tmp_path_factory.mktemp("restarted")
    with Dask(folder, workers=1) as first, monkeypatch.context() as patches:
        doAfter(patches, 20, lambda: kill(first.scheduler))
        result = runHere("sample", *OPTIONS, "-o", "run", "--scheduler", first.address)
        assert result.returncode == 2 and len(result.stderr.splitlines()) == 1
        assert f"--scheduler {first.address}: was lost, or restarted; --resume" in result.stderr
        assert result.stderr.endswith("--resume run.checkpoint continues the run from its last checkpoint\n")
        assert contents(tmp_path, "run") != whole
    with Dask(folder, workers=1, port=int(first.address.rsplit(":")[-1])) as second:
        assert second.address == first.address
        result = runHere("sample", "--resume", "run.checkpoint", "--scheduler", second.address)
        assert result.returncode == 0, result.stderr
    assert contents(tmp_path, "run") == whole


# ---- What cannot work: one line ----


@pytest.mark.parametrize("command", [("sample", *OPTIONS), ("clashes", "run.pdb")])
def test_noScheduler(runHere, tmp_path, monkeypatch, command):
    monkeypatch.setattr(cluster, "_CONNECT_SECONDS", 0.2)
    files = filesIn(tmp_path)
    for address, words in (("tcp://127.0.0.1:1", "cannot be reached"), ("what://x:1", "cannot be reached")):
        result = runHere(*command, "--scheduler", address)
        assertRefused(result, tmp_path, files, f"--scheduler {address}: {words}")


@pytest.mark.parametrize("address", ["localhost", "tls://127.0.0.1:1"])
def test_noAddress(tmp_path, address):
    """One line, and the process ends: without a port, without the keys of a scheduler that has some."""
    writeSmallStructures(tmp_path)
    files = filesIn(tmp_path)
    result = run("sample", *OPTIONS, "--scheduler", address, folder=tmp_path)
    assertRefused(result, tmp_path, files, f"--scheduler {address}: cannot be reached")


def test_noSchedulerButAnother(runHere, tmp_path, monkeypatch):
    """A server that answers, but as a page of the web."""
    monkeypatch.setattr(cluster, "_CONNECT_SECONDS", 0.2)
    monkeypatch.setattr(cluster, "_ANSWER_SECONDS", 0.5)
    files = filesIn(tmp_path)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer():
            server.accept()[0].sendall(b"HTTP/1.0 400 Bad Request\r\n\r\n")

        Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        result = runHere("sample", *OPTIONS, "--scheduler", address)
    words = f"--scheduler {address}: cannot be reached (the program at this address is not a scheduler)"
    assertRefused(result, tmp_path, files, words)


def test_anotherVersion(dask, runHere, tmp_path, tmp_path_factory):
    folder = tmp_path_factory.mktemp("other")
    (folder / "openmmchaintree").mkdir()
    (folder / "openmmchaintree" / "__init__.py").write_text("__version__ = '0.0.9'\n")
    other = dask.addWorker(PYTHONPATH=os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]))
    dask.waitForWorkers(3)
    files = filesIn(tmp_path)
    for command in (("sample", *OPTIONS), ("clashes", "run.pdb")):
        result = runHere(*command, "--scheduler", dask.address)
        assertRefused(result, tmp_path, files, "worker tcp://127.0.0.1:", "has openmm-chaintree 0.0.9, but here is")
    kill(other)
    dask.waitForWorkers(2)


def test_noWorkers(runHere, tmp_path, tmp_path_factory):
    files = filesIn(tmp_path)
    with Dask(tmp_path_factory.mktemp("empty"), workers=0) as dask:
        result = runHere("sample", *OPTIONS, "--scheduler", dask.address)
    assertRefused(result, tmp_path, files, f"--scheduler {dask.address}: there are no workers")


def test_noDask(runHere, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    files = filesIn(tmp_path)
    result = runHere("sample", *OPTIONS, "--scheduler", "tcp://127.0.0.1:1")
    advice = "pip install 'openmm-chaintree[cluster]'"
    assertRefused(result, tmp_path, files, "--scheduler needs distributed, which cannot be imported", advice)


def test_schedulerNeedsReplicas(runHere, tmp_path):
    files = filesIn(tmp_path)
    result = runHere("sample", "run.pdb", "--scheduler", "tcp://127.0.0.1:1")
    assertRefused(result, tmp_path, files, "--scheduler needs --replicas or --temperatures")
    result = runHere("sample", *OPTIONS, "--workers", 2, "--scheduler", "tcp://127.0.0.1:1")
    assertRefused(result, tmp_path, files, "--workers and --scheduler cannot be used together")
