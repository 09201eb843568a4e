"""Rocking spectra: the peak rotation of blocks of many sizes under one motion.

The rotation over the slenderness angle is a function of the motion, the block's 2 pi / p, its
slenderness and what it keeps at an impact (Makris and Konstantinidis 2003, The rocking spectrum and
the limitations of practical design methodologies, *Earthquake Engineering and Structural Dynamics*
32): one curve a slenderness, over 2 pi / p. The lanes of a case with a [spectrum] are its points.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.case.axes import LABEL, crossed_labels
from warprock.case.case import Case
from warprock.case.spectrum import SLENDERNESS, SPECTRUM
from warprock.errors import NOTHING, InputError, Said
from warprock.model.ratios import peak_ratio
from warprock.running.case_run import CaseRun, run_case
from warprock.running.options import DEFAULT_OPTIONS, RunOptions

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Spectrum:
    """The spectra of a case.

    Attributes:
        run: The case, its lanes and what became of them.
        groups: Labels of every group of curves, a panel each.
        curves: Slenderness angles of a group, as they were written.
        lanes: Numbers of the lanes, shape [group, curve, period].
    """

    run: CaseRun
    groups: tuple[str, ...]
    curves: tuple[str, ...]
    lanes: npt.NDArray[np.intp]

    @property
    def period(self) -> Array:
        """2 pi / p of every lane [s], shape [lane]."""
        rate = self.run.lane_set.inputs["frequency_parameter_rad_s"].to_numpy(dtype=np.float64)
        return np.asarray(2.0 * np.pi / rate)

    @property
    def ratio(self) -> Array:
        """Peak rotation / slenderness angle of every lane [-], shape [lane]."""
        return peak_ratio(self.run.response, self.run.lane_set.lanes)


def run_spectrum(
    case: Case,
    engine: str,
    options: RunOptions = DEFAULT_OPTIONS,
) -> Spectrum:
    """Runs all blocks of all curves, in one batch.

    Args:
        case: A case with a [spectrum].
        engine: Name of the engine.
        options: How they are run.

    Raises:
        InputError: The case has no spectrum, or nothing can be drawn of its other tables; an option
            is not one of those allowed; or the engine cannot do the scene.
    """
    groups, curves, lanes = _layout(case)
    run = run_case(case, engine, options, histories=False)
    return Spectrum(run, groups, curves, lanes)


def _layout(case: Case) -> tuple[tuple[str, ...], tuple[str, ...], npt.NDArray[np.intp]]:
    """Groups and curves of a case, and the numbers of their lanes.

    Raises:
        InputError: The case is no spectrum.
    """
    if SPECTRUM not in case.raw:
        allowed = "must be given: the periods and the slenderness angles of its curves"
        raise InputError(case.file, SPECTRUM, NOTHING, allowed)
    for name in ("sample", "ensemble", "study"):
        if name in case.raw:
            allowed = "must not be given beside [spectrum] for its curves"
            raise InputError(case.source_of(name), name, Said("a table"), allowed)
    if case.tables.motion is None:
        raise InputError(case.file, "motion", NOTHING, "must be given: it moves the blocks")
    place = len(case.axes) - 1
    axis = case.axes[place]
    labels = axis.columns[LABEL + SLENDERNESS]
    curves: tuple[str, ...] = getattr(labels, "values", ())
    lanes = np.arange(case.lane_count, dtype=np.intp)
    shape = (-1, len(curves), axis.length // len(curves))
    return crossed_labels(case.axes, {place}, case.source_of("sweep")), curves, lanes.reshape(shape)
