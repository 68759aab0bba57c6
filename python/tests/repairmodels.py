"""Models with clashes, for tests of repairs."""

import functools

import numpy as np
from openmm import app
from openmmchaintree import createStericExclusionForce
from openmmchaintree.contexts import contextOf
from openmmchaintree.structures.structure import readStructure


@functools.cache
def villinPacked(seed=3, share=0.5):
    """Return villin's Topology and positions (nm) with some of its side chains turned at random."""
    villin = readStructure()
    force = createStericExclusionForce(villin.topology, villin.positions, torsions="chi")
    context = contextOf(force)
    context.setPositions(villin.positions)
    angles = force.getTorsionAngles(context)
    random = np.random.default_rng(seed)
    chosen = random.random(len(angles)) < share
    angles[chosen] += random.uniform(-2, 2, chosen.sum())
    force.setTorsionAngles(context, (angles + np.pi) % (2 * np.pi) - np.pi)
    state = context.getState(positions=True)
    return villin.topology, state.getPositions(asNumpy=True)._value.copy()


def asPDB(topology, positions):
    """Return the text of a PDB file of positions in nm."""
    import io

    text = io.StringIO()
    app.PDBFile.writeFile(topology, 10 * positions, text, keepIds=True)
    return text.getvalue()
