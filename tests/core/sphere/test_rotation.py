# SPDX-License-Identifier: GPL-3.0-or-later
"""Turned SH vectors are those of the turned function."""

import numpy as np
import pytest

from prt_addon.core.sphere import rotation, sh
from tests.core.references import axis_angle, order2, random_directions, random_rotations

ROTATIONS = random_rotations(6)


def test_equivariance_of_order_2():
    """A turned sky seen along w is the sky seen along R^-1 w; the inverse would be the classic mistake."""
    directions, light = random_directions(50), np.random.default_rng(7).normal(size=9)
    for turn in ROTATIONS:
        turned = order2(directions) @ rotation.rotation_matrix(turn) @ light
        assert np.allclose(turned, order2(directions @ turn) @ light, rtol=0, atol=1e-12)


def test_quarter_turn_by_hand():
    """About Z by 90 degrees, +x becomes +y and +y becomes -x."""
    matrix = rotation.rotation_matrix(axis_angle((0, 0, 1), np.pi / 2))
    y, z, x = np.eye(9)[1:4]
    for before, after in ((x, y), (y, -x), (z, z)):
        assert np.allclose(matrix @ before, after, rtol=0, atol=1e-13)


@pytest.mark.parametrize("order", range(sh.MAX_ORDER + 1))
def test_equivariance(order):
    """A point light that is turned is a point light elsewhere, through order 8."""
    directions = random_directions(50)
    for turn in ROTATIONS:
        moved = sh.basis(directions, order) @ rotation.rotation_matrix(turn, order).T
        assert np.allclose(moved, sh.basis(directions @ turn.T, order), rtol=0, atol=1e-12)


def test_orthogonal_and_block_diagonal():
    """A turn keeps energy, and keeps it within its band, to 1e-12 through order 8."""
    bands = np.repeat(np.arange(9), 2 * np.arange(9) + 1)
    for turn in ROTATIONS:
        matrix = rotation.rotation_matrix(turn, 8)
        assert np.allclose(matrix @ matrix.T, np.eye(81), rtol=0, atol=1e-12)
        assert not matrix[bands[:, None] != bands].any()


def test_trace_is_the_character_of_the_rotation_group():
    """sin((2l+1) a/2) / sin(a/2), whatever the axis: needs no basis to compare with."""
    angle = 0.9
    matrix = rotation.rotation_matrix(axis_angle((1, -2, 0.5), angle), 8)
    for band in range(9):
        trace = np.trace(matrix[band**2 : (band + 1) ** 2, band**2 : (band + 1) ** 2])
        assert np.isclose(trace, np.sin((2 * band + 1) * angle / 2) / np.sin(angle / 2), rtol=0, atol=1e-12)


def test_composition():
    """Two turns are one turn, the later one on the left."""
    first, second = ROTATIONS[:2]
    both = rotation.rotation_matrix(second, 8) @ rotation.rotation_matrix(first, 8)
    assert np.allclose(both, rotation.rotation_matrix(second @ first, 8), rtol=0, atol=1e-12)
    assert not np.allclose(both, rotation.rotation_matrix(first @ second, 8), rtol=0, atol=0.1)


def test_no_turn_changes_nothing():
    """The identity is the identity."""
    assert np.allclose(rotation.rotation_matrix(np.eye(3), 8), np.eye(81), rtol=0, atol=1e-13)


def test_rotate_order2_is_rotation_matrix():
    """The quick way for many vectors agrees; frames are given by rows, hence the transpose."""
    vectors = np.random.default_rng(8).normal(size=(len(ROTATIONS), 9))
    quick = rotation.rotate_order2(vectors, ROTATIONS.transpose(0, 2, 1))
    slow = [rotation.rotation_matrix(turn) @ vector for turn, vector in zip(ROTATIONS, vectors, strict=True)]
    assert np.allclose(quick, slow, rtol=0, atol=1e-12)


def test_rotate_order2_carries_local_to_world():
    """A light along a local axis comes out along that row of the frame."""
    frames = ROTATIONS
    local = random_directions(len(frames))
    world = np.einsum("ni,nij->nj", local, frames)
    assert np.allclose(rotation.rotate_order2(order2(local), frames), order2(world), rtol=0, atol=1e-13)
