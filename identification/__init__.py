"""Which numbers fit the data: experiments, unknowns, fits and what a record determines."""
