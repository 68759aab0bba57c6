"""Preparing a structure for a force field: omitting, replacing and completing what the file has."""
