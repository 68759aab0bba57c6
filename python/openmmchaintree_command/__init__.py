"""What the shell calls: the command openmm-chaintree, or what to install if it cannot start.

The package openmmchaintree loads libraries when it is imported, and where that fails Python would end with a traceback.
So this module stands beside it.
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
