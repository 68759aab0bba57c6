"""Loading the plugin's libraries into OpenMM; if that fails, one sentence says what to install."""

import os
import sys
from contextlib import ExitStack
from pathlib import Path

try:
    from ._build import OPENMM_VERSION, SWIG_RUNTIME
except ModuleNotFoundError:
    raise ImportError(
        f"openmmchaintree in {Path(__file__).parent} has no compiled part: install it (pip install . in its source)"
    ) from None


def loadPlugin():
    """Check that the running OpenMM is the one that the plugin was built for, and load its kernels.

    Raises
    ------
    ImportError
        if OpenMM cannot be imported, if it has another minor version (its classes then have another layout in memory)
        or another SWIG runtime (it would not recognize this package's classes), or if a library is missing or does not
        load
    """
    built = ".".join(_minor(OPENMM_VERSION))
    install = f'pip install "openmm=={built}.*"'
    try:
        import openmm
    except ImportError as error:
        raise ImportError(
            f"openmmchaintree needs OpenMM {built}, which cannot be imported ({error}): {install}"
        ) from None
    running = openmm.Platform.getOpenMMVersion()
    if _minor(running) != _minor(OPENMM_VERSION):
        raise ImportError(
            f"openmmchaintree was built for OpenMM {built} and cannot run with OpenMM {running}: {install}, "
            "or build openmm-chaintree from source for another OpenMM (8.4 or newer)"
        )
    if f"swig_runtime_data{SWIG_RUNTIME}" not in sys.modules:
        raise ImportError(
            f"openmmchaintree was built with SWIG runtime {SWIG_RUNTIME}, which the OpenMM in "
            f"{Path(openmm.__file__).parent} does not use: {install}, "
            "or build openmm-chaintree from source for that OpenMM"
        )

    reinstall = f"install openmm-chaintree again, beside OpenMM {built}"
    try:
        with ExitStack() as folders:
            if sys.platform == "win32":  # libraries there do not say where the others are
                for folder in (openmm.version.openmm_library_path, Path(__file__).parent / "lib"):
                    folders.enter_context(os.add_dll_directory(str(folder)))
            from . import _openmmchaintree  # noqa: F401
    except ImportError as error:
        raise ImportError(f"openmmchaintree cannot load its libraries ({error}): {reinstall}") from None
    folder = compiledFolder() / "lib" / "plugins"
    libraries = sorted(file for file in folder.glob("*OpenMMChainTree*") if file.suffix != ".lib")
    if not libraries:
        raise ImportError(f"openmmchaintree has no plugin library in {folder}: {reinstall}")
    for library in libraries:
        try:
            openmm.Platform.loadPluginLibrary(str(library))
        except openmm.OpenMMException as error:
            raise ImportError(f"openmmchaintree cannot load its plugin library ({error}): {reinstall}") from None


def compiledFolder():
    """Return the folder of compiled files, which in an editable install is not the folder of this file."""
    from . import _openmmchaintree

    return Path(_openmmchaintree.__file__).parent


def _minor(version):
    return version.split(".")[:2]
