"""The Baraff-style reference engine: exact flight, contacts as events, resting contact as complementarity."""
