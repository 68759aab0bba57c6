"""The shape of a structure with flexible residues, frame by frame, of which only what moves is kept."""

import numpy as np

from ..naming import describeResidue
from ..torsions import findTorsions
from .chainshape import ChainShape, shapesOf


class CoilShape:
    """Which atoms of frames are kept, and the values that describe a frame.

    trace : int array, the Cα atoms of the longest part
    deciding : list of str, names of values whose effective sample sizes decide: of each part the radius of gyration
        and the end-to-end distance of its Cα atoms, the mean of sin ψ and of sin χ1, which change as fast as the
        torsions of single residues, and beside fixed atoms the place of the part's middle
    hidden : set of str, names of values that only decide
    """

    def __init__(self, scene, positions, isMoving):
        """Take a CoilScene, positions (nm) of all atoms, and which of them move."""
        atoms = list(scene.topology.atoms())
        self._positions = np.asarray(positions, dtype=np.float32)
        self._kept = np.flatnonzero(isMoving)
        self._isFree = len(self._kept) == len(atoms)
        masses = np.array([0.0 if atom.element is None else atom.element.mass._value for atom in atoms])
        fixed, weights = _likeness(positions[~isMoving], masses[~isMoving])
        self._fixed, self._masses = fixed, np.concatenate([masses[self._kept], weights])
        place = {atom: number for number, atom in enumerate(self._kept.tolist())}
        self._traces, self._torsions = {}, {}
        for part in scene.parts:
            name = f"{describeResidue(part[0])} – {describeResidue(part[-1])}"
            trace = [place[atom.index] for residue in part for atom in residue.atoms() if atom.name in ("CA", "CH3")]
            self._traces[name] = np.array(trace, dtype=int)
            found = findTorsions(scene.topology, kinds=("psi", "chi1"), selection=_atomsOf(part)).torsions
            for kind in ("psi", "chi1"):
                particles = [
                    [place.get(atom, -1) for atom in torsion.particles] for torsion in found if torsion.kind == kind
                ]
                inside = [each for each in particles if min(each) >= 0]
                if inside:
                    self._torsions[f"{kind} of {name}"] = np.array(inside).T
        self._longest = max(self._traces.values(), key=len)
        self.trace = self._kept[self._longest]
        self.hidden, self.deciding = set(), []
        for name in self._traces:
            self.deciding += [f"radius of gyration of {name}", f"end-to-end distance of {name}"]
            if not self._isFree:
                self.hidden |= {f"{axis} of {name}" for axis in "xyz"}
        self.hidden |= self._torsions.keys()
        self.deciding += sorted(self.hidden)

    def frameOf(self, positions):
        """Return what is kept of positions: the moving atoms, centered if all move."""
        found = positions[self._kept]
        return (found - found.mean(axis=0) if self._isFree else found).astype(np.float32)

    def valuesOf(self, frames):
        """Return the values of frames by name."""
        frames = np.asarray(frames, dtype=np.float64)
        fixed = np.broadcast_to(self._fixed, (len(frames), *self._fixed.shape))
        whole = shapesOf(np.concatenate([frames, fixed], axis=1), self._masses)
        ends = np.linalg.norm(frames[:, self._longest[-1]] - frames[:, self._longest[0]], axis=1)
        values = whole._replace(endToEndDistance=ends).byName()
        for name, trace in self._traces.items():
            one = shapesOf(frames[:, trace], np.ones(len(trace)))
            values[f"radius of gyration of {name}"] = one.radiusOfGyration
            values[f"end-to-end distance of {name}"] = one.endToEndDistance
            if not self._isFree:
                for axis, middle in zip("xyz", frames[:, trace].mean(axis=1).T, strict=True):
                    values[f"{axis} of {name}"] = middle
        for name, (first, second, third, fourth) in self._torsions.items():
            values[name] = _sines(frames[:, first], frames[:, second], frames[:, third], frames[:, fourth]).mean(axis=1)
        return values

    def whole(self, frames):
        """Return (m, n, 3) float32 positions of all atoms, nm."""
        positions = np.repeat(self._positions[np.newaxis], len(frames), axis=0)
        positions[:, self._kept] = frames
        return positions

    def chainShape(self, values):
        """Return the ChainShape of the whole structure; its end-to-end distance is that of the longest part."""
        return ChainShape(*(values[name] for name in ("radius of gyration", "end-to-end distance", "asphericity")))


def _atomsOf(residues):
    return [atom.index for residue in residues for atom in residue.atoms()]


def _sines(first, second, third, fourth):
    """Return the sines of dihedrals, from (…, 3) arrays of places."""
    axis = third - second
    normal1, normal2 = np.cross(second - first, axis), np.cross(axis, fourth - third)
    lengths = np.linalg.norm(normal1, axis=-1) * np.linalg.norm(normal2, axis=-1) * np.linalg.norm(axis, axis=-1)
    return np.einsum("...i,...i->...", np.cross(normal1, normal2), axis) / lengths


def _likeness(positions, masses):
    """Return six places and masses with the center and the gyration tensor of fixed atoms; none if there are none."""
    total = masses.sum()
    if total == 0:
        return np.empty((0, 3)), np.empty(0)
    center = masses @ positions / total
    arms = positions - center
    moments, axes = np.linalg.eigh((arms.T * masses) @ arms / total)
    arms = (np.sqrt(3 * np.maximum(moments, 0)) * axes).T
    return center + np.concatenate([arms, -arms]), np.full(6, total / 6)
