"""The bonds that a structure file lists: CONECT, LINK and SSBOND of PDB, _struct_conn of mmCIF."""

from collections import Counter

import gemmi

_BONDS = {gemmi.ConnectionType.Covale, gemmi.ConnectionType.Disulf, gemmi.ConnectionType.MetalC}


def bondsOfFile(structure, made):
    """Return the bonds between atoms of a ModelTopology that a gemmi.Structure lists: a dict of orders by pair.

    An order is the number of times that CONECT lists the bond. It is None in residues in which CONECT lists each bond
    once, as many programs do whatever the order is, and for all other bonds. Files of molecules have all orders.

    Bonds to symmetry mates and hydrogen bonds are left out, and bonds of atoms in other conformers, and of numbers that
    several atoms have.
    """
    bonds, atoms = {}, list(made.topology.atoms())

    def add(first, second, order=None):
        if first != second:
            pair = min(first, second), max(first, second)
            bonds[pair] = bonds.get(pair) if order is None else order

    for first, second in _connections(structure, made.topology, False):
        add(first, second)
    bySerial = {}
    for index, atom in enumerate(made.atoms if structure.conect_map else ()):
        bySerial.setdefault(atom.serial, []).append(index)
    for serial, others in structure.conect_map.items():
        for other, count in Counter(others).items():
            first, second = bySerial.get(serial, ()), bySerial.get(other, ())
            if serial > 0 and other > 0 and len(first) == 1 and len(second) == 1:
                add(first[0], second[0], count)
    if structure.input_format == gemmi.CoorFormat.ChemComp:
        return bonds
    multiple = [pair for pair, order in bonds.items() if order is not None and order > 1]
    withOrders = {atoms[atom].residue for pair in multiple for atom in pair}
    return {pair: order if atoms[pair[0]].residue in withOrders else None for pair, order in bonds.items()}


def bondsWithCopies(models):
    """Return the pairs of an atom and an atom of a symmetry mate that Models list as bonded, lower index first."""
    return sorted({(min(pair), max(pair)) for pair in _connections(models.file, models.topology, True)})


def _connections(structure, topology, areWithMates):
    """Return the listed bonds as pairs of atoms of a Topology: bonds with symmetry mates, or all others."""
    byAddress = _atomsByAddress(topology) if len(structure.connections) else {}
    pairs = []
    for connection in structure.connections:
        if connection.type in _BONDS and (connection.asu == gemmi.Asu.Different) == areWithMates:
            ends = [byAddress.get(_address(partner), ()) for partner in (connection.partner1, connection.partner2)]
            if len(ends[0]) == 1 and len(ends[1]) == 1:
                pairs.append((ends[0][0], ends[1][0]))
    return pairs


def _atomsByAddress(topology):
    """Return the atoms by chain, residue number with insertion code, and name."""
    atoms = {}
    for atom in topology.atoms():
        residue = atom.residue
        address = (residue.chain.id, residue.id + residue.insertionCode, atom.name)
        atoms.setdefault(address, []).append(atom.index)
    return atoms


def _address(partner):
    number = partner.res_id.seqid
    return partner.chain_name, f"{number.num}{number.icode.strip()}", partner.atom_name.replace("*", "'")
