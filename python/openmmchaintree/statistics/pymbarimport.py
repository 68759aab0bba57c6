"""Imports pymbar when it is needed, without its messages."""

import logging

from ..extras import importExtra

_PURPOSE = "estimating errors of means"


def timeseries():
    """Return the module pymbar.timeseries.

    Raises
    ------
    ImportError
        if pymbar is missing; the message says how to install it
    """
    logging.getLogger("pymbar").setLevel(logging.ERROR)  # it advertises JAX
    return importExtra("pymbar.timeseries", _PURPOSE)
