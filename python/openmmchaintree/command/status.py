"""What the command's exit status means, beside 0."""

BEYOND_LIMIT = 1  # a sampling run ended with pairs beyond their limit
BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141  # the output
TERMINATED = 143


def ofSignal(number):
    """Return the status of a command that a signal has ended, as a shell tells it."""
    return 128 + number
