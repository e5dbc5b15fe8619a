# SPDX-License-Identifier: GPL-3.0-or-later
"""What is stored where: the layers of transport on a mesh, and what each of their floats means."""

from __future__ import annotations

from .sphere import sh

LAYERS = tuple(f"_PRT_{i}" for i in range(sh.coefficient_count(sh.ORDER)))
"""Names of the float colour layers, one per coefficient. The leading underscore lets glTF carry them."""
