# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes what the tests compare with: textbook formulas and quadrature that share no code with the engine."""

import numpy as np

COURSE_FACES = {
    "negx": ((0, 0, 1), (0, -1, 0), (-1, 0, 0)),
    "posx": ((0, 0, 1), (0, -1, 0), (1, 0, 0)),
    "posy": ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "negy": ((1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "posz": ((-1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "negz": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
}
"""Right, down and middle of each face of the GAMES202 course's cube maps, in its Y-up world."""


def order2(directions):
    """The nine real harmonics written out (Ramamoorthi & Hanrahan 2001, equation 3)."""
    x, y, z = np.moveaxis(np.asarray(directions, dtype=np.float64), -1, 0)
    return np.stack(
        [
            np.full_like(x, np.sqrt(1 / (4 * np.pi))),
            np.sqrt(3 / (4 * np.pi)) * y,
            np.sqrt(3 / (4 * np.pi)) * z,
            np.sqrt(3 / (4 * np.pi)) * x,
            np.sqrt(15 / (4 * np.pi)) * x * y,
            np.sqrt(15 / (4 * np.pi)) * y * z,
            np.sqrt(5 / (16 * np.pi)) * (3 * z * z - 1),
            np.sqrt(15 / (4 * np.pi)) * z * x,
            np.sqrt(15 / (16 * np.pi)) * (x * x - y * y),
        ],
        axis=-1,
    )


def sphere_quadrature(points):
    """Directions and weights, exact for polynomials up to degree 2 * points - 1."""
    z, weight = np.polynomial.legendre.leggauss(points)
    return _product_rule(z, weight, 2 * points)


def hemisphere_quadrature(normal, points):
    """The same over the half of the sphere that a normal points at."""
    z, weight = np.polynomial.legendre.leggauss(points)
    local, weights = _product_rule((z + 1) / 2, weight / 2, 2 * points)
    normal = np.asarray(normal) / np.linalg.norm(normal)
    tangents = np.linalg.svd(normal[None])[2][1:]
    return local @ np.stack([*tangents, normal]), weights


def _product_rule(z, weight, azimuths):
    angle = 2 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    ring = np.sqrt(1 - z * z)[:, None]
    rows = [ring * np.cos(angle), ring * np.sin(angle), np.broadcast_to(z[:, None], (len(z), azimuths))]
    return np.stack(rows, axis=-1).reshape(-1, 3), np.repeat(weight * 2 * np.pi / azimuths, azimuths)


def random_directions(count, seed=1):
    """Unit vectors, uniform over the sphere."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def axis_angle(axis, angle):
    """Rotation matrix by Rodrigues' formula; columns are the images of the axes."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def random_rotations(count, seed=2):
    """Rotations about random axes by random angles."""
    axes, angles = random_directions(count, seed), np.random.default_rng(seed).uniform(0.1, 3.0, count)
    return np.array([axis_angle(axis, angle) for axis, angle in zip(axes, angles, strict=True)])
