"""Impacts between free blocks: what the contact solve of `event` conserves, and what it loses."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from tests.shared.impact_probe import BLOCKS, Blocks, Counts, Triples, Values, strike

LANES = 500
CLOSED, PLUS, MINUS = 3, 1, 2


def launch(
    rows: np.ndarray, theta: np.ndarray, anchor: np.ndarray, touch: np.ndarray, glide: np.ndarray,
    before: np.ndarray, kept: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """What `strike` finds: places, velocities after, and whether it obeys the law."""
    count = len(rows)
    place = wp.zeros((count, 2 * BLOCKS), dtype=wp.float64)
    after = wp.zeros(count, dtype=Triples)
    settled = wp.zeros(count, dtype=int)
    inputs = [
        wp.array(rows, dtype=Blocks),
        wp.array(theta, dtype=Values),
        wp.array(anchor, dtype=Values),
        wp.array(touch.astype(np.int32), dtype=Counts),
        wp.array(glide.astype(np.int32), dtype=Counts),
        wp.full(count, kept, dtype=wp.float64),
        wp.array(before, dtype=Triples),
    ]
    wp.launch(strike, dim=count, inputs=[*inputs, place, after, settled], device="cpu")
    return place.numpy(), after.numpy().reshape(count, BLOCKS, 3), settled.numpy() == 1


def struck(
    glide: np.ndarray,
    side: float = 1.0,
    friction: tuple[float, ...] = (0.0, 0.3, 1.0, 5.0),
    kept: float = 0.0,
) -> dict[str, np.ndarray]:
    """Six blocks in flight that touch at corners or whole faces and fly at one another.

    Args:
        glide: Directions of sliding that are given, shape [lane, block].
        side: -1 for their mirror images.
        friction: Coefficients that are drawn from.
        kept: Restitution.
    """
    random = np.random.default_rng(11)
    half_width, half_height = random.uniform(0.1, 0.5, (2, LANES, BLOCKS))
    mass = random.uniform(1.0, 100.0, (LANES, BLOCKS))
    inertia = mass * (half_width**2 + half_height**2) / 3.0
    touch = random.choice([CLOSED, PLUS, MINUS], (LANES, BLOCKS))
    tilt = random.uniform(0.01, 0.6, (LANES, BLOCKS)) * np.select(
        [touch == PLUS, touch == MINUS], [1.0, -1.0], 0.0
    )
    tilt[:, 0] = random.uniform(-0.5, 0.5, LANES)
    theta = np.cumsum(tilt, axis=1)
    # Corners of the upper block inside the lower face; whole faces one above the other.
    anchor = np.zeros((LANES, BLOCKS))
    anchor[:, 1:] = random.uniform(-0.9, 0.9, (LANES, BLOCKS - 1)) * half_width[:, :-1]
    whole = touch == CLOSED
    anchor[whole] *= 0.3
    before = random.normal(0.0, 1.0, (LANES, 3 * BLOCKS))
    if side < 0.0:
        theta, anchor, glide = -theta, -anchor, -glide
        touch = np.select([touch == PLUS, touch == MINUS], [MINUS, PLUS], touch)
        before *= np.tile([-1.0, 1.0, -1.0], BLOCKS)
    rows = np.zeros(LANES, dtype=Blocks.numpy_dtype())
    rows["half_height"], rows["half_width"] = half_height, half_width
    rows["mass"], rows["inertia"] = mass, inertia
    rows["inverse_mass"], rows["inverse_inertia"] = 1.0 / mass, 1.0 / inertia
    rows["friction"] = random.choice(friction, (LANES, BLOCKS))
    place, after, settled = launch(rows, theta, anchor, touch, glide, before, kept)
    return {
        "mass": mass,
        "inertia": inertia,
        "centre": centres(theta, half_height, place),
        "before": before.reshape(LANES, BLOCKS, 3),
        "after": after,
        "settled": settled,
    }


@pytest.fixture(scope="module", params=[0.0, 0.6, 1.0])
def impacts(request: pytest.FixtureRequest) -> dict[str, np.ndarray]:
    """Impacts of a restitution in which friction finds its own directions."""
    found = struck(np.zeros((LANES, BLOCKS)), kept=request.param)
    assert np.all(found["settled"])
    found["kept"] = request.param
    return found


def centres(theta: np.ndarray, half_height: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Centres of the blocks [m], shape [lane, block, 2], the lowest at the origin."""
    along_axis = np.stack([np.cos(theta), -np.sin(theta)], axis=-1)
    up_axis = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    found = np.zeros((*theta.shape, 2))
    for k in range(1, theta.shape[1]):
        top = found[:, k - 1] + half_height[:, k - 1, None] * up_axis[:, k - 1]
        foot = top + place[:, k, None] * along_axis[:, k - 1]
        foot += place[:, BLOCKS + k, None] * up_axis[:, k - 1]
        found[:, k] = foot + half_height[:, k, None] * up_axis[:, k]
    return found


def momenta(impacts: dict[str, np.ndarray], when: str) -> np.ndarray:
    """Linear momentum (x, z) and clockwise angular momentum about the origin, shape [lane, 3]."""
    vx, vz, omega = np.moveaxis(impacts[when], -1, 0)
    x, z = np.moveaxis(impacts["centre"], -1, 0)
    m = impacts["mass"]
    angular = m * (z * vx - x * vz) + impacts["inertia"] * omega
    return np.stack([(m * vx).sum(1), (m * vz).sum(1), angular.sum(1)], axis=1)


@pytest.mark.thorough
def test_free_blocks_keep_their_momenta(impacts: dict[str, np.ndarray]) -> None:
    """To round-off of momenta of about 100 kg m/s: impulses come in opposite pairs at one point."""
    assert np.abs(momenta(impacts, "after") - momenta(impacts, "before")).max() < 1e-10
    changed = np.abs(impacts["after"] - impacts["before"]).max(axis=(1, 2)) > 1e-3
    assert changed.mean() > 0.6


@pytest.mark.thorough
def test_an_impact_gives_no_energy(impacts: dict[str, np.ndarray]) -> None:
    def kinetic(when: str) -> np.ndarray:
        vx, vz, omega = np.moveaxis(impacts[when], -1, 0)
        return 0.5 * (impacts["mass"] * (vx**2 + vz**2) + impacts["inertia"] * omega**2).sum(1)

    lost = kinetic("before") - kinetic("after")
    assert lost.min() > -1e-10 * kinetic("before").max()
    # A bounce gives back; at 1 the lanes that slide lose alone.
    assert np.mean(lost > 1e-3 * kinetic("before")) > (0.6 if impacts["kept"] < 1.0 else 0.3)


@pytest.mark.thorough
def test_contacts_settle_where_no_state_slides_as_given() -> None:
    # With friction up to 5 a given sliding often finds no impulses at all (Painleve's paradox).
    glide = np.random.default_rng(3).choice([-1, 0, 1], (LANES, BLOCKS))
    assert np.all(struck(glide)["settled"])


@pytest.mark.thorough
def test_impacts_have_mirrored_outcomes_in_a_mirror() -> None:
    # Jammed contacts have several states that obey the law; the way to one starts at open ends.
    glide = np.random.default_rng(0).choice([-1, 1], (LANES, BLOCKS))
    jams = (2.0, 5.0, 10.0)
    found, image = (struck(glide, side, jams)["after"] for side in (1.0, -1.0))
    # Round-off of velocities of some hundred m/s; another state is off by as much as they are.
    assert np.abs(image * [-1.0, 1.0, -1.0] - found).max() <= 1e-9


@pytest.mark.thorough
def test_a_block_that_is_dropped_flat_on_another_leaves_by_the_law_of_central_impacts() -> None:
    """Its speed over that at which it came is e, both momenta are kept, and nothing turns."""
    mass, kept, speed = np.array([30.0, 10.0, 5.0, 5.0, 5.0, 5.0]), 0.4, 2.0
    half, theta = np.full((1, BLOCKS), 0.2), np.zeros((1, BLOCKS))
    rows = np.zeros(1, dtype=Blocks.numpy_dtype())
    rows["half_height"], rows["half_width"], rows["friction"] = half, half, 0.5
    rows["mass"], rows["inertia"] = mass, mass * 0.04 / 1.5
    rows["inverse_mass"], rows["inverse_inertia"] = 1.0 / mass, 1.5 / (mass * 0.04)
    touch, before = np.zeros((1, BLOCKS)), np.zeros((1, 3 * BLOCKS))
    touch[0, 1], before[0, 4] = CLOSED, -speed
    _place, after, settled = launch(rows, theta, theta, touch, theta, before, kept)
    impulse = (1.0 + kept) * speed / (1.0 / mass[0] + 1.0 / mass[1])
    wanted = np.zeros((BLOCKS, 3))
    wanted[0, 1], wanted[1, 1] = -impulse / mass[0], impulse / mass[1] - speed
    assert settled[0]
    np.testing.assert_allclose(after[0], wanted, atol=1e-14)
