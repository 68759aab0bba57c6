"""The command openmm-chaintree: its options, runs, reports and pictures."""
