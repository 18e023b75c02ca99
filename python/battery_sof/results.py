"""What the functions of battery_sof return: plain values, named as in the JSON of the command `sof`."""

from dataclasses import dataclass, field, fields
from os import PathLike, fsencode
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, TypeVar, Union

import numpy as np

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


@dataclass(frozen=True)
class Parameter:
    """One estimated parameter."""

    name: str
    value: float  #: in unit
    unit: str  #: ohm, F, 1/V, V, ...
    std_error: Optional[float] = None  #: standard error in unit; None when nothing is known
    held: bool = False  #: not estimated
    at_bound: bool = False  #: ended at a bound
    determined: bool = True  #: by its window


@dataclass(frozen=True)
class CrankAnswer:
    """SOF1: the lowest voltage of a crank after a stop."""

    u_min: Optional[float]  #: [V]
    lower: Optional[float]  #: [V], of the 90 % interval
    upper: Optional[float]  #: [V]
    capable: Optional[bool]  #: lower is at least u_required; None when that was not given. Worth nothing unless valid
    valid: bool  #: the model may be relied on for this question; else the message begins with "not valid" and says why
    code: int  #: 0 ok, else as in the services
    message: str


@dataclass(frozen=True)
class StopTimeAnswer:
    """The longest stop after which a crank still holds a voltage."""

    t_stop: Optional[float]  #: [s]; None also for outcome "always"
    lower: Optional[float]  #: [s], of the 90 % interval; None also when infinite
    upper: Optional[float]  #: [s]
    outcome: Optional[str]  #: finite, at_least, always or never
    monotone: Optional[bool]  #: the crank's voltage falls with the length of the stop throughout
    valid: bool
    code: int
    message: str


@dataclass(frozen=True)
class ChargeAnswer:
    """SOF2: the mean current at a held voltage."""

    i_boost: Optional[float]  #: [A], positive into the battery
    lower: Optional[float]  #: [A], of the 90 % interval
    upper: Optional[float]  #: [A]
    valid: bool
    code: int
    message: str


@dataclass(frozen=True)
class CrankScore:
    """A measured crank with its prediction, an entry of Prediction.cranks.

    Attributes: time_s [s], of the lowest measured voltage; current_a [A], the crank's lowest, negative; measured_min_v and
    predicted_min_v [V], the lowest voltages; lower_v and upper_v [V], of the 90 % interval.
    """

    time_s: float  #: [s], of the lowest measured voltage
    current_a: float  #: [A], the crank's lowest, negative
    measured_min_v: float
    predicted_min_v: float
    lower_v: float  #: of the 90 % interval
    upper_v: float


@dataclass(frozen=True)
class Prediction:
    """A model's course through n samples of a recording. Arrays have the shape (n,), voltages in V, currents in A, positive
    into the battery. Where a source's voltage drives, predicted_v is the measured one and the current is predicted; elsewhere
    it is the other way round."""

    time_s: np.ndarray
    current_a: np.ndarray  #: measured
    voltage_v: np.ndarray  #: measured
    predicted_v: np.ndarray
    lower_v: np.ndarray  #: of the 90 % interval
    upper_v: np.ndarray
    predicted_a: np.ndarray
    lower_a: np.ndarray
    upper_a: np.ndarray
    voltage_controlled: np.ndarray  #: bool: the voltage drives this sample
    q_dyn_percent: Optional[float]  #: driven by the current alone; None when the voltage never changes
    rmse_v: float  #: [V], driven by the current alone
    max_abs_v: float  #: [V]
    coverage_90: float  #: share of the samples inside the 90 % band
    crank_mae_v: Optional[float]  #: [V]; None without cranks
    cranks: List[CrankScore]  #: one a crank, in order of time
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof predict`


@dataclass(frozen=True)
class Effect:
    """A piece of physics that a diagnosis found missing."""

    id: str
    title: str
    mechanism: Optional[str]
    confidence: float
    probability: float
    biased_parameters: List[str]  #: parameters of the base model that had taken it up
    parameters: List[Parameter]


@dataclass(frozen=True)
class Candidate:
    """A piece of physics that was weighed."""

    id: str
    title: str
    mechanism: Optional[str]
    evidence: float  #: [nat]
    confidence: float  #: [0, 1]
    holdout_gain_percent: Optional[float]
    rejected_because: str  #: empty when it was named


@dataclass(frozen=True)
class Mismatch:
    """A stretch where base model and measurement deviate."""

    from_s: float
    to_s: float
    regime: str
    mean_error_v: float  #: measured less modelled
    peak_error_v: float
    p_value: Optional[float]


@dataclass(frozen=True)
class Metrics:
    """How a model does on a part of a recording."""

    q_dyn_percent: Optional[float]
    rmse_v: Optional[float]
    max_abs_v: Optional[float]
    crank_mae_v: Optional[float]
    charge_bias_v: Optional[float]
    charge_current_error_a: Optional[float]


@dataclass(frozen=True)
class Diagnosis:
    """Where the base model and n samples of a recording deviate, and which physics is missing. Arrays have the shape (n,); the
    voltages are empty, and metrics None, for insufficient_data."""

    verdict: str  #: no_mismatch, effect, several, ambiguous, mechanism, unexplained, sensor_fault or insufficient_data
    summary: str
    mechanism: Optional[str]
    probability: float
    effects: List[Effect]
    candidates: List[Candidate]
    mismatch: List[Mismatch]
    next_experiment: str
    base_train: Optional[Metrics]
    base_holdout: Optional[Metrics]
    extended_train: Optional[Metrics]
    extended_holdout: Optional[Metrics]
    base: "Model" = field(repr=False)  #: fitted to the training part
    extended: "Model" = field(repr=False)  #: with what was found; equals base when nothing was added
    time_s: np.ndarray = field(repr=False)
    base_voltage_v: np.ndarray = field(repr=False)
    extended_voltage_v: np.ndarray = field(repr=False)
    text: str = field(repr=False)  #: as `sof diagnose` prints it
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof diagnose`
    _core: "_core.Diagnosis" = field(repr=False, compare=False)

    def write_page(self, path: Union[str, "PathLike[str]"]) -> None:
        """Writes the diagnosis as one HTML page that needs no network; whole or not at all."""
        self._core.write_page(encoded(path))


@dataclass(frozen=True)
class Change:
    """What has changed since a reference."""

    id: str
    kind: str  #: effect, or parameter of the model
    mechanism: str
    then: float  #: in unit
    now: float  #: in unit
    unit: str
    interval: List[float]  #: 90 % interval of now, lower and upper end
    probability: float
    indistinguishable: List[str]  #: ids that these recordings cannot tell it from


@dataclass(frozen=True)
class ChangeDiagnosis:
    """What has changed in a battery or its instruments since a reference."""

    verdict: str  #: no_change, changed, another_battery or insufficient_data
    summary: str
    changes: List[Change]  #: likeliest first; empty but for changed
    text: str = field(repr=False)  #: as `sof diagnose --reference` prints it
    details: Dict[str, Any] = field(repr=False)  #: the whole JSON of `sof diagnose --reference`
