"""The shared language: bodies, shapes, inertia, effects, scenes and trajectories.

Every other package may import this one; it imports nothing of the house.
"""
