"""What makes an edge a crease: it is much sharper than the surface bends the same way beside it.

The facets of a cylinder bend across its rim, not along with it, and do not count against it. Masks
of feature edges are (3F,) bool over halfedges; they are changed in place.
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import TriangleSurface, next_halfedge, previous_halfedge
from .bending import bend_tensors, principal_bends
from .crease_chains import direction, find_chains

# A crease is so many times sharper than the surface bends beside it; ears of an animal are not.
_LEAST_CONTRAST = 8.0
# The creases of a component against the bends of all its other edges, so far as these bend it both
# ways: where everything does, as on a coarse cage of an animal, sharp edges mean nothing.
# Both contrasts must be missing: the apex of a cone alone bends both ways.
_LEAST_MEAN_CONTRAST, _ENOUGH_CONTRAST = 32.0, 8.0


def drop_faint(surface: TriangleSurface, crease, angle) -> None:
    """Remove chains not much sharper than the edges beside them, those parallel to it above all.

    angle  (3F,) float64, dihedral angles in radians
    """
    edge = surface.edges[crease[surface.edges]]
    chain, _ = find_chains(surface, edge)
    twin = surface.twin[edge]
    beside = np.stack(
        [next_halfedge(edge), previous_halfedge(edge), next_halfedge(twin), previous_halfedge(twin)]
    )
    parallel = np.einsum("sni,ni->sn", direction(surface, beside), direction(surface, edge)) ** 2
    weight = np.where(crease[beside] | (surface.twin[beside] < 0), 0.0, parallel)
    bend = np.bincount(chain, (weight * angle[beside]).sum(0))
    sharp = np.bincount(chain, angle[edge]) / np.bincount(chain)
    faint = sharp * np.bincount(chain, weight.sum(0)) < _LEAST_CONTRAST * bend
    gone = edge[faint[chain]]
    crease[gone] = crease[surface.twin[gone]] = False


def drop_crumpled(surface: TriangleSurface, crease, angle) -> None:
    """Remove all creases of components that bend nearly as much elsewhere, and both ways.

    angle  (3F,) float64, dihedral angles in radians
    """
    edge = surface.edges[surface.twin[surface.edges] >= 0]
    part, sharp = surface.component[edge // 3], crease[edge]
    weight = surface.edge_length[edge]
    bend = weight * angle[edge]

    def mean(chosen):
        length = np.bincount(part[chosen], weight[chosen], surface.component_count)
        total = np.bincount(part[chosen], bend[chosen], surface.component_count)
        return total / np.maximum(length, 1e-300)

    contrast = mean(sharp) / np.maximum(mean(~sharp), 1e-300)
    crumpled = contrast < _LEAST_MEAN_CONTRAST * _both_ways(surface, crease)
    crumpled &= contrast < _ENOUGH_CONTRAST
    crease &= ~np.repeat(crumpled[surface.component], 3)


def _both_ways(surface, crease):
    """The smaller over the larger principal bend off creases, (component_count,): 0 on cylinders."""
    smaller, larger = principal_bends(surface, bend_tensors(surface))
    smooth = ~surface.on_boundary
    smooth[surface.tail[crease]] = False
    part = np.empty(surface.vertex_count, np.int64)
    part[surface.tail] = np.repeat(surface.component, 3)
    part, smaller, larger = part[smooth], smaller[smooth], larger[smooth]
    total = np.bincount(part, larger, surface.component_count)
    return np.bincount(part, smaller, surface.component_count) / np.maximum(total, 1e-300)
