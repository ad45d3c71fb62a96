"""Rod dynamics: SE(3), compilation of scenes, dynamics, statics, modes, integration."""
