"""Scene and engine to run: the Engine interface, the adapters, and the only code that drives and clocks them."""
