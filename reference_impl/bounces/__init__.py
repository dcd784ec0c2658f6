"""Free flight and isolated bounces of spheres, compiled: whole stretches of time without a step of Python."""
