"""Races of the engine against other methods: what runs, on what, and what is made of the times."""
