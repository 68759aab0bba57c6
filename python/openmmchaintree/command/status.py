"""Exit statuses of the command other than 0."""

BEYOND_LIMIT = 1  # a sampling run ended with pairs beyond their limit
BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141  # the reader of the output has closed it
TERMINATED = 143


def ofSignal(number):
    """Return the exit status for a signal, as shells report it."""
    return 128 + number
