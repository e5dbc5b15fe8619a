# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes how light travels: casts rays from receivers, keeps their hits, bounces light, mends what lies inside
geometry.
"""
