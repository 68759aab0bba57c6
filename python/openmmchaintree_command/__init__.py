"""The entry point of the command openmm-chaintree: if a package is missing, it prints what to install.

This module is not a part of openmmchaintree, which loads libraries when it is imported: if that fails, Python would end
with a traceback.
"""

import sys

_BAD_INSTALLATION = 2


def main():
    """Run the command; return its exit status."""
    try:
        from openmmchaintree.command.cli import main as run

        return run()
    except ImportError as error:
        advice = f": pip install {error.name}" if isinstance(error, ModuleNotFoundError) else ""
        print(f"openmm-chaintree: {error}{advice}", file=sys.stderr)
        return _BAD_INSTALLATION
