# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes to surfaces and receivers; transport to attributes, with the record of its bake."""
