"""Both forms of a kernel give the same response, and `explain` names the one that is launched."""

from __future__ import annotations

import pathlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.shared.blocks import shakes, two_equal
from tests.shared.case_texts import FREE
from tests.shared.kinds import SCENES, in_every_kind, lanes_of, motions_of
from tests.shared.marks import first
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class
from warprock.engines.launching import Form, Target
from warprock.model.motion import MotionKind
from warprock.model.response import INTEGER_FIELDS, SampleTimes
from warprock.model.scene import scene_kind
from warprock.running.batch import run_batch
from warprock.running.catalogue import explain_case

TIMES = SampleTimes(0.6, 0.1, places=True)

HOPS = ("event", "block in space")
"""Whose packed form has steps of a text of its own: round-off then decides whether a corner that
hardly leaves the base lands once more."""


def with_two_forms() -> list[tuple[str, str]]:
    """Engines and scenes for which a CPU can run either form of a kernel."""
    found = []
    for scene in SCENES:
        lanes = lanes_of(scene)
        kind = scene_kind(lanes, motions_of(MotionKind.STILL, lanes), restitution_given=False)
        for name in ENGINES:
            engine = engine_class(name)
            if engine.supports(kind) is not None:
                continue
            forms = {engine(None, Target(form=form)).kernel_of(lanes) for form in Form}
            if scene != "stack of one" and len(forms) == 2:
                found.append((name, scene))
    return found


def test_the_engines_with_two_forms_are_found():
    found = set(with_two_forms())
    assert {("housner", "block"), ("dem", "stack"), ("event", "block in space")} <= found
    assert ("impulse", "stack in space") in found
    assert not {("direct", "stack"), ("event", "stack")} & found


SHOWN = ("housner", "impulse")
"""Engines of which the ordinary run compares both forms of single blocks; others: `thorough`."""

OFTEN = [(name, "block") for name in ("housner", "impulse")]
"""Engines and scenes of which the ordinary run compares both forms of many lanes shaken hard."""


@pytest.mark.parametrize(
    ("engine", "scene", "kind"),
    [
        each if each.values[0] in SHOWN else pytest.param(*each.values, marks=pytest.mark.thorough)
        for each in in_every_kind(with_two_forms())
        if each.values[1] == "block" or each.values[2] is MotionKind.HARMONIC
    ],
)
def test_every_field_is_the_same_in_both_forms(engine: str, scene: str, kind: MotionKind):
    lanes = lanes_of(scene)
    motions = motions_of(kind, lanes)
    packed, plain = (
        run_batch(engine, lanes, motions, TIMES, form=form, workers=1) for form in Form
    )
    assert set(packed.fields) == set(plain.fields)
    for name in packed.fields:
        if (engine, scene) != HOPS:
            # One text is both forms, and both round alike.
            np.testing.assert_array_equal(packed[name], plain[name], err_msg=name)
        elif name in ("impact_count", "step_count"):
            assert np.max(np.abs(packed[name] - plain[name])) <= 5
        elif name in INTEGER_FIELDS:
            np.testing.assert_array_equal(packed[name], plain[name], err_msg=name)
        else:
            # Round-off, magnified by impacts and onsets of sliding.
            np.testing.assert_allclose(packed[name], plain[name], 1e-8, 1e-10, err_msg=name)


@pytest.mark.parametrize(
    ("engine", "scene"),
    [
        pytest.param(*each, marks=() if each in OFTEN else pytest.mark.thorough)
        for each in with_two_forms()
        if "in space" not in each[1]
    ],
)
def test_blocks_shaken_hard_do_the_same_in_both_forms(engine: str, scene: str):
    # They slide, hop, and overturn. What the compiler rounds otherwise in one form, a product that
    # it fuses with a sum or not, shows in some of a hundred lanes.
    lanes, motions = shakes(200, (0.05, 1.3))
    lanes = two_equal(lanes) if scene == "stack" else lanes
    packed, plain = (
        run_batch(engine, lanes, motions, SampleTimes(1.0, 0.01), form=form) for form in Form
    )
    for name in packed.fields:
        np.testing.assert_array_equal(packed[name], plain[name], err_msg=name)


class LaunchedError(Exception):
    """Ends a run where its kernel would be launched, and carries that and its threads."""


def launched(
    name: str, case: Case, target: Target, monkeypatch: pytest.MonkeyPatch
) -> tuple[str, bool]:
    """File of the kernel that a run of a case launches, and whether a thread runs many lanes."""

    def stop(kernel: Any, dim: tuple[int, int], **_: object) -> None:
        raise LaunchedError(kernel, dim[0])

    monkeypatch.setattr(wp, "launch", stop)
    lane_set, many = expand_lanes(case), np.zeros(64, np.intp)
    lanes, motions = lane_set.lanes.take(many), lane_set.motions.take(many)
    with pytest.raises(LaunchedError) as caught:
        engine_class(name)(case.engine_settings(name), target).run(lanes, motions, TIMES)
    kernel, threads = caught.value.args
    file = sys.modules[kernel.module.name].__file__
    assert file is not None
    # One kernel runs all lanes of a launch in its first thread.
    packed = threads < 64 or "PLACES" in vars(sys.modules[kernel.module.name])
    return file.rpartition("/kernels/")[2], packed


SECOND = FREE.split("[contact]")[0].split("[block]")[1].replace("0.5 m", "0.4 m")
SCENE_TEXTS = {
    "block": FREE,
    "stack of one": FREE.replace("[block]", "[block.1]"),
    "stack": FREE.replace("[block]", "[block.1]").replace(
        "[contact]", f"[block.2]{SECOND}[contact]"
    ),
}
SCENE_TEXTS |= {
    f"{name} in space": f'model = "spatial"\n{text}' for name, text in SCENE_TEXTS.items()
}
SETTINGS_TEXTS = {
    "block": "[engines.impulse]\niterations = 40\n",
    "block in space": "[engines.event]\nfriction_box = 1\n",
}
"""Settings for which another kernel runs a scene."""


@pytest.mark.parametrize(
    ("scene", "settings"),
    first(1, [*((scene, "") for scene in SCENE_TEXTS), *SETTINGS_TEXTS.items()]),
)
def test_explain_names_the_kernel_that_is_launched(
    scene: str, settings: str, write: Callable[[str], pathlib.Path], monkeypatch: pytest.MonkeyPatch
):
    case = load_case(write(SCENE_TEXTS[scene] + settings))
    rows = [row for row in explain_case(case)["engines"] if row["kernel"]]
    assert {"event", "impulse", "dem"} <= {row["name"] for row in rows}
    for row in rows:
        here, packed = launched(row["name"], case, Target(), monkeypatch)
        there, beside = launched(row["name"], case, Target(form=Form.PLAIN), monkeypatch)
        assert not beside
        words = row["kernel"]
        assert words.startswith(f"kernels/{here} for a still base: ")
        assert ("`packed` on a CPU" in words) == packed
        assert ("one lane a thread on any device" in words) == (not packed)
        assert here == there or f"{there}, one lane a thread, on any other device" in words
