"""How each effect acts: one file per law."""
