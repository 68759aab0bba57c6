"""The files that the command writes: they appear when they are complete, and replace nothing unasked."""
