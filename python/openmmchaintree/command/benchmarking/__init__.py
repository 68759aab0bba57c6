"""The races of the command benchmark: what runs, on what, and what is made of the times."""
