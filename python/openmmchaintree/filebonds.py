"""The bonds that a structure file tells: CONECT, LINK and SSBOND of PDB, _struct_conn of mmCIF."""

import gemmi

_BONDS = {gemmi.ConnectionType.Covale, gemmi.ConnectionType.Disulf, gemmi.ConnectionType.MetalC}


def bondsOfFile(structure, made):
    """Return the bonds that a gemmi.Structure tells of a ModelTopology, as a list of pairs, once each.

    Bonds to symmetry mates and hydrogen bonds are left out; so are atoms of conformers that were not taken, and numbers
    that several atoms have.
    """
    bonds = {}

    def add(first, second):
        if first != second:
            bonds[min(first, second), max(first, second)] = None

    for connection in structure.connections:
        if connection.type in _BONDS and connection.asu != gemmi.Asu.Different:
            first, second = (_atomsAt(made, partner) for partner in (connection.partner1, connection.partner2))
            if len(first) == 1 and len(second) == 1:
                add(first[0], second[0])
    bySerial = {}
    for index, atom in enumerate(made.atoms):
        bySerial.setdefault(atom.serial, []).append(index)
    for serial, others in structure.conect_map.items():
        for other in others:
            first, second = bySerial.get(serial, ()), bySerial.get(other, ())
            if serial > 0 and other > 0 and len(first) == 1 and len(second) == 1:
                add(first[0], second[0])
    return list(bonds)


def _atomsAt(made, partner):
    residue = partner.res_id
    return made.addresses.get((partner.chain_name, str(residue.seqid), residue.name, partner.atom_name), ())
