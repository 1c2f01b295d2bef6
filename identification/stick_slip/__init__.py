"""What do the breakaways and slips of a stem tell? Rests, the line through breakaways, and what makes the stem jump."""
