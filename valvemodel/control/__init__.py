"""How is the valve best moved? Controllers and optimal moves on the exact valve."""
