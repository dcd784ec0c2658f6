"""Questions with answer keys: one subject per file, found by `scenarios.catalogue`."""
