"""What the command prints about its runs, and the same as JSON and CSV."""
