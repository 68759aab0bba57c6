"""Choosing atoms of a Topology: by MDTraj's selection language, by index, or by a function."""

import ast
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from openmm import app

from .extras import importExtra
from .selectionadvice import adviseOnValues, adviseOnWords

AtomSelection: TypeAlias = str | npt.ArrayLike | Callable[[app.Atom], bool]


def selectAtoms(topology: app.Topology, selection: AtomSelection) -> npt.NDArray[np.int64]:
    """Return the indices of the atoms that a selection chooses, in ascending order.

    Parameters
    ----------
    topology : openmm.app.Topology
    selection : str, array of int or bool, or callable
        A text is in `MDTraj's selection language <https://mdtraj.org/latest/atom_selection.html>`_. There ``resSeq`` is
        the number of a residue in the file, ``resid`` its index from 0, and ``chainid`` the index of a chain from 0.
        MDTraj has no word for the name of a chain: here ``segname`` is that name (``segname A``). MDTraj ignores
        insertion codes: ``resSeq 52`` is 52 and 52A. An array holds the indices of atoms, or a bool for each atom. A
        function is called with each openmm.app.Atom and returns whether to take it.

    Returns
    -------
    array of int

    Raises
    ------
    ValueError
        if a text cannot be understood, an index is out of range, or no atom is selected

    Examples
    --------
    >>> selectAtoms(topology, "segname A and resSeq 10 to 20 and sidechain")
    >>> selectAtoms(topology, lambda atom: atom.residue.id == "52" and atom.residue.insertionCode == "A")
    """
    advice = ""
    if isinstance(selection, str):
        atoms, advice = _selectByText(topology, selection)
    elif callable(selection):
        atoms = np.array([atom.index for atom in topology.atoms() if selection(atom)], dtype=np.int64)
    else:
        atoms = _selectByIndex(topology.getNumAtoms(), selection)
    if len(atoms) == 0:
        raise ValueError(f"{_emptiness(selection)}{advice}")
    return atoms


def _emptiness(selection):
    return f"{selection!r} selects no atom" if isinstance(selection, str) else "the selection has no atom"


def _selectByIndex(count, selection):
    values = np.asarray(selection)
    if values.dtype == bool:
        if values.shape != (count,):
            raise ValueError(f"a selection by bool must have the shape ({count},), not {values.shape}")
        return np.flatnonzero(values)
    if values.size == 0:
        return np.empty(0, dtype=np.int64)
    if values.ndim != 1 or not np.issubdtype(values.dtype, np.integer):
        raise ValueError("a selection is a text, a function of an atom, or a list of atom indices")
    atoms = np.unique(values).astype(np.int64)
    for atom in (atoms[0], atoms[-1]):
        if not 0 <= atom < count:
            raise ValueError(f"the selection has atom {atom}, but there are atoms 0 to {count - 1} only")
    return atoms


def _selectByText(topology, text):
    """Return the indices of atoms; and, if there are none, advice to add to an error."""
    # MDTraj takes longer to import than a small structure to read.
    mdtraj = importExtra("mdtraj", "a selection by text")
    converted = mdtraj.Topology.from_openmm(topology)
    for chain, original in zip(converted.chains, topology.chains(), strict=True):
        for residue in chain.residues:
            residue.segment_id = original.id.strip()
    try:
        expression = converted.select_expression(text)
        _refuseMisreadings(expression)
        atoms = np.array(converted.select(text), dtype=np.int64)
    except Exception as error:  # MDTraj reports by whatever exception comes up, on several lines
        reason = f"({_reason(text, error)}){adviseOnWords(text)}"
        raise ValueError(f"{text!r} is not in MDTraj's selection language {reason}") from error
    return atoms, "" if len(atoms) > 0 else adviseOnValues(converted, expression)


def _reason(text, error):
    """Return the reason why MDTraj does not understand a text, on one line."""
    if ">=" in text or "<=" in text:
        return "it does not read >= and <=: write (resSeq ge 10), (resSeq le 20), in parentheses"
    reason = str(error).splitlines()[0].removesuffix(f": {text}")
    return "a part is missing" if reason.startswith("Expected {") else reason


def _refuseMisreadings(expression):
    """Raise a ValueError for expressions that MDTraj silently reads in an unexpected way.

    Its && and || bind more tightly than comparisons by sign, and its and and or more tightly than comparisons by
    letters (lt, eq, …). A number alone selects everything.
    """
    (condition,) = ast.parse(expression, mode="eval").body.generators[0].ifs
    if isinstance(condition, ast.Constant) and not isinstance(condition.value, bool):
        raise ValueError("a value alone is not a condition")
    for node in ast.walk(condition):
        # A match by =~ is a call with the pattern and the text, and binds most loosely.
        sides = node.args if isinstance(node, ast.Call) else []
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
        if any(isinstance(side, (ast.BoolOp, ast.Compare)) for side in sides):
            raise ValueError(f"MDTraj reads it as {ast.unparse(node)}: put comparisons in parentheses")
