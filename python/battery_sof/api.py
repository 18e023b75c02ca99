"""Recordings, models and queries. The text of every ValueError is the sentence of the core."""

import hashlib
import json
from os import PathLike, fsencode
from os.path import isfile
from typing import Any, Dict, List, Optional, Sequence, Union, overload

import numpy as np
import numpy.typing as npt

from . import _core
from .results import (Candidate, Change, ChangeDiagnosis, ChargeAnswer, CrankAnswer, CrankScore, Diagnosis, Effect, Metrics,
                      Mismatch, Parameter, Prediction, StopTimeAnswer, encoded, made, numbers)

Path = Union[str, "PathLike[str]"]
Numbers = npt.ArrayLike


class Recording:
    """Current and voltage of one battery over time, as n accepted samples.

    Attributes: name; time_s [s], current_a [A, positive into the battery] and voltage_v [V], which are copies with the shape (n,);
    offered, the number of samples in the source; rejected, the number of refused samples for each reason.
    """

    name: str
    time_s: np.ndarray
    current_a: np.ndarray
    voltage_v: np.ndarray
    offered: int
    rejected: Dict[str, int]

    def __init__(self, time_s: Numbers, current_a: Numbers, voltage_v: Numbers, temperature_c: Optional[Numbers] = None,
                 name: str = "arrays") -> None:
        """Makes a recording from arrays that all have the shape (m,).

        time_s [s] increases; current_a [A] is positive into the battery; voltage_v [V] is measured at the terminals;
        temperature_c [degC] may be NaN where it was not measured. Masked values are missing, like NaN. Invalid samples (NaN, a
        clock that steps back, more than 5000 A or 100 V) are refused and counted.

        Raises ValueError if the shapes differ, if more than a tenth of the samples go back in time, or if no sample is usable.
        """
        temperature = None if temperature_c is None else numbers(temperature_c)
        self._hold(_core.Recording.from_arrays(numbers(time_s), numbers(current_a), numbers(voltage_v), temperature,
                                               fsencode(name)))

    @classmethod
    def from_csv(cls, path: Path, *, time_column: str = "time_s", current_column: str = "current_a",
                 voltage_column: str = "voltage_v", temperature_column: Optional[str] = None,
                 discharge_positive: bool = False, time_unit_s: Optional[float] = None) -> "Recording":
        """Reads a recording from a CSV file with a header line.

        The columns contain time [s, or UTC date and time], current [A], voltage [V] and, optionally, temperature [degC].
        discharge_positive: the file counts current out of the battery as positive. time_unit_s: unit of the time column, for
        example 0.001 if it is in milliseconds; without it that of its name or of a row of units, else a second.

        Raises ValueError with the file, line and column that cannot be read.
        """
        recording = cls.__new__(cls)
        recording._hold(_core.Recording.from_csv(encoded(path), time_column, current_column, voltage_column,
                                                 temperature_column, discharge_positive, time_unit_s, _hash(path)))
        return recording

    def _hold(self, core: _core.Recording) -> None:
        self._core = core
        self.name, self.offered, self.rejected = core.name, core.offered, core.rejected
        self.time_s, self.current_a, self.voltage_v = core.time_s, core.current_a, core.voltage_v

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        return f"Recording({self.name!r}, {len(self)} samples, {self.time_s[0]:g} to {self.time_s[-1]:g} s)"


class Model:
    """A fitted model with the state at which a query begins. identify(), diagnose() and Model.read() return one.

    Attributes: parameters, by name; effects, ids of the effects in the model; from_s, to_s and samples of its window; status and
    message; usable, whether it can answer queries; q_dyn_percent; rmse_v [V] over the window; window_quality [0, 1];
    state_time_s [s], the time of its state; covariance, shape (k, k), of the parameters in their order followed by the states
    [units squared]. If nothing was fitted, q_dyn_percent, rmse_v and state_time_s are None.
    """

    parameters: Dict[str, Parameter]
    effects: List[str]
    from_s: float
    to_s: float
    samples: int
    status: str
    message: str
    usable: bool
    q_dyn_percent: Optional[float]
    rmse_v: Optional[float]
    window_quality: float
    state_time_s: Optional[float]
    covariance: np.ndarray

    def __init__(self, core: _core.Model) -> None:
        self._core = core
        self.details: Dict[str, Any] = json.loads(core.json())  #: the whole JSON of `sof identify`
        self.parameters = {each["name"]: made(Parameter, each) for each in self.details["parameters"]}
        self.from_s, self.to_s = self.details["window"]["from_s"], self.details["window"]["to_s"]
        for name in ("effects", "samples", "status", "message", "q_dyn_percent", "rmse_v", "window_quality"):
            setattr(self, name, self.details[name])
        self.state_time_s = self.details["state"]["time_s"]
        self.usable, self.covariance = core.usable, core.covariance

    @classmethod
    def read(cls, path: Path) -> "Model":
        """Reads a MODEL.yaml that this module or `sof identify` wrote. Raises ValueError with the field that is wrong."""
        return cls(_core.Model.read(encoded(path)))

    def save(self, path: Path) -> None:
        """Writes MODEL.yaml, whole or not at all. `sof` and the node read this file, too.

        Raises ValueError if the model is not usable, and RuntimeError if the file cannot be written.
        """
        self._core.write(encoded(path))

    def rested(self) -> "Model":
        """Returns the same model after a rest that is long enough for every state to settle."""
        return Model(self._core.rested())

    def __repr__(self) -> str:
        return f"Model({self.status}, {self.from_s:g} to {self.to_s:g} s, effects {self.effects})"


def identify(recording: Recording, *, from_s: Optional[float] = None, to_s: Optional[float] = None,
             choose_window: bool = False, effects: Optional[Sequence[str]] = None,
             start: str = "robust", series_blocks: float = 1.0, threads: int = 1, anyway: bool = False,
             crank_current_a: Optional[float] = None, capacity_ah: Optional[float] = None) -> Model:
    """Fits the model to a window of a recording, as `sof identify` does.

    from_s, to_s [s]: the window if both are given, otherwise the range in which the best window is chosen (with choose_window also
    if both are given). The state of the model is that of to_s, or of the end of the recording. effects: ids of the effects to add;
    None lets the recording choose, [] is the base model. start: "robust" or "paper".
    series_blocks: number of 12 V blocks in series (0.5 for 6 V, 2 for 24 V, 4 for 48 V). The fit is that of the mean block, while
    queries, answers and predictions are in the volts of the whole battery. threads: 0 for all; it changes no result.
    crank_current_a: discharges by this many amperes or more, for at most 5 s, are engine starts; None reads it off the recording.
    capacity_ah: nominal capacity [Ah], above 0. A window that moved a tenth of it calls for the open-circuit voltage (effects), and where a
    discharge ends is fitted with what is known of it. None: a tenth of 50 Ah, and nothing is known.

    If the window determines no model, the returned model is not usable and its message has the reason. The same holds for a
    recording with a problem, for example a flipped sign or another time unit, unless anyway is true. Raises ValueError for a range
    without samples, an unknown effect, or an option that is out of range.
    """
    return Model(_core.identify(recording._core, from_s, to_s, choose_window, None if effects is None else list(effects),
                                start, series_blocks, threads, anyway, crank_current_a, capacity_ah))


def predict(model: Model, recording: Recording, *, from_s: Optional[float] = None, to_s: Optional[float] = None,
            mode: Optional[str] = None, crank_current_a: Optional[float] = None) -> Prediction:
    """Runs a model through a recording from from_s to to_s [s] and scores it, as `sof predict` does.

    mode: "mixed" takes the voltage as the input where a source controls it, "current" takes the current throughout, and None does
    as the model was fitted. A recording above 200 Hz is predicted at 100 Hz. crank_current_a: as in identify(); None takes the
    model's.

    Raises ValueError if the model is not usable, if the range has no sample, or if "mixed" is given and no source is detected.
    """
    arrays, text = _core.predict(model._core, recording._core, from_s, to_s, mode, crank_current_a)
    details = json.loads(text)
    return made(Prediction, details, cranks=[made(CrankScore, each) for each in details["cranks"]], details=details,
                **arrays)


def crank(model: Model, *, i_load: float, t_stop: float, i_cranking: float, t_cranking: float = 1.0,
          u_required: Optional[float] = None, capacity_ah: Optional[float] = None, rested: bool = False) -> CrankAnswer:
    """SOF1: lowest voltage of a crank of i_cranking [A, below 0] for t_cranking [s] after a stop of t_stop [s] at i_load [A, at
    most 0], and whether it holds u_required [V]. Use the answer only if it is valid; otherwise its message says why it is not.

    The event begins at the model's state, or from a rested battery if rested is true. capacity_ah: nominal capacity [Ah], above 0;
    None: as it was given to identify(), else 50.
    Raises ValueError for a query that is out of range.
    """
    return made(CrankAnswer, json.loads(_core.crank(_begun(model, rested), i_load, t_stop, i_cranking, t_cranking, u_required,
                                                    capacity_ah)))


def stop_time(model: Model, *, i_load: float, i_cranking: float, u_required: float, t_cranking: float = 1.0,
              capacity_ah: Optional[float] = None, rested: bool = False) -> StopTimeAnswer:
    """Longest stop [s] at i_load [A, at most 0] after which a crank of i_cranking [A, below 0] for t_cranking [s] still holds
    u_required [V].

    The stop begins at the model's state, or from a rested battery if rested is true. capacity_ah: nominal capacity [Ah], above 0;
    None: as it was given to identify(), else 50.
    Raises ValueError for a query that is out of range.
    """
    return made(StopTimeAnswer, json.loads(_core.stop_time(_begun(model, rested), i_load, i_cranking, t_cranking, u_required,
                                                           capacity_ah)))


def charge(model: Model, *, u_boost: float, t_sof2: float = 10.0, i_limit: float = 5000.0,
           capacity_ah: Optional[float] = None, rested: bool = False) -> ChargeAnswer:
    """SOF2: mean current [A, positive into the battery] over t_sof2 [s] at the held voltage u_boost [V] from a source that gives
    at most i_limit [A].

    The charge begins at the model's state, or from a rested battery if rested is true. capacity_ah: nominal capacity [Ah], above 0;
    None: as it was given to identify(), else 50.
    Raises ValueError for a query that is out of range.
    """
    return made(ChargeAnswer, json.loads(_core.charge(_begun(model, rested), u_boost, t_sof2, i_limit, capacity_ah)))


@overload
def diagnose(recording: Recording, *, from_s: Optional[float] = None, to_s: Optional[float] = None,
             holdout_share: float = 0.25, hypotheses: Sequence[str] = (), given: Sequence[str] = (),
             series_blocks: float = 1.0, threads: int = 1, anyway: bool = False,
             crank_current_a: Optional[float] = None, capacity_ah: Optional[float] = None) -> Diagnosis: ...


@overload
def diagnose(recording: Recording, *, reference: Union[Recording, Model, Sequence[Union[Recording, Model]]],
             from_s: Optional[float] = None, to_s: Optional[float] = None, anyway: bool = False) -> ChangeDiagnosis: ...


def diagnose(recording: Recording, *, reference: Union[Recording, Model, Sequence[Union[Recording, Model]], None] = None,
             from_s: Optional[float] = None, to_s: Optional[float] = None,
             holdout_share: float = 0.25, hypotheses: Sequence[str] = (), given: Sequence[str] = (),
             series_blocks: float = 1.0, threads: int = 1, anyway: bool = False,
             crank_current_a: Optional[float] = None, capacity_ah: Optional[float] = None) -> Union[Diagnosis, ChangeDiagnosis]:
    """Finds where the base model and a recording deviate and which physics is missing, as `sof diagnose` does. This takes minutes.

    from_s, to_s [s]: the range that is diagnosed; its last holdout_share is kept for the comparison alone. hypotheses: ids of the
    effects to consider; empty for all. given: ids of effects that are known to be present; nothing is searched for. series_blocks:
    number of 12 V blocks in series, as in identify(); volts and ohms in the result are those of one block. threads: 0 for all; it
    changes no result. anyway: also diagnose a recording with a problem, as in identify(). crank_current_a: as in identify().
    capacity_ah: nominal capacity [Ah], above 0, of which a tenth calls for the open-circuit voltage; None: 50.

    reference: one or more recordings of the same battery from when it was sound, or models that were identified from such. What
    has changed since is found instead, as `sof diagnose --reference` does, and a ChangeDiagnosis comes back; from_s, to_s and
    anyway alone go with it.

    Raises ValueError for a range without samples, an unknown id, or an option that is out of range.
    """
    if reference is not None:
        if (holdout_share, list(hypotheses), list(given), series_blocks, crank_current_a, capacity_ah) != (
                0.25, [], [], 1.0, None, None):
            raise ValueError("reference is given, expected without holdout_share, hypotheses, given, series_blocks, "
                             "crank_current_a and capacity_ah")
        references = [reference] if isinstance(reference, (Recording, Model)) else list(reference)
        if not references:
            raise ValueError("reference is empty, expected at least one recording or model")
        recordings = [one._core for one in references if isinstance(one, Recording)]
        models = [one._core for one in references if isinstance(one, Model)]
        answer, text = _core.diagnose_change(recording._core, recordings, models, from_s, to_s, anyway)
        told = json.loads(answer)
        return made(ChangeDiagnosis, told, changes=[made(Change, one) for one in told["changes"]], text=text, details=told)
    core = _core.diagnose(recording._core, from_s, to_s, holdout_share, list(hypotheses), list(given), series_blocks,
                          threads, anyway, crank_current_a, capacity_ah)
    details = json.loads(core.json())
    effects = [made(Effect, each, parameters=[made(Parameter, one, std_error=one["std"]) for one in each["parameters"]])
               for each in details["effects"]]
    return made(Diagnosis, details, effects=effects, candidates=[made(Candidate, each) for each in details["candidates"]],
                mismatch=[made(Mismatch, each) for each in details["mismatch"]], **_metrics(details), base=Model(core.base()),
                extended=Model(core.extended()), time_s=core.time_s(), base_voltage_v=core.base_voltage(),
                extended_voltage_v=core.extended_voltage(), text=core.text(), details=details, _core=core)


def version() -> str:
    """Returns the version of the core."""
    return _core.version()


def _begun(model: Model, rested: bool) -> _core.Model:
    """Returns the model with the state at which a query begins."""
    return model._core.rested() if rested else model._core


def _hash(path: Path) -> str:
    """sha256 of a file, as MODEL.yaml names it; empty when it cannot be read, which reading it will say, and of a pipe, read once."""
    digest = hashlib.sha256()
    if not isfile(path):
        return ""
    try:
        with open(path, "rb") as file:
            for block in iter(lambda: file.read(1 << 16), b""):
                digest.update(block)
    except OSError:
        return ""
    return "sha256:" + digest.hexdigest()


def _metrics(details: Dict[str, Any]) -> Dict[str, Optional[Metrics]]:
    fit = details.get("fit") or {}
    return {f"{model}_{part}": made(Metrics, fit[model][part]) if (fit.get(model) or {}).get(part) else None
            for model in ("base", "extended") for part in ("train", "holdout")}
