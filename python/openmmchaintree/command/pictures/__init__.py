"""The pictures that the command draws."""

import importlib


def savePicture(module, output, *arguments):
    """Write the picture of a module of this folder to an Output; Matplotlib takes longer to import than short runs."""
    importlib.import_module(f".{module}", __package__).savePicture(output, *arguments)
