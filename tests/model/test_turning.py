"""Vectors turned, and principal axes."""

from __future__ import annotations

import numpy as np

from warprock.model.turning import inverse, principal_axes, rotate


def test_the_inverse_turns_back():
    rng = np.random.default_rng(4)
    attitude, vectors = rng.normal(size=(20, 4)), rng.normal(size=(20, 3))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    back = rotate(inverse(attitude), rotate(attitude, vectors))
    # Round-off of two turns.
    np.testing.assert_allclose(back, vectors, rtol=0.0, atol=1e-14)


def test_principal_axes_turn_back_to_the_tensor():
    rng = np.random.default_rng(3)
    cloud = rng.normal(size=(20, 3)) * [1.0, 2.0, 4.0]
    tensor = np.sum(cloud**2) * np.eye(3) - cloud.T @ cloud
    moments, axes = principal_axes(tensor)
    turn = rotate(axes[None], np.eye(3)).T
    np.testing.assert_allclose(turn @ np.diag(moments) @ turn.T, tensor, rtol=1e-12, atol=1e-9)
    # Axes that are principal stay where they are, in their order.
    moments, axes = principal_axes(np.diag([5.0, 3.0, 4.0]))
    np.testing.assert_array_equal(moments, [5.0, 3.0, 4.0])
    np.testing.assert_allclose(axes, [0.0, 0.0, 0.0, 1.0], atol=1e-15)


def test_round_off_turns_no_axes_of_a_body_that_has_two_equal_moments():
    tensor = np.diag([3.0, 2.0, 2.0])
    tensor[1, 2] = tensor[2, 1] = 4e-16
    moments, axes = principal_axes(tensor)
    np.testing.assert_array_equal(moments, [3.0, 2.0, 2.0])
    np.testing.assert_array_equal(axes, [0.0, 0.0, 0.0, 1.0])
    # Products of inertia that are no round-off do.
    tensor[1, 2] = tensor[2, 1] = 1e-6
    _moments, axes = principal_axes(tensor)
    np.testing.assert_allclose(
        abs(axes), [np.sin(np.pi / 8), 0.0, 0.0, np.cos(np.pi / 8)], atol=1e-9
    )
