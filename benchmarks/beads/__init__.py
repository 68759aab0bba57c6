"""Chains of beads that turn freely at each bond: the times of pivots, and sampling beside dynamics."""
