"""Closing a gap between fixed parts: φ and ψ of the missing residues, by least squares from many random starts."""

import numpy as np

from ..errors import InputError
from .chainbuilder import Joint, backboneBefore, backboneBehind, buildForward, phiOfRing
from .residuetemplates import N_CA

FEWEST = 3  # residues: φ and ψ of three can meet six conditions
_STARTS = 400
_SOLUTIONS = 120  # over the number of residues, but 2 to 12: the one with fewest contacts is taken
_STEPS = 60
_CLOSED = 1e-11  # nm
_LEAST_DAMPING = 1e-12  # nm², since conditions depend on each other
_LARGEST_TURN = 0.5  # rad, in a step
_NEAR = 0.3  # nm: nearer atoms that are not bonded are a contact


def closeGap(names, draws, hydrogens, before, after, nextName, obstacles):
    """Build residues between two that stay.

    Parameters
    ----------
    names : list of str
        at least FEWEST
    draws, hydrogens
        as for `buildForward`
    before : Joint
        of the residue before
    after : Joint
        of the residue behind: its places, and its φ if that is not free
    nextName : str
        the name of the residue behind
    obstacles : (n, 3) array
        nm, places of atoms from which solutions keep away if they can

    Returns
    -------
    list of BuiltResidue, whose last C is at the length of a bond from N of the residue behind, within 1e-10 nm

    Raises
    ------
    InputError
        if no start led to a closed chain
    """
    best, fewest, solutions = None, None, 0
    most = min(12, max(2, _SOLUTIONS // len(names)))
    for _ in range(_STARTS):
        start = before if before.torsion is not None else before._replace(torsion=draws.backbone(names[0])[1])
        drawn = [draws.backbone(name, following) for name, following in zip(names, [*names[1:], nextName], strict=True)]
        angles = _solve(_Gap(names, start, after), np.array(drawn))
        if angles is None:
            continue
        built, _ = buildForward(names, _Prescribed(draws, angles), hydrogens, start, nextName)
        places = np.concatenate([residue.positions for residue in built])
        contacts = int((np.linalg.norm(places[:, np.newaxis] - obstacles, axis=2) < _NEAR).sum())
        if best is None or contacts < fewest:
            best, fewest = built, contacts
        solutions += 1
        if solutions == most:
            break
    if best is None:
        raise InputError(f"{len(names)} residues do not close the gap before {nextName}: it may be too wide")
    return best


class _Prescribed:
    """Takes the place of draws, with φ and ψ that are given in the order of residues."""

    def __init__(self, draws, angles):
        self._angles = iter(angles.tolist())
        self.sideChain = draws.sideChain

    def backbone(self, name, nextName=None):
        """Return the next φ and ψ."""
        return tuple(next(self._angles))


class _Gap:
    """The conditions that a closed chain meets, as a function of φ and ψ."""

    def __init__(self, names, before, after):
        self._before = before
        self._ring = [phiOfRing(name) for name in names]
        self._stretch = np.linalg.norm(after.ca - after.n) / N_CA  # the residue behind has its own bond length
        self._targets = [after.n, after.ca]
        if after.torsion is not None:
            self._targets.append(backboneBefore(after, 0.0)[2])  # its φ says where the last C is
        self.isFree = np.array([[phi is None, True] for phi in self._ring])

    def errors(self, angles):
        """Return the conditions' errors (nm), and their derivatives by each φ and ψ."""
        joint, axes = self._before, []
        for (phi, psi), ring in zip(angles, self._ring, strict=True):
            n, ca, c = backboneBehind(joint, phi if ring is None else ring)
            axes += [(n, ca), (ca, c)]
            joint = Joint(n, ca, c, psi)
        n, ca, _ = backboneBehind(joint, 0.0)
        ca = n + self._stretch * (ca - n)
        points = [n, ca, joint.c][: len(self._targets)]
        derivatives = np.zeros((len(points) * 3, len(axes)))
        for number, (start, end) in enumerate(axes):
            axis = (end - start) / np.linalg.norm(end - start)
            derivatives[:, number] = np.concatenate([np.cross(axis, point - end) for point in points])
        return np.concatenate(points) - np.concatenate(self._targets), derivatives


def _solve(gap, angles):
    """Return closed φ and ψ near given ones by damped least squares; None if they do not converge."""
    free = gap.isFree.ravel()
    damping = 1e-5  # nm²
    errors, derivatives = gap.errors(angles)
    for _ in range(_STEPS):
        if np.abs(errors).max() < _CLOSED:
            return angles
        slopes = derivatives[:, free]
        step = -slopes.T @ np.linalg.solve(slopes @ slopes.T + damping * np.eye(len(errors)), errors)
        step *= min(1.0, _LARGEST_TURN / max(np.abs(step).max(), 1e-300))
        tried = angles.ravel().copy()
        tried[free] += step
        tried = tried.reshape(-1, 2)
        found, slopesThere = gap.errors(tried)
        if found @ found < errors @ errors:
            angles, errors, derivatives, damping = tried, found, slopesThere, max(0.1 * damping, _LEAST_DAMPING)
        else:
            damping *= 10
            if damping > 1e4:
                return None
    return None
