"""Plates of grid squares, closed slabs over them, and the fewest rectangles that they consist of."""

import numpy as np


def random_mask(generator, size, share=0.75):
    """(size + 2, size + 2) bool within one row of False: holes that touch no other in a corner."""
    mask = np.pad(generator.random((size, size)) < share, 1)
    mask[1], mask[-2], mask[1:-1, 1], mask[1:-1, -2] = True, True, True, True
    mask[0], mask[-1], mask[:, 0], mask[:, -1] = False, False, False, False
    while True:
        a, b, c, d = mask[:-1, :-1], mask[1:, :-1], mask[:-1, 1:], mask[1:, 1:]
        touch = (a & d & ~b & ~c) | (b & c & ~a & ~d)
        if not touch.any():
            return mask
        i, j = np.argwhere(touch)[0]
        mask[i : i + 2, j : j + 2] = True


def plate_quads(mask):
    """(quads, vertex count) of the squares where a 2D mask is true."""
    return _numbered(_squares(mask))


def slab_quads(mask):
    """The closed slab of one square's height over the squares where a 2D mask is true.

    Returns (quads, vertex count, (n, 2) ends of its sharp edges, number of its flat walls).
    """
    side = np.array(mask.shape) + 1
    bottom = _squares(mask)
    layer = side.prod()
    tail, head = bottom.ravel(), np.roll(bottom, -1, axis=1).ravel()
    key, back = tail * layer + head, head * layer + tail
    rim = ~np.isin(key, back)
    walls = np.stack([tail[rim], head[rim], head[rim] + layer, tail[rim] + layer], 1)
    quads, count = _numbered(np.concatenate([bottom[:, ::-1], bottom + layer, walls]))
    first = len(quads) - len(walls)
    crease = [quads[first:, :2], quads[first:, 2:]]
    along = np.diff(np.stack(np.divmod(walls[:, :2], side[1])), axis=2)[..., 0].T
    # Walls that meet at a vertical edge and run in different directions.
    start = np.argsort(quads[first:, 0])
    after = start[np.searchsorted(quads[first:, 0], quads[first:, 1], sorter=start)]
    turn = (along != along[after]).any(1)
    crease.append(quads[first:, 1:3][turn])
    return quads, count, np.concatenate(crease), int(turn.sum())


def fewest_rectangles(mask):
    """The smallest number of rectangles, by Ohtsuki's formula: N - L + chi.

    N reflex corners, L the most chords between reflex corners that touch none of each other, chi
    the Euler characteristic.
    """
    filled = np.pad(mask, 1).astype(int)
    around = filled[:-1, :-1] + filled[1:, :-1] + filled[:-1, 1:] + filled[1:, 1:]
    reflex = around == 3
    chords = [_chords(reflex, filled), _chords(reflex.T, filled.T)]
    second = {tuple(cell[::-1]): k for k, chord in enumerate(chords[1]) for cell in chord}
    meets = [{second[cell] for cell in chord if cell in second} for chord in chords[0]]
    most = len(chords[0]) + len(chords[1]) - _matching(meets)
    edges = (filled[1:] | filled[:-1]).sum() + (filled[:, 1:] | filled[:, :-1]).sum()
    return int(reflex.sum()) - most + int((around > 0).sum() - edges + filled.sum())


def _squares(mask):
    corner = np.arange(np.prod(np.array(mask.shape) + 1)).reshape(np.array(mask.shape) + 1)
    corners = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return np.stack([c[mask.astype(bool)] for c in corners], 1)


def _numbered(quads):
    used, number = np.unique(quads, return_inverse=True)
    return number.reshape(-1, 4), len(used)


def _chords(reflex, filled):
    """Vertices of the chords along the second axis from one reflex corner to the next."""
    result = []
    inside = filled[:-1, 1:] & filled[1:, 1:]
    for i, j in np.argwhere(reflex):
        end = j
        while inside[i, end] and (end == j or not reflex[i, end]):
            end += 1
        if end > j and reflex[i, end]:
            result.append([(i, k) for k in range(j, end + 1)])
    return result


def _matching(neighbours):
    """Size of the largest matching of a bipartite graph, by augmenting paths."""
    partner = {}

    def augment(node, seen):
        for other in neighbours[node] - seen:
            seen.add(other)
            if other not in partner or augment(partner[other], seen):
                partner[other] = node
                return True
        return False

    return sum(augment(node, set()) for node in range(len(neighbours)))
