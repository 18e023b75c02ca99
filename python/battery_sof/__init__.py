"""What a vehicle's 12 V battery can still do, from the current and voltage of driving.

Units are SI (V, A, s, Ohm, F); current is positive into the battery, so loads and cranks are negative. Times are seconds on
the recording's own clock.

    import battery_sof

    recording = battery_sof.Recording(time_s, current_a, voltage_v)
    model = battery_sof.identify(recording, from_s=0.0, to_s=240.0)
    answer = battery_sof.crank(model, i_load=-15.0, t_stop=60.0, i_cranking=-250.0, u_required=7.2)
    print(answer.u_min, answer.capable if answer.valid else answer.message)

A question is only answered as far as the window went: the message of another begins with "not valid" and says why.

In a build with ROS the messages are in the same package (battery_sof.msg, battery_sof.srv); who imports those alone does
not load the core.
"""

from typing import TYPE_CHECKING, Any, List

if TYPE_CHECKING:
    from .api import (Model, Recording, charge, crank, diagnose, identify, predict, stop_time, version)
    from .results import (Candidate, Change, ChangeDiagnosis, ChargeAnswer, CrankAnswer, CrankScore, Diagnosis, Effect, Metrics,
                          Mismatch, Parameter, Prediction, StopTimeAnswer)
    from .session import Session

_PLACES = {
    **dict.fromkeys(("Model", "Recording", "charge", "crank", "diagnose", "identify", "predict", "stop_time", "version"),
                    "api"),
    **dict.fromkeys(("Candidate", "Change", "ChangeDiagnosis", "ChargeAnswer", "CrankAnswer", "CrankScore", "Diagnosis", "Effect",
                     "Metrics", "Mismatch", "Parameter", "Prediction", "StopTimeAnswer"), "results"),
    "Session": "session",
}
__all__ = sorted(_PLACES)


def __getattr__(name: str) -> Any:
    from importlib import import_module
    if name in _PLACES.values():
        return import_module("." + name, __name__)
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("." + _PLACES[name], __name__), name)


def __dir__() -> List[str]:
    return sorted({*globals(), *__all__, *_PLACES.values()})
