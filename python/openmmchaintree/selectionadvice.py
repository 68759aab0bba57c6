"""What a selection in MDTraj's language that fails probably meant."""

import ast
import re

from .nearnames import didYouMean

# The words of the language, without their aliases.
_WORDS = (
    *("all", "none", "protein", "nucleic", "water", "backbone", "sidechain", "name", "index", "element", "mass"),
    *("resname", "resid", "resSeq", "rescode", "chainid", "segname", "n_bonds", "and", "or", "not"),
)
_OTHER_LANGUAGES = {"chain": "segname", "chainname": "segname", "resnum": "resSeq", "resi": "resSeq"}

_MOST_NAMES = 6  # that are listed if none of them is near

# What MDTraj's expressions compare.
_NAMES = {
    "atom.name": ("atom name", lambda atom: atom.name),
    "atom.residue.name": ("residue", lambda atom: atom.residue.name),
    "atom.segment_id": ("chain", lambda atom: atom.residue.segment_id),
    "atom.element.symbol": ("element", lambda atom: atom.element.symbol),
}
_NUMBERS = {
    "atom.residue.resSeq": ("resSeq", lambda atom: atom.residue.resSeq),
    "atom.residue.index": ("resid", lambda atom: atom.residue.index),
    "atom.residue.chain.index": ("chainid", lambda atom: atom.residue.chain.index),
}


def adviseOnWords(text):
    """Return the end of an error on a text that is not in the language."""
    for word in re.findall(r"[A-Za-z_]\w*", text):
        if word in _OTHER_LANGUAGES:
            return f"; did you mean {_OTHER_LANGUAGES[word]}?"
        # Values are short, or in capitals.
        if word.lower() == word and len(word) > 3 and word not in _WORDS and (advice := didYouMean(word, _WORDS)):
            return advice
    return ""


def adviseOnValues(topology, expression):
    """Return the end of an error on an expression of MDTraj that selects no atom of an MDTraj Topology."""
    for node in ast.walk(ast.parse(expression, mode="eval")):
        if not isinstance(node, ast.Compare):
            continue
        sides = [node.left, *node.comparators]
        for side in map(ast.unparse, sides):
            if side in _NUMBERS:
                name, read = _NUMBERS[side]
                numbers = [read(atom) for atom in topology.atoms]
                return f"; {name} is {min(numbers)} to {max(numbers)} here"
            if side in _NAMES and (advice := _adviseOnNames(topology, sides, *_NAMES[side])):
                return advice
    return ""


def _adviseOnNames(topology, sides, what, read):
    known = sorted({read(atom) for atom in topology.atoms} - {""})
    values = [node.value for side in sides for node in ast.walk(side) if isinstance(node, ast.Constant)]
    for value in map(str, values):
        if value not in known:
            there = f"; the structure has {', '.join(known)}" if 0 < len(known) <= _MOST_NAMES else ""
            return f", since there is no {what} {value}{didYouMean(value, known) or there}"
    return ""
