"""Forces at the start of a run, which show bad contacts and distorted bonds."""

import numpy as np
from openmm import unit

from ..naming import nameAtom
from ..notes import Note, found

# In kJ/mol/nm, about 1,200 kT per Å at 300 K. Forces of relaxed and of good crystal structures are below 10,000, with
# hydrogens of unusual bond lengths below 15,000; a contact at 0.65 of the sum of two radii exceeds it.
_LARGEST = 30000.0


def noteOnForces(sampling, isMinimized):
    """Return a list with a Note on the atoms of a Sampling on which strong forces act at the start, or an empty list.

    Fixed atoms do not count. The cost is that of one evaluation of energy and forces by OpenMM.
    """
    state = sampling.context.getState(forces=True)
    forces = state.getForces(asNumpy=True).value_in_unit(unit.kilojoule_per_mole / unit.nanometer)
    sizes = np.where(sampling.plan.fixed, 0, np.linalg.norm(forces, axis=1))
    order = [atom for atom in np.argsort(-sizes, kind="stable").tolist() if not sizes[atom] <= _LARGEST]
    atoms = list(sampling.structure.topology.atoms())
    remedy = "although the energy was minimized" if isMinimized else "which --minimize relaxes"
    kind = f"forces above {_LARGEST:,.0f} kJ/mol/nm at the start, from bad contacts or distorted bonds, {remedy}"
    return found([Note(kind, (f"{nameAtom(atoms[atom])} {sizes[atom]:,.0f}" for atom in order))])
