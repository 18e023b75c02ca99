"""What the functions of battery_sof return: plain values, named as in the JSON of the command `sof`."""

from dataclasses import dataclass, field, fields
from os import PathLike, fsencode
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from . import _core
    from .api import Model

_Result = TypeVar("_Result")


def made(kind: Type[_Result], json: Dict[str, Any], **more: Any) -> _Result:
    """A result of a kind from the entries of a JSON object that have its fields' names."""
    names = {each.name for each in fields(kind)}  # type: ignore[arg-type]
    return kind(**{name: value for name, value in json.items() if name in names and name not in more}, **more)


def encoded(path: Union[str, "PathLike[str]"]) -> bytes:
    """The bytes of a file's name, whatever they are. Raises ValueError for a null byte, which no name has."""
    name = fsencode(path)
    if b"\0" in name:
        raise ValueError(f"the path {path!r} has a null byte in it, expected none")
    return name


def numbers(values: npt.ArrayLike) -> np.ndarray:
    """The values, NaN where they are masked."""
    return np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)


@dataclass(frozen=True)
class Parameter:
    """One estimated parameter."""

    name: str  #: for example r_discharge
    value: float  #: in unit
    unit: str  #: ohm, F, 1/V, V, ...
    std_error: Optional[float] = None  #: standard error in unit; None if it is not known
    held: bool = False  #: was not estimated and keeps its value
    at_bound: bool = False  #: the search ended at a bound
    determined: bool = True  #: the window determines it: the standard error is below half the value, and it is not at a bound


@dataclass(frozen=True)
class CrankAnswer:
    """SOF1: the lowest voltage of a crank after a stop."""

    u_min: Optional[float]  #: [V], lowest voltage of the crank; None if there is no answer
    lower: Optional[float]  #: [V], lower end of the 90 % interval
    upper: Optional[float]  #: [V], upper end of the 90 % interval
    capable: Optional[bool]  #: lower is at least u_required; None if u_required was not given. Use it only if the answer is valid
    valid: bool  #: the recorded driving covers the question; if not, the message begins with "not valid" and gives the reason
    code: int  #: 0 if valid, else one of the codes of the node's services
    message: str  #: one sentence with the numbers


@dataclass(frozen=True)
class StopTimeAnswer:
    """The longest stop after which a crank still holds a voltage."""

    t_stop: Optional[float]  #: [s]; None if there is no answer, and for the outcome "always"
    lower: Optional[float]  #: [s], lower end of the 90 % interval; None if it is infinite
    upper: Optional[float]  #: [s], upper end of the 90 % interval; None if it is infinite
    outcome: Optional[str]  #: finite, at_least, always or never
    monotone: Optional[bool]  #: the crank's voltage falls with the length of the stop throughout
    valid: bool  #: as in CrankAnswer
    code: int  #: as in CrankAnswer
    message: str  #: one sentence with the numbers


@dataclass(frozen=True)
class ChargeAnswer:
    """SOF2: the mean current at a held voltage."""

    i_boost: Optional[float]  #: [A], mean current, positive into the battery; None if there is no answer
    lower: Optional[float]  #: [A], lower end of the 90 % interval
    upper: Optional[float]  #: [A], upper end of the 90 % interval
    valid: bool  #: as in CrankAnswer
    code: int  #: as in CrankAnswer
    message: str  #: one sentence with the numbers


@dataclass(frozen=True)
class CrankScore:
    """A measured crank with its prediction, an entry of Prediction.cranks.

    Attributes: time_s [s], of the lowest measured voltage; current_a [A], the crank's lowest, negative; measured_min_v and
    predicted_min_v [V], the lowest voltages; lower_v and upper_v [V], the ends of the 90 % interval.
    """

    time_s: float  #: [s], of the lowest measured voltage
    current_a: float  #: [A], the crank's lowest, negative
    measured_min_v: float  #: [V], lowest measured voltage
    predicted_min_v: float  #: [V], lowest predicted voltage
    lower_v: float  #: [V], lower end of the 90 % interval
    upper_v: float  #: [V], upper end of the 90 % interval


@dataclass(frozen=True)
class Prediction:
    """What a model predicts for n samples of a recording. Arrays have the shape (n,), voltages are in V, and currents in A,
    positive into the battery. While a charger controls the voltage, the voltage is the input of the model: predicted_v is then
    the measured voltage, and the current is predicted. Elsewhere it is the other way round."""

    time_s: np.ndarray  #: [s], on the recording's clock
    current_a: np.ndarray  #: [A], measured
    voltage_v: np.ndarray  #: [V], measured
    predicted_v: np.ndarray  #: [V]
    lower_v: np.ndarray  #: [V], lower end of the 90 % interval
    upper_v: np.ndarray  #: [V], upper end of the 90 % interval
    predicted_a: np.ndarray  #: [A]
    lower_a: np.ndarray  #: [A], lower end of the 90 % interval
    upper_a: np.ndarray  #: [A], upper end of the 90 % interval
    voltage_controlled: np.ndarray  #: bool: the voltage is the input of the model at this sample
    q_dyn_percent: Optional[float]  #: [%], with the current as the only input; None if the voltage never changes
    rmse_v: float  #: [V], with the current as the only input
    max_abs_v: float  #: [V], largest error
    coverage_90: float  #: [0, 1], share of the samples inside the 90 % interval
    crank_mae_v: Optional[float]  #: [V], mean absolute error of the cranks' lowest voltages; None without cranks
    cranks: List[CrankScore]  #: one entry for each crank, in order of time
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof predict`


@dataclass(frozen=True)
class Effect:
    """An effect that a diagnosis found to be missing."""

    id: str  #: as in the catalogue of effects
    title: str  #: the effect in words
    mechanism: Optional[str]  #: the kind of physics that it belongs to
    confidence: float  #: [0, 1], the probability, shared among the effects that are indistinguishable from it
    probability: float  #: [0, 1], that its mechanism is the one that is missing
    biased_parameters: List[str]  #: parameters of the base model that were biased because the effect was missing
    parameters: List[Parameter]  #: its own parameters


@dataclass(frozen=True)
class Candidate:
    """An effect that a diagnosis considered."""

    id: str  #: as in the catalogue of effects
    title: str  #: the effect in words
    mechanism: Optional[str]  #: the kind of physics that it belongs to
    evidence: float  #: [nat], logarithm of the odds that it improves the model
    confidence: float  #: [0, 1]
    holdout_gain_percent: Optional[float]  #: [%], reduction of the error on the hold-out; None if it was not accepted
    rejected_because: str  #: the reason; empty if it was accepted


@dataclass(frozen=True)
class Mismatch:
    """A stretch of the recording in which the base model deviates far more than in most minutes."""

    from_s: float  #: [s], its first sample
    to_s: float  #: [s], its last sample
    regime: str  #: what the battery was doing
    mean_error_v: float  #: [V], measured minus modelled; while a source controls the voltage, the current's times -10 mOhm
    peak_error_v: float  #: [V], the error of largest magnitude, with its sign
    p_value: Optional[float]  #: [0, 1], that the worst minute of a recording stands out so far by chance


@dataclass(frozen=True)
class Metrics:
    """Errors of a model over a part of a recording."""

    q_dyn_percent: Optional[float]  #: [%], 100 (1 - RMS error / standard deviation of the voltage)
    rmse_v: Optional[float]  #: [V], RMS error
    max_abs_v: Optional[float]  #: [V], largest error
    crank_mae_v: Optional[float]  #: [V], mean absolute error of the cranks' lowest voltages; None without cranks
    charge_bias_v: Optional[float]  #: [V], mean of measured minus modelled over charges; None without charges
    charge_current_error_a: Optional[float]  #: [A], mean absolute error of the current at the measured voltage over charges


@dataclass(frozen=True)
class Diagnosis:
    """Where the base model and n samples of a recording deviate, and which physics is missing. Arrays have the shape (n,); the
    voltages are empty, and metrics None, for insufficient_data."""

    verdict: str  #: no_mismatch, effect, several, ambiguous, mechanism, unexplained, sensor_fault or insufficient_data
    summary: str  #: the verdict in words
    mechanism: Optional[str]  #: of the verdict; None if nothing is missing, or nothing fits
    probability: float  #: [0, 1], that this mechanism is what the circuit lacks
    effects: List[Effect]  #: the effects that the verdict names
    candidates: List[Candidate]  #: the effects that were considered, best first
    mismatch: List[Mismatch]  #: where base model and measurement deviate
    next_experiment: str  #: what to record in order to decide what is still open
    base_train: Optional[Metrics]  #: errors of the base model on the training part
    base_holdout: Optional[Metrics]  #: errors of the base model on the hold-out
    extended_train: Optional[Metrics]  #: errors of the extended model on the training part
    extended_holdout: Optional[Metrics]  #: errors of the extended model on the hold-out
    base: "Model" = field(repr=False)  #: the base model, fitted to the training part
    extended: "Model" = field(repr=False)  #: the base model with what was found; equal to base if nothing was added
    time_s: np.ndarray = field(repr=False)  #: [s], of the samples
    base_voltage_v: np.ndarray = field(repr=False)  #: [V], voltage of the base model
    extended_voltage_v: np.ndarray = field(repr=False)  #: [V], voltage of the extended model
    text: str = field(repr=False)  #: as `sof diagnose` prints it
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof diagnose`
    _core: "_core.Diagnosis" = field(repr=False, compare=False)

    def write_page(self, path: Union[str, "PathLike[str]"]) -> None:
        """Writes the diagnosis as one HTML page that needs no network; whole or not at all."""
        self._core.write_page(encoded(path))


@dataclass(frozen=True)
class Change:
    """What has changed since a reference."""

    id: str  #: of the change, for example contact_resistance
    kind: str  #: effect, or parameter of the model
    mechanism: str  #: the kind of physics that it belongs to
    then: float  #: in unit
    now: float  #: in unit
    unit: str  #: ohm, A, s or 1
    interval: List[float]  #: 90 % interval of now, lower and upper end
    probability: float  #: [0, 1]
    indistinguishable: List[str]  #: ids that these recordings cannot distinguish from it


@dataclass(frozen=True)
class ChangeDiagnosis:
    """What has changed in a battery or its instruments since a reference."""

    verdict: str  #: no_change, changed, another_battery or insufficient_data
    summary: str  #: the verdict in words
    changes: List[Change]  #: likeliest first; empty unless the verdict is changed
    text: str = field(repr=False)  #: as `sof diagnose --reference` prints it
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof diagnose --reference`
