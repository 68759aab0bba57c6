"""The repair of clashes: a scene with hydrogens, the steps of the repair, and what changed."""
