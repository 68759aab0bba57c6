"""Scripts that show clashes in PyMOL (.pml) and ChimeraX (.cxc)."""

from pathlib import Path

ENDINGS = (".pml", ".cxc")

# The name of the structure in PyMOL, where "model" is a word of selections.
_OBJECT = "scored"

# Residues are red from this overlap on (nm), and yellow at the least of a clash.
_WORST, _LEAST = 0.1, 0.04


def asScript(ending, search, model, definition):
    """Return the script of the clashes of a model by a definition, as text.

    ending : of ENDINGS; search : ScoreSearch; model : dict, plain scores of it

    It colors residues by their worst overlap, and draws a line between the atoms of each clash; for an added hydrogen
    the line begins at the atom that bears it.
    """
    pairs = model[definition]["pairs"]
    atoms = list(search.topology.atoms())
    worst: dict = {}
    lines = []
    for pair in pairs:
        ends = [atoms[pair[end]] for end in ("particle1", "particle2")]
        for end in ends:
            worst[end.residue] = max(worst.get(end.residue, 0.0), pair["overlap"])
        lines.append(ends)
    path = Path(search.source).resolve().as_posix()
    return (_asPyMOL if ending == ".pml" else _asChimeraX)(path, worst, lines)


def _colorOf(overlap):
    """Return red, green and blue of an overlap, from 0 to 255."""
    share = min(max((overlap - _LEAST) / (_WORST - _LEAST), 0.0), 1.0)
    return 255, round(200 * (1 - share)), 0


def _asPyMOL(path, worst, lines):
    text = [f"load {path}, {_OBJECT}", f"hide everything, {_OBJECT}", f"show cartoon, {_OBJECT}"]
    text.append(f"color grey80, {_OBJECT}")
    for residue, overlap in worst.items():
        text.append("color 0x{:02x}{:02x}{:02x}, {}".format(*_colorOf(overlap), _inPyMOL(residue)))
        text.append(f"show sticks, {_inPyMOL(residue)}")
    for first, second in lines:
        ends = (f"{_inPyMOL(atom.residue)} and name {atom.name}" for atom in (first, second))
        text.append("distance clashes, {}, {}".format(*ends))
    if lines:
        text += ["hide labels, clashes", "color magenta, clashes"]
    return "\n".join([*text, ""])


def _inPyMOL(residue):
    chain = f'chain "{residue.chain.id.strip()}"'
    return f"{_OBJECT} and {chain} and resi {residue.id}{residue.insertionCode.strip()} and resn {residue.name}"


def _asChimeraX(path, worst, lines):
    text = [f'open "{path}" id 1', "hide #1 atoms", "cartoon #1", "color #1 lightgray"]
    for residue, overlap in worst.items():
        text.append("color {} #{:02x}{:02x}{:02x}".format(_inChimeraX(residue), *_colorOf(overlap)))
        text.append(f"show {_inChimeraX(residue)} atoms")
    for first, second in lines:
        ends = (f"{_inChimeraX(atom.residue)}@{atom.name}" for atom in (first, second))
        text.append("pbond {} {} color magenta radius 0.1 name clashes".format(*ends))
    return "\n".join([*text, ""])


def _inChimeraX(residue):
    chain = residue.chain.id.strip()
    return f"#1{f'/{chain}' if chain else ''}:{residue.id}{residue.insertionCode.strip()}"
