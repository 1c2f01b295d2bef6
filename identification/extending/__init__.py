"""What does one more effect bring to a fit, or one fewer take? The search for it, followed down from its starts."""
