"""What a user would take instead: each file solves the stem problem with one library, as well as that library can.

Each offers `TITLE`, `SETTINGS` from coarse to fine, and `run(stem, pressures, setting)`, which returns the positions
just before each pressure acts. Each knows the stop-speed rule at the ends of periods, where it costs one comparison.
"""
