"""The dependencies of the package, asked for by scikit-build-core when it writes the metadata."""

from importlib.metadata import PackageNotFoundError, version


def dynamic_metadata(field, settings):
    """Return the list `others` of the settings, and the OpenMM that is there to build on.

    A binary made for one minor version of OpenMM crashes with another, so it is bound to that one.
    """
    try:
        major, minor = map(int, version("openmm").split(".")[:2])
    except PackageNotFoundError:
        raise RuntimeError("openmm-chaintree cannot be built without the Python package openmm: install it") from None
    return [f"openmm>={major}.{minor},<{major}.{minor + 1}", *settings["others"]]
