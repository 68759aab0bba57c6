"""Builds residues that a model lacks, in ideal geometry."""
