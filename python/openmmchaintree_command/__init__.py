"""The entry point of the command openmm-chaintree: if a package is missing, it prints what to install.

This module is not a part of openmmchaintree, which loads libraries when it is imported: if that fails, Python would end
with a traceback.
"""

import sys

_BAD_INSTALLATION = 2


def main():
    """Run the command; return its exit status."""
    try:
        from openmmchaintree.extras import adviceOn
    except ImportError as error:
        return _refuse(error)
    try:
        from openmmchaintree.command.cli import main as run

        return run()
    except ImportError as error:
        return _refuse(error if error.name is None else adviceOn(error.name, "the command", error))


def _refuse(reason):
    print(f"openmm-chaintree: {reason}", file=sys.stderr)
    return _BAD_INSTALLATION
