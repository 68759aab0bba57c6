"""The command openmm-chaintree: what it reads, runs, prints and draws."""
