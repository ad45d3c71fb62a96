"""Stand-ins of the messages and services of simulation_interfaces 2.1, which no wheel has.

Fields, constants and defaults are those of its definitions; nothing of it goes over the wire.
"""

from types import ModuleType, SimpleNamespace

from geometry_msgs.msg import Accel, Pose, Twist
from std_msgs.msg import Header


def _message(name, constants, **fields):
    def begin(self, **values):
        for field, make in fields.items():
            setattr(self, field, values.pop(field, make()))
        assert not values, f"{name} has no {values}"

    return type(name, (), {**constants, "__slots__": tuple(fields), "__init__": begin})


MESSAGES, SERVICES = (
    ModuleType("simulation_interfaces.msg"),
    ModuleType("simulation_interfaces.srv"),
)


def _add(name, constants=None, **fields):
    setattr(MESSAGES, name, _message(name, constants or {}, **fields))
    return getattr(MESSAGES, name)


_CODES = ("FEATURE_UNSUPPORTED", "OK", "NOT_FOUND", "INCORRECT_STATE", "OPERATION_FAILED")
_RESULTS = {f"RESULT_{name}": code for code, name in enumerate(_CODES)}
Result = _add("Result", _RESULTS, result=int, error_message=str)
_STATES = ("STOPPED", "PLAYING", "PAUSED", "QUITTING", "NO_WORLD", "LOADING_WORLD")
_NUMBERS = {f"STATE_{name}": code for code, name in enumerate(_STATES)}
SimulationState = _add("SimulationState", _NUMBERS, state=int)
EntityCategory = _add(
    "EntityCategory", {"CATEGORY_OBJECT": 0, "CATEGORY_ROBOT": 1, "CATEGORY_HUMAN": 2}, category=int
)
Bounds = _add("Bounds", {"TYPE_EMPTY": 0, "TYPE_BOX": 1, "TYPE_SPHERE": 3}, type=int, points=list)
TagsFilter = _add("TagsFilter", tags=list, filter_mode=int)
EntityFilters = _add("EntityFilters", filter=str, categories=list, tags=TagsFilter, bounds=Bounds)
EntityState = _add("EntityState", header=Header, pose=Pose, twist=Twist, acceleration=Accel)
EntityInfo = _add("EntityInfo", category=EntityCategory, description=str, tags=list)
SimulatorFeatures = _add(
    "SimulatorFeatures",
    {
        "SPAWNING": 0, "ENTITY_TAGS": 4, "ENTITY_BOUNDS": 5, "ENTITY_CATEGORIES": 8,
        "ENTITY_STATE_GETTING": 10, "ENTITY_STATE_SETTING": 11, "ENTITY_INFO_GETTING": 12,
        "SIMULATION_RESET": 20, "SIMULATION_RESET_TIME": 21, "SIMULATION_RESET_STATE": 22,
        "SIMULATION_RESET_SPAWNED": 23, "SIMULATION_STATE_GETTING": 24,
        "SIMULATION_STATE_SETTING": 25, "SIMULATION_STATE_PAUSE": 26, "STEP_SIMULATION_SINGLE": 31,
        "STEP_SIMULATION_MULTIPLE": 32, "STEP_SIMULATION_ACTION": 33,
    },
    features=list, spawn_formats=list, custom_info=str,
)  # fmt: skip

_TRANSITIONS = {
    "ALREADY_IN_TARGET_STATE": 101, "STATE_TRANSITION_ERROR": 102, "INCORRECT_TRANSITION": 103,
}  # fmt: skip
for _name, _asked, _constants, _answered in (
    ("GetSimulatorFeatures", {}, {}, {"features": SimulatorFeatures}),
    ("GetSimulationState", {}, {}, {"state": SimulationState, "result": Result}),
    ("SetSimulationState", {"state": SimulationState}, _TRANSITIONS, {"result": Result}),
    ("StepSimulation", {"steps": lambda: 1}, {}, {"result": Result}),
    ("ResetSimulation", {"scope": int}, {}, {"result": Result}),
    ("GetEntities", {"filters": EntityFilters}, {}, {"result": Result, "entities": list}),
    (
        "GetEntitiesStates",
        {"filters": EntityFilters},
        {},
        {"result": Result, "entities": list, "states": list},
    ),
    ("GetEntityState", {"entity": str}, {}, {"result": Result, "state": EntityState}),
    ("GetEntityInfo", {"entity": str}, {}, {"result": Result, "info": EntityInfo}),
    (
        "SetEntityState",
        {"entity": str, "state": EntityState, "set_pose": bool},
        {"INVALID_POSE": 101},
        {"result": Result},
    ),
):
    _kind = SimpleNamespace(
        Request=_message(f"{_name}Request", {}, **_asked),
        Response=_message(f"{_name}Response", _constants, **_answered),
    )
    setattr(SERVICES, _name, _kind)
