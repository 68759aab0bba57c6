"""Scores of structures by the definitions of other programs."""
