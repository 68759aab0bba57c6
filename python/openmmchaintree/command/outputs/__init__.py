"""The command's output files, which appear when complete and replace other files only on request."""
