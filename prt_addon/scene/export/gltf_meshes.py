# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes meshes that the glTF exporter has gathered: our layers leave their vertex colours, rounded, left out, or as light.

What is written is a copy with the same accessors where nothing differs, as nodes that share a mesh may show different light.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ...core.exchange import shorts
from ...core.exchange.gltf_extras import EXTRAS, SCALES
from ...core.layout import BACKS, LAYERS, OWN_AXES_BELOW, unpacked_backs
from ...core.shown import shown

_SHORT, _FLOAT = 5122, 5126
_COMPONENTS: dict[int, tuple[type, float]] = {
    5121: (np.uint8, 255.0),
    5123: (np.uint16, 65535.0),
    _FLOAT: (np.float32, 1.0),
}
"""NumPy's types of glTF's numbers of components, and what stands for 1."""
_ROUNDING = 1.0 / 65535.0


def has_layers(mesh: Any) -> bool:
    """Whether a gathered mesh carries transport."""
    return any(LAYERS[0] in primitive.attributes for primitive in mesh.primitives)


def in_own_axes(mesh: Any) -> bool:
    """Whether its transport is in the axes of the object."""
    first = next(primitive for primitive in mesh.primitives if LAYERS[0] in primitive.attributes)
    return bool((_values(first.attributes[LAYERS[0]])[:1, 3] < OWN_AXES_BELOW).any())


def drop_colours(attributes: dict[str, Any], has_others: bool) -> None:
    """Remove vertex colours that hold our layers, and number the others anew; all of them if there are no others.

    They are known by what they hold: the exporter names no sources.
    """
    layers = [_values(attributes[name]) for name in LAYERS + BACKS if name in attributes]
    colours = sorted((name for name in attributes if name.startswith("COLOR_")), key=lambda name: int(name[6:]))
    kept = []
    for name in colours:
        accessor = attributes.pop(name)
        values = _values(accessor)
        if has_others and not any(_same(values, layer) for layer in layers):
            kept.append(accessor)
    attributes.update({f"COLOR_{number}": accessor for number, accessor in enumerate(kept)})


@dataclass
class Writer:
    """Makes the meshes that are written of those that were gathered.

    Attributes:
        transport: whether layers are written.
        rounds: whether to 16 bits a number.
        cut_off: by the names of meshes, the share of vertices whose light is cut off at 1.
        error, whole: sums of squares over all that was rounded: what rounding changed of the transport, and the transport.
    """

    transport: bool
    rounds: bool
    cut_off: dict[str, float] = field(default_factory=dict)
    error: float = 0.0
    whole: float = 0.0
    _written: dict[tuple[int, bytes], Any] = field(default_factory=dict)
    _based: dict[int, tuple[Any, Any]] = field(default_factory=dict)

    def written(self, mesh: Any, light: npt.NDArray[np.float64] | None) -> Any:
        """What is written of a mesh; always the same object for the same light.

        Args:
            mesh: as the exporter has gathered it.
            light: (9, 3) in the axes of the transport, for the first vertex colours; None for none.
        """
        key = id(mesh), b"" if light is None else light.tobytes()
        if key not in self._written:
            self._written[key] = self._base(mesh) if light is None else self._with_light(mesh, light)
        return self._written[key]

    def _base(self, mesh: Any) -> Any:
        """The mesh without light; both are kept, so that no other mesh gets the identity of one."""
        if id(mesh) not in self._based:
            base = _copied(mesh)
            for primitive in base.primitives:
                if LAYERS[0] in primitive.attributes:
                    self._change_layers(primitive)
            self._based[id(mesh)] = mesh, base
        return self._based[id(mesh)][1]

    def _change_layers(self, primitive: Any) -> None:
        """Leave of each set of layers, fronts and backs, what is wanted."""
        for key, names in SCALES.items():
            accessors = [primitive.attributes.pop(name) for name in names if name in primitive.attributes]
            if not self.transport or len(accessors) < len(names):
                continue
            if self.rounds:
                accessors = self._rounded(primitive, key, accessors)
            primitive.attributes.update(zip(names, accessors, strict=True))

    def _rounded(self, primitive: Any, key: str, accessors: list[Any]) -> list[Any]:
        layers = np.stack([_values(accessor) for accessor in accessors], axis=1)
        numbers, scales = shorts.rounded(layers)
        wanted = _transport_of(layers.astype(np.float32))
        lost = _transport_of(shorts.restored(numbers / shorts.MOST, scales)) - wanted
        self.error += float((lost**2).sum(dtype=np.float64))
        self.whole += float((wanted**2).sum(dtype=np.float64))
        extras = primitive.extras or {}
        primitive.extras = {**extras, EXTRAS: {**extras.get(EXTRAS, {}), key: scales.tolist()}}
        found = [_holding(accessor, numbers[:, i]) for i, accessor in enumerate(accessors)]
        for accessor in found:
            accessor.component_type, accessor.normalized = type(accessor.component_type)(_SHORT), True
        return found

    def _with_light(self, mesh: Any, light: npt.NDArray[np.float64]) -> Any:
        """The mesh with what a white surface shows of its front as `COLOR_0`, in 0 to 1 as glTF demands of it; other colours follow."""
        lighted, bright, vertices = _copied(self._base(mesh)), 0, 0
        for gathered, primitive in zip(mesh.primitives, lighted.primitives, strict=True):
            if LAYERS[0] not in gathered.attributes:
                continue
            layers = [gathered.attributes[name] for name in LAYERS]
            colours = shown(np.stack([_values(layer)[:, :3] for layer in layers], axis=1), light)
            bright, vertices = bright + int((colours.max(axis=1) > 1.0).sum()), vertices + len(colours)
            _put_first(primitive.attributes, layers[0], np.minimum(colours, 1.0))
        if bright:
            self.cut_off[mesh.name] = max(self.cut_off.get(mesh.name, 0.0), bright / vertices)
        return lighted


def _transport_of(layers: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """(N, 9, 3) T of the layers of fronts (N, 9, 4), or of those of backs (N, 3, 4)."""
    return layers[..., :3] if layers.shape[1] == len(LAYERS) else unpacked_backs(layers)


def _put_first(attributes: dict[str, Any], like: Any, colours: npt.NDArray[np.float64]) -> None:
    """Make colours (N, 3) the first of the vertex colours, in an accessor that is like one of four floats."""
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = colours
    others = [attributes.pop(name) for name in sorted(name for name in attributes if name.startswith("COLOR_"))]
    if others and (_values(others[0]) == 1.0).all():
        del others[0]  # the exporter's own, so that viewers do not multiply with unused paint
    attributes.update({f"COLOR_{number}": each for number, each in enumerate([_holding(like, rgba), *others])})


def _copied(mesh: Any) -> Any:
    """A mesh whose primitives can be changed."""
    made = copy.copy(mesh)
    made.primitives = [copy.copy(primitive) for primitive in mesh.primitives]
    for primitive in made.primitives:
        primitive.attributes = dict(primitive.attributes)
    return made


def _holding(accessor: Any, values: npt.NDArray[Any]) -> Any:
    """An accessor that is like another, and holds other values."""
    made = copy.copy(accessor)
    made.buffer_view = copy.copy(accessor.buffer_view)
    made.buffer_view.data = values.tobytes()
    return made


def _values(accessor: Any) -> npt.NDArray[np.float64]:
    """(N, width) what a gathered accessor holds; whole numbers stand for 0 to 1."""
    kind, most = _COMPONENTS[int(accessor.component_type)]
    values: npt.NDArray[Any] = np.frombuffer(accessor.buffer_view.data, dtype=kind).reshape(accessor.count, -1)
    return values.astype(np.float64) / most


def _same(colour: npt.NDArray[np.float64], layer: npt.NDArray[np.float64]) -> bool:
    """Whether a colour is a layer, clamped to 0..1 and rounded to 16 bits."""
    clamped = np.clip(layer[:, :3], 0.0, 1.0)
    return len(colour) == len(layer) and bool(np.abs(colour[:, :3] - clamped).max(initial=0.0) <= _ROUNDING)
