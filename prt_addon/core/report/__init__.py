# SPDX-License-Identifier: GPL-3.0-or-later
"""How true a bake is: its error, measured at random points of the surface and split into parts one can act on."""
