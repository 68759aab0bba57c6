"""Imports pymbar when it is needed, without its messages."""

import logging

from ..extras import importExtra

_PURPOSE = "estimating errors of means"


def timeseries():
    """Return the module pymbar.timeseries; without pymbar, an ImportError says how to install it."""
    _silence()
    return importExtra("pymbar.timeseries", _PURPOSE)


def mbar():
    """Return the module pymbar.mbar; see `timeseries`."""
    _silence()
    return importExtra("pymbar.mbar", _PURPOSE)


def _silence():
    """Hide pymbar's advertisement of JAX, and its warnings, which estimates repeat in our words."""
    logging.getLogger("pymbar").setLevel(logging.ERROR)
