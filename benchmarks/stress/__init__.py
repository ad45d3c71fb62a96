"""Where the solver completes, where it refuses, and whether it is ever silently wrong."""
