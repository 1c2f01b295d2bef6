"""What does a fit come to, and what does it leave of the record? Told in numbers, tables and pictures."""
