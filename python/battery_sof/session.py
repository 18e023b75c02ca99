"""A battery that is followed while it is in use, as the node does, but without ROS."""

import json
from typing import Optional

import numpy as np

from . import _core
from .api import Model, Numbers
from .results import ChargeAnswer, CrankAnswer, StopTimeAnswer, made, numbers


class Session:
    """Follows a battery sample by sample and answers questions that begin at the newest one.

    A session has no threads and reads no clock: time is that of the samples, and identify_when_due() takes seconds when a fit is
    due. Use it from one thread at a time.
    """

    def __init__(self, *, capacity_ah: Optional[float] = None, series_blocks: float = 1.0, buffer_s: float = 1800.0,
                 window_s: Optional[float] = None) -> None:
        """capacity_ah: nominal capacity [Ah], above 0; None: 50 Ah, and the fit knows nothing of it. series_blocks: number of 12 V
        blocks in series; samples, questions and answers are those of all of them. buffer_s [s]: length of the past that is kept.
        window_s [s]: length of the fitted window; None chooses it by the sampling rate.

        Raises ValueError for a setting that is out of range.
        """
        self._core = _core.Session(capacity_ah, series_blocks, buffer_s, window_s)

    def push(self, time_s: Numbers, current_a: Numbers, voltage_v: Numbers, temperature_c: Optional[Numbers] = None) -> None:
        """Processes one sample, or several as arrays of the same size; invalid ones are refused, as Recording does.

        Raises ValueError if the sizes differ.
        """
        temperature = None if temperature_c is None else _flat(temperature_c)
        self._core.push(_flat(time_s), _flat(current_a), _flat(voltage_v), temperature)

    def identify_when_due(self) -> Optional[str]:
        """Identifies if an identification is due. Returns one sentence on the outcome, or None if none was due."""
        return self._core.identify_when_due()

    def restore(self, model: Model) -> None:
        """Takes the model of an earlier drive, which is compared with the first samples that arrive."""
        self._core.restore(model._core)

    @property
    def model(self) -> Optional[Model]:
        """The model that answers, with its state at the newest sample; None before the first one."""
        core = self._core.model()
        return None if core is None else Model(core)

    @property
    def reason(self) -> str:
        """One sentence: why there is no answer, or the outcome of the last identification."""
        return self._core.reason()

    def crank(self, *, i_load: float, t_stop: float, i_cranking: float, t_cranking: float = 1.0,
              u_required: Optional[float] = None) -> CrankAnswer:
        """SOF1 from now on, as crank() answers it. Raises ValueError for a query that is out of range."""
        return made(CrankAnswer, json.loads(self._core.crank(i_load, t_stop, i_cranking, t_cranking, u_required)))

    def stop_time(self, *, i_load: float, i_cranking: float, u_required: float, t_cranking: float = 1.0) -> StopTimeAnswer:
        """The longest stop from now on, as stop_time() answers it. Raises ValueError for a query that is out of range."""
        return made(StopTimeAnswer, json.loads(self._core.stop_time(i_load, i_cranking, t_cranking, u_required)))

    def charge(self, *, u_boost: float, t_sof2: float = 10.0, i_limit: float = 5000.0) -> ChargeAnswer:
        """SOF2 from now on, as charge() answers it. Raises ValueError for a query that is out of range."""
        return made(ChargeAnswer, json.loads(self._core.charge(u_boost, t_sof2, i_limit)))


def _flat(values: Numbers) -> np.ndarray:
    return np.atleast_1d(numbers(values))
