"""What the command's exit status means, beside 0."""

BEYOND_LIMIT = 1  # a sampling run ended with pairs beyond their limit
CONTESTANTS_FAILED = 1  # a row of a benchmark failed, or verdicts differed
BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141  # the output
