"""Loading the plugin's libraries into OpenMM."""

from pathlib import Path

import openmm

from ._build import OPENMM_VERSION


def loadPlugin():
    """Check that the running OpenMM is the one that the plugin was built for, and load its kernels.

    Raises
    ------
    ImportError
        if OpenMM has another minor version: its classes then have another layout in memory
    """
    running = openmm.Platform.getOpenMMVersion()
    if _minor(running) != _minor(OPENMM_VERSION):
        raise ImportError(f"openmmchaintree was built for OpenMM {OPENMM_VERSION} and cannot run with OpenMM {running}")

    # The extension, not this file: in an editable install this file is in the source tree.
    from . import _openmmchaintree

    for library in sorted((Path(_openmmchaintree.__file__).parent / "lib" / "plugins").glob("*OpenMMChainTree*")):
        openmm.Platform.loadPluginLibrary(str(library))


def _minor(version):
    return version.split(".")[:2]
