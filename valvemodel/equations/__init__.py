"""What the derivations generated: the equations as compiled and as CasADi functions."""
