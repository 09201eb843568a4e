"""Strong-motion records: shipped ones by name, others from files, and what is done with them."""

from __future__ import annotations

from warprock.recordings.following import record_motions
from warprock.recordings.loading import load_channels, load_record, record_names
from warprock.recordings.record import Record

__all__ = ["Record", "load_channels", "load_record", "record_motions", "record_names"]
