"""How often is the diagnosis right? Blind plants are sealed, diagnosed, opened and scored."""
