"""Matrices here are small: numpy's threads would only wait for each other, so there is one, as on the command line."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
