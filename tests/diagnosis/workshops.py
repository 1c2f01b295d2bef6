"""Workshops for tests of what is tried, in which nothing is run."""

from diagnosis.trying.workshop import Workshop

EMPTY = Workshop(None)
"""Without a record, and all alone."""
