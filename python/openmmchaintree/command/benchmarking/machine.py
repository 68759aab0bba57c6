"""The machine and the versions that times belong to."""

import importlib.metadata
import os
import platform
from pathlib import Path

import openmm

_PACKAGES = ("openmm-chaintree", "numpy", "scipy", "python-fcl")


def describeMachine():
    """Return the machine and versions as a dictionary for JSON."""
    return {
        "processor": _processorModel(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "versions": {
            **{name: _version(name) for name in _PACKAGES},
            "openmm": openmm.Platform.getOpenMMVersion(),
            "python": platform.python_version(),
        },
    }


def _processorModel():
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def _version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
