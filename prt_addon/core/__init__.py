# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine: precomputed radiance transfer on NumPy arrays and embreex rays.

Nothing below imports `bpy`; every module runs, and is tested, without Blender.

Convention, stated once (the same as Ramamoorthi & Hanrahan 2001 and three.js):
real, orthonormal spherical harmonics without the Condon-Shortley sign, stored at index
`l * (l + 1) + m`, over right-handed axes with Z up. "Order n" means bands 0..n. Light is
`L_i = integral L(w) Y_i(w) dw`; transport is the radiance that leaves a *white* Lambertian
receiver lit by `Y_i`; so a surface shows `base_color * sum_i T_i L_i`.
"""
