"""How fast and how exact is the simulator, against what else one would use (`python -m benchmarks.simulation`)?"""
