"""Do the numbers come back? Fits by both routes and by peers, loops, self-calibration, EMPS, on independent data."""
