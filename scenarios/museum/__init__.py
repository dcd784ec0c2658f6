"""The museum: behaviours that users of engines have run into, one exhibit a file."""
