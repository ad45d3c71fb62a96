"""The equations of motion of a scene as functions of state, efforts and time."""
