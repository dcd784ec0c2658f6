"""Runs to measurements: momentum, energy, restitution, penetration, accuracy.

The judge shares no code with the judged: engines answer with motion only, and every quantity is
computed here, the same way for every engine.  One quantity per file; `comparisons.judge` finds them.
"""
