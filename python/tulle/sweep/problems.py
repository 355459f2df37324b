"""Errors that a person can mend, and the exit codes, which are those of the program `tulle`."""
from __future__ import annotations

EXIT_FINE = 0
EXIT_FAILED_RUNS = 1  # a run failed, or the judge found intersections
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130


class SweepError(Exception):
    """Bad usage or a bad file: ends with exit code 2. The text names the file and says what to do."""
