"""A block that is too wide to rock over: 1 - 1.5 sin^2(slenderness angle) <= 0."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_lanes
from tests.shared.case_texts import FREE
from tests.shared.commands import invoke
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines.energy import energy_held
from warprock.errors import InputError
from warprock.model.response import Outcome, SampleTimes
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case

WIDE = FREE.replace('"0.5 m"', '"1.5 m"').replace('duration = "5 s"', 'duration = "0.5 s"')


def test_the_case_is_accepted_and_housner_alone_declines_it(write):
    file = write(WIDE + '[start]\nrotation = "2 deg"\n')
    assert expand_lanes(load_case(file)).scene.angular_restitution == pytest.approx(
        1.0 - 1.5 * 2.25 / 3.25
    )
    found = json.loads(invoke("explain", file, "--json").stdout)
    declines = {row["name"]: row["declines"] for row in found["engines"]}
    assert "width below 1.414 times the height" in declines["housner"]
    assert all(declines[name] is None for name in ("event", "impulse", "direct", "xpbd", "dem")), (
        declines
    )
    with pytest.raises(InputError, match="does not rock over") as caught:
        run_case(load_case(file), "housner")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("restitution", [0.5, 0.0])
def test_housner_runs_it_with_a_prescribed_restitution(write, restitution):
    given = f"friction = 2\nangular_restitution={restitution}"
    text = WIDE.replace("friction = 1.0", given) + '[start]\nrotation = "2 deg"\n'
    found = run_case(load_case(write(text)), "housner").response
    assert found["outcome"][0] == Outcome.AT_REST
    assert (found["impact_count"][0] == 1) == (restitution == 0.0)


@pytest.mark.parametrize("engine", ["event", "impulse", "direct", "xpbd"])
def test_it_comes_to_rest_where_it_lands(engine: str):
    lanes = make_lanes([1.5, 2.0, 1.8, 3.0], 1.0, [0.05, -0.1, 0.2, 0.05])
    times = SampleTimes(0.6, 0.005)
    response = run_batch(engine, lanes, at_rest(4), times)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    held = energy_held(lanes, lanes.rotation_start)
    # All that it had is lost at once. The first-order engines err by their step times the velocity
    # at which it lands, in what they fall.
    share = {"event": 1e-3}.get(engine, 2e-2)
    np.testing.assert_allclose(response["energy_lost"], held, rtol=share)
    beyond = -np.sign(lanes.rotation_start)[:, None] * response["rotation"]
    assert np.all(beyond < 1e-3 * lanes.slenderness_angle[:, None])
    if engine == "event":
        np.testing.assert_array_equal(response["impact_count"], 1)
