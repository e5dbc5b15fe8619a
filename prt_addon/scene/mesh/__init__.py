# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads meshes as surfaces and receivers, and writes transport as attributes with the record of its bake."""
