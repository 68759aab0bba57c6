"""Packages that only some calls need, and that are imported when they are needed."""

import importlib


def importExtra(module, purpose):
    """Import and return a module of a package that the package's core does without.

    Raises
    ------
    ImportError
        if it cannot be imported; the message says why it is needed, and how to install it
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        reason = f"{purpose} needs {package}, which cannot be imported ({error}): pip install {package}"
        raise ImportError(reason) from None
