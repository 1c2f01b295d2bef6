"""How fast, how exact, against whom? Each file is a program: `python -m benchmarks.NAME`."""
