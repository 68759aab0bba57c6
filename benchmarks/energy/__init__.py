"""What energies of trials cost and how exact they are: proteins in a force field, ours beside OpenMM's."""
