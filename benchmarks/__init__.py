"""What the reference engine promises, measured: one file per promise, `python -m benchmarks` for all of them.

Nothing here is asserted by the tests: a promise that is missed is printed as missed.
"""
