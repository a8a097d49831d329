"""Benchmarks of the FMUs: one question per module or package, each run as `python -m benchmarks.<name>`."""
