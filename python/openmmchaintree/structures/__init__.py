"""Reading files: structures, trajectories, and their clashes."""

from ..extras import importExtra

importExtra("gemmi", "reading structure files")
