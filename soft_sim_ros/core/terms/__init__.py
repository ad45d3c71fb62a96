"""Forces beyond inertia, gravity and linear elasticity, one kernel file each."""
