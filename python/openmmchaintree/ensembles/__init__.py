"""Ensembles of proteins with a bead for each residue: runs, the shapes of chains, and what they are made of."""
