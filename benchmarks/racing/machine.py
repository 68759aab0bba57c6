"""What times belong to: the machine, the compiler, the commit, the versions, the load."""

import datetime
import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path

import openmm

_PACKAGES = ("numpy", "scipy", "python-fcl")
_CLONE = Path(__file__).parents[2]


def describeMachine(program):
    """Return what a run begins with, as a dictionary of texts by their names."""
    versions = {"python": platform.python_version(), "openmm": openmm.Platform.getOpenMMVersion()}
    versions.update({name: _version(name) for name in _PACKAGES})
    return {
        "processor": f"{_processorModel()}, {os.cpu_count()} cores",
        "system": platform.platform(),
        "compiler": program.describeBuild(),
        "commit": _commit(),
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items() if version is not None),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "load at begin": describeLoad(),
    }


def describeLoad():
    """Return the load averages over 1, 5 and 15 minutes."""
    return ", ".join(f"{load:.2f}" for load in os.getloadavg())


def _processorModel():
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def _commit():
    commit = _git("rev-parse", "--short=12", "HEAD")
    if not commit:
        return "unknown"
    return f"{commit} (dirty)" if _git("status", "--porcelain") else commit


def _git(*words):
    try:
        return subprocess.run(["git", "-C", _CLONE, *words], capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def _version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
