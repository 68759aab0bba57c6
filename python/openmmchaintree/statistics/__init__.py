"""Means of correlated series with errors, and whether they may be quoted: by pymbar, for numbers from any source."""
