"""Packages that only some calls need: they are imported late, and an error says which extra has them."""

import importlib

_EXTRAS = {"dask": "cluster", "rdkit": "poses", "distributed": "cluster", "jinja2": "report", "molstar_cli": "report"}


def importExtra(module, purpose, raising=ImportError):
    """Import and return a module of a package that the core does not need.

    Raises
    ------
    ImportError, or the exception class `raising`
        if it cannot be imported; the message says why it is needed, and how to install it
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise raising(adviceOn(module, purpose, error)) from None


def adviceOn(module, purpose, error):
    """Return the sentence that says why a module is needed, why it cannot be imported, and how to install it."""
    package = module.partition(".")[0]
    extra = _EXTRAS.get(package, "tools")
    return f"{purpose} needs {package}, which cannot be imported ({error}): pip install 'openmm-chaintree[{extra}]'"
