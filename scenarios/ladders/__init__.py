"""Ladders, one difficulty per module: the family of scenarios that is climbed, and `LADDERS`."""
