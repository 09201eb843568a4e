"""Families of waveforms: the keys of [motion] that each needs, and the motions they become.

Waveforms of one family share kernels, so that lanes of one case may mix them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, cast

import numpy as np
import numpy.typing as npt

from warprock.case.run import DURATION
from warprock.model.harmonic import harmonic_motions
from warprock.model.lane_motion import Control, Waveform
from warprock.model.loads import push_motions
from warprock.model.modulated import mavroeidis_papageorgiou_motions, modulated_peak_acceleration
from warprock.model.pulse import PulseMotions
from warprock.model.record_motion import RecordMotions
from warprock.model.ricker import ricker_motions, ricker_peak_acceleration
from warprock.model.tilt import STEEPEST, steady, tilt_motions
from warprock.units import GRAVITY, Dimension

Array = npt.NDArray[np.float64]

_DERIVATIVE = {Control.DISPLACEMENT: 0, Control.VELOCITY: 1, Control.ACCELERATION: 2}
"""Control -> how often displacement was differentiated to reach it."""
_WRITTEN = {Dimension.LENGTH: 0, Dimension.VELOCITY: 1, Dimension.ACCELERATION: 2}
"""Dimension of an amplitude -> the same."""


class Values(Protocol):
    """Values of a case lane by lane, as `values.LaneValues` gives them."""

    def given(self, key: str) -> bool:
        """Whether the case gives a key."""

    def numbers(self, key: str) -> Array:
        """Values of a numeric key, SI units or rad, shape [lane]."""

    def dimension(self, key: str) -> Dimension:
        """What the values of a key measure."""

    def texts(self, key: str) -> tuple[tuple[str, ...], npt.NDArray[np.int32]]:
        """Distinct texts of a key, and the index of each lane's among them, shape [lane]."""

    def refuse(self, bad: npt.NDArray[np.bool_], key: str, allowed: str) -> None:
        """Refuses the first lane in which a key is wrong."""


class Followed(NamedTuple):
    """What lanes follow.

    Attributes:
        motions: Their ground motions.
        peak: Largest acceleration of each [m/s^2], shape [lane].
    """

    motions: PulseMotions | RecordMotions
    peak: Array


@dataclasses.dataclass(frozen=True)
class Family:
    """Waveforms that share their keys.

    Attributes:
        waveforms: The waveforms.
        needs: Keys of [motion] that must be given with them.
        may: Keys that may be given.
        shown: Keys that the lane table shows, in its order.
        follow: Makes motions of the values of a table of a case and of the start times [s]; None of
            records, which are read from files.
    """

    waveforms: tuple[Waveform, ...]
    needs: tuple[str, ...]
    may: tuple[str, ...]
    shown: tuple[str, ...]
    follow: Callable[[Values, str, Array], Followed] | None

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that they have a use for."""
        return self.needs + self.may


def _texts(values: Values, key: str) -> npt.NDArray[np.str_]:
    """Texts of a key, shape [lane]."""
    names, codes = values.texts(key)
    return np.array(names)[codes]


def _order(control: npt.NDArray[np.str_]) -> npt.NDArray[np.intp]:
    """How often displacement was differentiated to reach the control, shape [lane]."""
    names, codes = np.unique(control, return_inverse=True)
    return np.array([_DERIVATIVE[Control(name)] for name in names], dtype=np.intp)[codes]


def _harmonic(values: Values, table: str, start: Array) -> Followed:
    """Sines and cosines.

    With w = 2 pi frequency, an amplitude of another kind than the control is the amplitude that
    a sine of that frequency has: displacement x w = velocity, velocity x w = acceleration.
    """
    waveform, control = _texts(values, f"{table}.waveform"), _texts(values, f"{table}.control")
    values.refuse(
        (waveform == Waveform.COSINE) & (control == Control.DISPLACEMENT),
        f"{table}.control",
        "must be velocity or acceleration with waveform cosine, whose displacement would jump",
    )
    frequency = values.numbers(f"{table}.frequency")
    w = 2.0 * np.pi * frequency
    written = _WRITTEN[values.dimension(f"{table}.amplitude")]
    lacking = (_order(control) - written).astype(float)
    amplitude = values.numbers(f"{table}.amplitude") * w**lacking
    if values.given(f"{table}.cycles"):
        duration = values.numbers(f"{table}.cycles") / frequency
    else:
        duration = values.numbers(f"{table}.duration")
    each = cast("Sequence[Waveform]", waveform)
    motions = harmonic_motions(each, control, amplitude, frequency, start, duration)
    return Followed(motions, np.abs(motions.acceleration_amplitude))


def _ricker(values: Values, table: str, start: Array) -> Followed:
    """Ricker pulses, whose amplitude is that of the controlled quantity."""
    control = _texts(values, f"{table}.control")
    _refuse_kinds(values, table, control)
    frequency = values.numbers(f"{table}.frequency")
    amplitude = values.numbers(f"{table}.amplitude")
    motions = ricker_motions(control, amplitude, frequency, start)
    peak = ricker_peak_acceleration(amplitude, frequency, 2 - _order(control))
    return Followed(motions, peak)


def _mavroeidis_papageorgiou(values: Values, table: str, start: Array) -> Followed:
    """Near-fault pulses, whose amplitude is that of the controlled quantity."""
    control = _texts(values, f"{table}.control")
    _refuse_kinds(values, table, control)
    cycles = values.numbers(f"{table}.cycles")
    values.refuse(
        cycles <= 1.0, f"{table}.cycles", "must be above 1 with waveform mavroeidis-papageorgiou"
    )
    motions = mavroeidis_papageorgiou_motions(
        control,
        values.numbers(f"{table}.amplitude"),
        values.numbers(f"{table}.frequency"),
        start,
        cycles=cycles,
        phase=values.numbers(f"{table}.phase"),
    )
    return Followed(motions, modulated_peak_acceleration(motions))


def _tilt(values: Values, table: str, start: Array) -> Followed:
    """Tables that tilt until the run ends, or to a tilt at which they stay, with pauses or not."""
    rate, end = 2.0 * np.pi * values.numbers(f"{table}.tilt_rate"), values.numbers(DURATION)
    tilting = steady(rate, start)
    for name, field in (("tilt_step", "step"), ("pause", "pause"), ("tilt_to", "most")):
        if values.given(f"{table}.{name}"):
            tilting = tilting._replace(**{field: values.numbers(f"{table}.{name}")})
    steep = np.where(
        rate == 0.0, 0.0, tilting._replace(rate=np.where(rate == 0.0, 1.0, rate)).angle(end)
    )
    key, most = f"{table}.tilt_rate", np.degrees(STEEPEST)
    values.refuse(rate == 0.0, key, "must not be 0 deg/s")
    values.refuse(
        steep > STEEPEST, key, f"must tilt by at most {most:g} deg until the end of the run"
    )
    return Followed(tilt_motions(tilting, end), GRAVITY * np.tan(steep))


def _push(values: Values, table: str, start: Array) -> Followed:
    """Sideways loads that rise slowly and stay; their amplitude is the load over the mass."""
    key, rise = f"{table}.rise", values.numbers(f"{table}.rise")
    load, end = values.numbers(f"{table}.amplitude"), values.numbers(DURATION)
    values.refuse(
        np.full(len(load), _WRITTEN[values.dimension(f"{table}.amplitude")] != 2),
        f"{table}.amplitude",
        'must be an acceleration with waveform push: "0.3 g" is three tenths of the weight',
    )
    values.refuse(
        end > MOST_RISES * rise, key, f"must be at least the duration of the run / {MOST_RISES:,}"
    )
    reached = np.minimum((end - start) / rise, 1.0)
    return Followed(push_motions(load, rise, start, end), np.abs(load) * reached)


MOST_RISES = 10_000
"""Duration of a run over the time in which a push rises: that many samples of each are kept."""


def _refuse_kinds(values: Values, table: str, control: npt.NDArray[np.str_]) -> None:
    """Refuses an amplitude of another kind than the control: these pulses have no one frequency."""
    waveform = values.texts(f"{table}.waveform")[0][0]
    values.refuse(
        _order(control) != _WRITTEN[values.dimension(f"{table}.amplitude")],
        f"{table}.amplitude",
        f"must be of the kind of {table}.control with waveform {waveform}: a length for "
        "displacement, a velocity for velocity, an acceleration for acceleration",
    )


_PAUSES = ("tilt_step", "pause")
_PULSE = ("control", "frequency", "amplitude")

FAMILIES = (
    Family(
        (Waveform.SINE, Waveform.COSINE), _PULSE, ("start", "cycles", "duration"), _PULSE, _harmonic
    ),
    Family((Waveform.RICKER,), _PULSE, ("start",), _PULSE, _ricker),
    Family(
        (Waveform.MAVROEIDIS_PAPAGEORGIOU,),
        (*_PULSE, "cycles"),
        ("start", "phase"),
        (*_PULSE, "cycles", "phase"),
        _mavroeidis_papageorgiou,
    ),
    Family(
        (Waveform.TILT,),
        ("tilt_rate",),
        ("start", *_PAUSES, "tilt_to"),
        ("tilt_rate", *_PAUSES, "tilt_to"),
        _tilt,
    ),
    Family((Waveform.PUSH,), ("amplitude",), ("rise", "start"), ("amplitude", "rise"), _push),
    Family(
        (Waveform.RECORD,),
        ("record",),
        ("scale", "target_pga", "target_sa", "sa_period", "start"),
        ("record", "scale"),
        None,
    ),
)
"""All of them; records last."""

FAMILY_OF: dict[Waveform, Family] = {
    waveform: family for family in FAMILIES for waveform in family.waveforms
}
