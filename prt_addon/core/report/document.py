# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a report as plain data for JSON: numbers with their intervals, and a line of advice for each part."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import isfinite
from typing import Any

from ..problem import BOUNCING
from ..sky.lamps import Lamps
from .advice import about_pictures, about_rest, about_sampling, about_seams, about_tessellation, about_truncation
from .findings import Findings
from .measures import CONVERGED, Estimate
from .picture import PictureDifference
from .sampling import Sampling, sampling
from .seams import seams
from .tessellation import Tessellation, tessellation
from .total import Total, total
from .truncation import Truncation, truncation

VERSION = 2

PARTS = ("SAMPLING", "TRUNCATION", "TESSELLATION")

MEASURE = (
    "radiance of a white surface, linear light, the world as it is turned: sqrt(mean |error|^2 / mean |truth|^2) over "
    "points drawn by area and channels; value, low, high are the estimate and its 95 % interval"
)

Json = dict[str, Any]


def surface_report(found: Sequence[Findings], lamps: Lamps, parts: Collection[str], shown: bool = False) -> Json:
    """Report all that was found, for all objects together and for each.

    Args:
        found: of each object.
        lamps: that were found in the sky.
        parts: which of `PARTS` are wanted.
        shown: whether they light in EEVEE.
    """
    everything = _numbers(found, parts)
    return {
        "measure": MEASURE,
        "lamps": {"count": len(lamps.lamps), "share_of_light": _plain(lamps.share), "shown": shown},
        "all": everything | {"advice": _advice(found, lamps, parts, shown)},
        "objects": [_about(one) | _numbers([one], parts) for one in found],
    }


def _about(one: Findings) -> Json:
    about = {"points": len(one.weights), "area": _plain(one.area), "share_inside_others": _plain(one.inside)}
    return {"name": one.name, "mode": one.mode, "samples": one.samples, **about}


def _numbers(found: Sequence[Findings], parts: Collection[str]) -> Json:
    numbers: Json = {"total": _total(total(found)), "seams": {"relative_rms": with_interval(seams(found).relative_rms)}}
    if "SAMPLING" in parts:
        numbers["sampling"] = _sampling(sampling(found))
    if "TRUNCATION" in parts:
        numbers["truncation"] = _truncation(truncation(found))
    if "TESSELLATION" in parts:
        numbers["tessellation"] = _tessellation(tessellation(found))
    return numbers


def _advice(found: Sequence[Findings], lamps: Lamps, parts: Collection[str], shown: bool) -> Json:
    noise, loss, bend = sampling(found), truncation(found), tessellation(found)
    errors = [part.relative_rms.value for part in (noise, loss, bend)]
    lines = {
        "SAMPLING": about_sampling(noise, max(errors[1:]), max((one.samples for one in found), default=0)),
        "TRUNCATION": about_truncation(loss, lamps, shown),
        "TESSELLATION": about_tessellation(bend, max(errors[:2])),
    }
    advice: Json = {part.lower(): line for part, line in lines.items() if part in parts}
    bounces = any(one.mode in BOUNCING for one in found)
    sunk = seams(found)
    if at_seams := about_seams(sunk, max(errors)):
        advice["seams"] = at_seams
    parts_of_it = [part.relative_rms for part in (noise, loss, bend, sunk)]
    if rest := about_rest(total(found).relative_rms, parts_of_it, bounces):
        advice["rest"] = rest
    return advice


def _total(part: Total) -> Json:
    return {"relative_rms": with_interval(part.relative_rms), "bias": with_interval(part.bias)}


def _sampling(part: Sampling) -> Json:
    return {"relative_rms": with_interval(part.relative_rms), "percentile_95": with_interval(part.percentile_95)}


def _tessellation(part: Tessellation) -> Json:
    shares = {name: _plain(share) for name, share in part.shares.items()}
    return {"relative_rms": with_interval(part.relative_rms), "share_of_squared_error": shares}


def _truncation(part: Truncation) -> Json:
    return {
        "relative_rms": with_interval(part.relative_rms),
        "by_order": {str(order): with_interval(one) for order, one in part.by_order.items()},
        "without_lamps": with_interval(part.without_lamps) if part.without_lamps else None,
        "reference_interval": _plain(part.reference_interval),
        "reference_converged": part.reference_interval <= CONVERGED,
    }


def picture_report(found: PictureDifference, flip: float | None) -> Json:
    """Report a comparison of pictures."""
    return {
        "relative_rms": with_interval(found.relative_rms),
        "bias": with_interval(found.bias),
        "percentile_95": with_interval(found.percentile_95),
        "pixels": found.pixels,
        "flip": None if flip is None else _plain(flip),
        "note": None if flip is not None else "FLIP was left out: flip-evaluator is not installed for this Python.",
        "advice": about_pictures(found),
    }


def advice_lines(document: Json) -> list[str]:
    """The advice of a report, a line per part."""
    lines = list(document.get("all", {}).get("advice", {}).values())
    if "end_to_end" in document:
        lines += [line for line in (document["end_to_end"]["advice"], document["end_to_end"]["note"]) if line]
    return lines


def with_interval(number: Estimate) -> Json:
    """Write an estimate as a number and its interval; null where there was nothing to measure."""
    return {"value": _plain(number.value), "low": _plain(number.low), "high": _plain(number.high)}


def _plain(number: float) -> float | None:
    """JSON has no NaN; five digits are more than any interval leaves."""
    return float(f"{number:.5g}") if isfinite(number) else None
