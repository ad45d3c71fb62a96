"""What can be done from a shell: one module per verb, each with ``main(argv=None) -> int``."""

VERBS = {
    "check": "validate a scene and print its numbers",
    "simulate": "run the simulator node",
    "replay": "publish a recording again, with its timing and clock",
    "rerun": "simulate the recorded commands again and compare, without ROS",
    "recover": "turn a torn recording into a clean one",
    "report": "write a page about a recording, and export its arrays",
    "rollout": "simulate as fast as possible into a recording, without ROS",
    "linearise": "write A, B, C, D of an equilibrium for scipy.signal and python-control",
    "identify": "fit numbers of a scene, such as stiffness or damping, to a recorded motion",
    "derive": "derive scalar equations of motion of a rod, as text, LaTeX and numpy",
    "urdf": "write a scene as URDF, for robot_state_publisher, MoveIt and ros2_control",
    "demo": "simulate, drive over ROS topics, record, replay, re-simulate and summarise",
}
