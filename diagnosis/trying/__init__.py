"""How is a cause tried? It is fitted, scored on what was kept back, and set beside those that were tried before."""
