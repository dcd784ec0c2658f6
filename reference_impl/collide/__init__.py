"""Geometry only: which features of two bodies touch, and how the gap between two features changes."""
