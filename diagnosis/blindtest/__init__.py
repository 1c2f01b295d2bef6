"""Blind tests: plants made by an independent route, diagnosed without their truth."""
