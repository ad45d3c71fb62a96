"""What the simulator node costs as a process: its share of a core, and its start."""
