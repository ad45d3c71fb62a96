"""A scene that moves: its state, its inputs, its steps."""
