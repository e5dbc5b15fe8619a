# SPDX-License-Identifier: GPL-3.0-or-later
"""How light travels: the ray caster, receivers and their rays, what they hit, one bounce and many, what lies inside."""
