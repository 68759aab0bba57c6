"""Building residues of a peptide onto a chain, or a chain from its sequence, in ideal geometry."""

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..residues import CAPS, aminoAcid, chiAtoms
from .residuetemplates import C_N, C_N_CA, C_O, CA_C, CA_C_N, CA_C_O, N_CA, N_CA_C, N_H, residueTemplate

_TRANS = np.pi
_METHYL_H, _TETRAHEDRAL = 0.109, np.radians(109.5)
_FRONT_CAPS = ("ACE",)
_FIRST_AMINE = ("H", "H2", "H3")
_FIRST_AMINE_OF_RING = ("H2", "H3")


class BuiltResidue(NamedTuple):
    """A residue with its atoms.

    name : str; names, elements : tuples of str; positions : (n, 3) float64 array, nm; bonds : pairs of indices
    """

    name: str
    names: tuple
    elements: tuple
    positions: np.ndarray
    bonds: tuple

    def at(self, name):
        """Return the place of an atom."""
        return self.positions[self.names.index(name)]


class Joint(NamedTuple):
    """The end of a chain to build on: places (nm) of N, CA and C, and the torsion (rad) that the end allows.

    torsion : ψ of a residue before the built ones, φ of a residue behind them; None where it is free
    """

    n: np.ndarray
    ca: np.ndarray
    c: np.ndarray
    torsion: float | None


def placeAtom(first, second, third, length, angle, dihedral):
    """Return the place of an atom that is bonded to `third`, by its distance, angle and dihedral."""
    axis = third - second
    axis = axis / np.linalg.norm(axis)
    normal = np.cross(second - first, axis)
    normal = normal / np.linalg.norm(normal)
    across = np.cross(normal, axis)
    arm = -np.cos(angle) * axis + np.sin(angle) * (np.cos(dihedral) * across + np.sin(dihedral) * normal)
    return third + length * arm


def dihedralOf(first, second, third, fourth):
    """Return a dihedral in (−π, π] rad."""
    axis = third - second
    normal1, normal2 = np.cross(second - first, axis), np.cross(axis, fourth - third)
    return np.arctan2(np.linalg.norm(axis) * (second - first) @ normal2, normal1 @ normal2)


def _checkCaps(names, isBegin, isEnd):
    """Raise an InputError if a cap is not at the end of a chain where it belongs."""
    for place, name in enumerate(names):
        if name in _FRONT_CAPS and not (isBegin and place == 0):
            raise InputError(f"{name} can only be the first residue of a chain")
        if name in CAPS and name not in _FRONT_CAPS:
            isAlone = isBegin and place == 0
            if isAlone or not (isEnd and place == len(names) - 1):
                raise InputError(f"{name} can only be the last residue of a chain")


def amideHydrogen(previous, n, ca):
    """Return the place of the hydrogen of N, in the plane of its neighbors; previous : place of C before it."""
    outwards = (n - previous) / np.linalg.norm(n - previous) + (n - ca) / np.linalg.norm(n - ca)
    return n + N_H * outwards / np.linalg.norm(outwards)


def buildForward(names, draws, hydrogens, before=None, nextName=None):
    """Build residues behind the end of a chain, or a whole chain.

    Parameters
    ----------
    names : list of str
        of the residues; caps only at the ends
    draws : CoilDraws
    hydrogens : bool
    before : Joint, optional
        of the residue before; default: none, a whole chain is built
    nextName : str, optional
        of the residue behind, if there is one; default: the last residue is the end of the chain

    Returns
    -------
    list of BuiltResidue
    Joint
        of the last residue, with its ψ
    """
    _checkCaps(names, before is None, nextName is None)
    built, joint = [], before
    for place, name in enumerate(names):
        following = names[place + 1] if place + 1 < len(names) else nextName
        if name in CAPS:
            residue, joint = (
                _frontCap(name, hydrogens, None, None)
                if name in _FRONT_CAPS
                else (_backCap(name, hydrogens, joint), None)
            )
            built.append(residue)
            continue
        phi, psi = draws.backbone(name, following)
        template = _withSideChain(name, draws)
        phi = _ringPhi(template, phi)
        isFirst, isLast = joint is None, following is None
        if isFirst:
            n, ca, c = _firstBackbone()
            previous = None
        else:
            previous = joint.c
            if joint.torsion is None:
                joint = joint._replace(torsion=draws.backbone(name)[1])
            n, ca, c = backboneBehind(joint, phi)
        built.append(_complete(name, template, (n, ca, c), psi, previous, hydrogens, isLast))
        joint = Joint(n, ca, c, psi)
    return built, joint


def backboneBehind(joint, phi):
    """Return the places of N, CA and C of a residue behind a Joint, by its φ."""
    n = placeAtom(joint.n, joint.ca, joint.c, C_N, CA_C_N, joint.torsion)
    ca = placeAtom(joint.ca, joint.c, n, N_CA, C_N_CA, _TRANS)
    return n, ca, placeAtom(joint.c, n, ca, CA_C, N_CA_C, phi)


def backboneBefore(joint, psi):
    """Return the places of N, CA and C of a residue before a Joint, by its ψ."""
    c = placeAtom(joint.c, joint.ca, joint.n, C_N, C_N_CA, joint.torsion)
    ca = placeAtom(joint.ca, joint.n, c, CA_C, CA_C_N, _TRANS)
    return placeAtom(joint.n, c, ca, N_CA, N_CA_C, psi), ca, c


def buildBackward(names, draws, hydrogens, after, nextName, isLinker=False):
    """Build residues before a residue of a chain.

    Parameters
    ----------
    names, draws, hydrogens
        as for `buildForward`
    after : Joint
        of the residue behind
    nextName : str
        the name of that residue
    isLinker : bool
        whether there is a residue before; else the first residue is the end of the chain

    Returns
    -------
    list of BuiltResidue
        in the order of names
    Joint
        of the first residue, with its φ
    """
    _checkCaps(names, not isLinker, False)
    built, joint = [], after
    for place in range(len(names) - 1, -1, -1):
        name, following = names[place], [*names[place + 1 :], nextName][0]
        if joint.torsion is None:
            joint = joint._replace(torsion=draws.backbone(following)[0])
        phi, psi = draws.backbone(name, following)
        n, ca, c = backboneBefore(joint, psi)
        if name in _FRONT_CAPS:
            built.append(_frontCap(name, hydrogens, (ca, c), joint.n)[0])
            break
        template = _withSideChain(name, draws)
        phi = _ringPhi(template, phi)
        isFirst = place == 0 and not isLinker
        previous = None if isFirst else placeAtom(c, ca, n, C_N, C_N_CA, phi)
        built.append(_complete(name, template, (n, ca, c), psi, previous, hydrogens, False))
        joint = Joint(n, ca, c, phi)
    return built[::-1], joint


def _firstBackbone():
    n, ca = np.zeros(3), np.array([N_CA, 0, 0])
    return n, ca, ca + CA_C * np.array([-np.cos(N_CA_C), np.sin(N_CA_C), 0])


def _withSideChain(name, draws):
    """Return the template of a residue whose side chain has drawn χ."""
    template = residueTemplate(name)
    chis = draws.sideChain(name)
    places = template.positions.copy()
    for atoms, chi in zip(chiAtoms(aminoAcid(name)) if len(chis) else (), chis, strict=False):
        indices = [next((template.place(one) for one in names if one in template.names), -1) for names in atoms]
        if min(indices) < 0:
            break
        first, second, third, fourth = indices
        angle = chi - dihedralOf(*places[[first, second, third, fourth]])
        moved = template.beyond(second, third)
        places[moved] = _turn(places[moved], places[second], places[third], angle)
    return template._replace(positions=places)


def _turn(places, start, end, angle):
    """Return places turned about an axis, by Rodrigues' formula."""
    axis = (end - start) / np.linalg.norm(end - start)
    arms = places - end
    along = np.outer(arms @ axis, axis)
    return end + along + np.cos(angle) * (arms - along) + np.sin(angle) * np.cross(axis, arms)


def phiOfRing(name):
    """Return φ of an amino acid whose nitrogen is in a ring, such as proline; None for others."""
    return _ringPhi(residueTemplate(name), None)


def _ringPhi(template, phi):
    """Return φ of a residue: the given one, but in the ring of proline that of the ring."""
    ring = _ringAtomOfN(template)
    if ring is None:
        return phi
    n, ca, c = (template.positions[template.place(name)] for name in ("N", "CA", "C"))
    return dihedralOf(template.positions[ring], n, ca, c) + np.pi


def _ringAtomOfN(template):
    """Return the heavy atom beside CA that is bonded to N, as in proline; None without one."""
    n, ca = template.place("N"), template.place("CA")
    others = (set(bond) - {n} for bond in template.bonds if n in bond)
    return next((a for other in others for a in other if a != ca and template.elements[a] != "H"), None)


def _complete(name, template, backbone, psi, previous, hydrogens, isLast):
    """Return the BuiltResidue of a template at the places of its backbone.

    previous : place of C of the residue before, None at the first end
    """
    n, ca, c = backbone
    places = _moved(template, n, ca, c)
    atoms = dict(zip(template.names, zip(template.elements, places, strict=True), strict=True))
    atoms["O"] = "O", placeAtom(n, ca, c, C_O, CA_C_O, psi + np.pi)
    ring = _ringAtomOfN(template)
    if previous is not None and "H" in atoms:
        atoms["H"] = "H", amideHydrogen(previous, n, ca)
    bonds = [(template.names[first], template.names[second]) for first, second in template.bonds]
    if previous is None:
        start, amine = (
            (np.pi, _FIRST_AMINE) if ring is None else (dihedralOf(c, ca, n, places[ring]), _FIRST_AMINE_OF_RING)
        )
        for number, hydrogen in enumerate(amine, 0 if ring is None else 1):
            atoms[hydrogen] = "H", placeAtom(c, ca, n, N_H, _TETRAHEDRAL, start + number * 2 * np.pi / 3)
            bonds.append(("N", hydrogen))
    if isLast:
        atoms["OXT"] = "O", placeAtom(n, ca, c, C_O, CA_C_O, psi)
        bonds.append(("C", "OXT"))
    return _built(name, atoms, bonds, hydrogens)


def _built(name, atoms, bonds, hydrogens):
    """Return a BuiltResidue of {name: (element, place)} and bonds by names, without hydrogens if so told."""
    kept = [atom for atom, (element, _) in atoms.items() if hydrogens or element != "H"]
    index = {atom: number for number, atom in enumerate(kept)}
    pairs = {tuple(sorted((index[a], index[b]))) for a, b in bonds if a in index and b in index}
    elements = tuple(atoms[atom][0] for atom in kept)
    return BuiltResidue(name, tuple(kept), elements, np.array([atoms[atom][1] for atom in kept]), tuple(sorted(pairs)))


def _moved(template, n, ca, c):
    """Return the places of a template's atoms with its backbone at other places of the same geometry."""
    own = [template.positions[template.place(name)] for name in ("N", "CA", "C")]
    return n + (template.positions - own[0]) @ axesOf(*own) @ axesOf(n, ca, c).T


def axesOf(n, ca, c):
    """Return axes as columns: along N–CA, in the plane of C, and normal to it."""
    first = (ca - n) / np.linalg.norm(ca - n)
    last = np.cross(first, c - ca)
    last = last / np.linalg.norm(last)
    return np.column_stack([first, np.cross(last, first), last])


# ---- Caps ----


def _frontCap(name, hydrogens, places, n):
    """Return ACE as a BuiltResidue, at the places of CH3 and C, before N; and its Joint, with the angle of its O."""
    if places is None:
        far, methyl, c = _firstBackbone()
        n = placeAtom(far, methyl, c, C_N, CA_C_N, _TRANS)
    else:
        methyl, c = places
        far = placeAtom(n, c, methyl, N_CA, N_CA_C, _TRANS)
    atoms = {"CH3": ("C", methyl), "C": ("C", c), "O": ("O", placeAtom(far, methyl, c, C_O, CA_C_O, 0))}
    bonds = [("CH3", "C"), ("C", "O")]
    _addMethyl(atoms, bonds, "CH3", (n, c), ("H1", "H2", "H3"))
    return _built(name, atoms, bonds, hydrogens), Joint(far, methyl, c, _TRANS)


def _backCap(name, hydrogens, joint):
    """Return NME or NH2 as a BuiltResidue behind a Joint."""
    n = placeAtom(joint.n, joint.ca, joint.c, C_N, CA_C_N, joint.torsion)
    trans = placeAtom(joint.ca, joint.c, n, N_CA, C_N_CA, _TRANS)
    cis = placeAtom(joint.ca, joint.c, n, N_H, C_N_CA, 0)
    if name in ("NH2", "NHE"):
        along = n + (trans - n) * N_H / N_CA
        atoms = {"N": ("N", n), "HN1": ("H", cis), "HN2": ("H", along)}
        return _built(name, atoms, [("N", "HN1"), ("N", "HN2")], hydrogens)
    atoms = {"N": ("N", n), "C": ("C", trans), "H": ("H", cis)}
    bonds = [("N", "C"), ("N", "H")]
    _addMethyl(atoms, bonds, "C", (joint.c, n), ("H1", "H2", "H3"))
    return _built(name, atoms, bonds, hydrogens)


def _addMethyl(atoms, bonds, carbon, behind, names):
    """Add the hydrogens of a methyl group, staggered to the two atoms behind its carbon."""
    for number, name in enumerate(names):
        turn = np.pi + number * 2 * np.pi / 3
        atoms[name] = "H", placeAtom(*behind, atoms[carbon][1], _METHYL_H, _TETRAHEDRAL, turn)
        bonds.append((carbon, name))
