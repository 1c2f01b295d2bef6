"""The chain as smooth CasADi functions: for gradients, fits and optimal control, never for the truth."""
