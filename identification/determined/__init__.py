"""Which numbers a record determines: by structure, by sensitivity, and after a fit by intervals; and what it lacks."""
