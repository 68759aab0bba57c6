"""Reports on runs of the command: printed, and as JSON and CSV."""
