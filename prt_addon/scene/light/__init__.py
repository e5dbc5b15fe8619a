# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the SH light on the world: stores, drives and keyframes it, and draws pictures of it."""
