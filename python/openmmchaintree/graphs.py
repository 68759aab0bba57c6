"""Graphs of atoms: neighbors, connected parts, trees and rings."""

import numpy as np


def neighborLists(count, bonds):
    """Return, for each of count atoms, the list of atoms bonded to it."""
    neighbors = [[] for _ in range(count)]
    for atom1, atom2 in bonds:
        neighbors[atom1].append(atom2)
        neighbors[atom2].append(atom1)
    return neighbors


def connectedParts(count, bonds):
    """Return for each of count atoms the number of its connected part, as an int array.

    Parts are numbered in the order of their first atoms. bonds : sequence of pairs, or (m, 2) int array
    """
    # Union-find.
    parent = list(range(count))

    def find(atom):
        while parent[atom] != atom:
            parent[atom] = parent[parent[atom]]
            atom = parent[atom]
        return atom

    for first, second in np.asarray(bonds, dtype=int).reshape(-1, 2).tolist():
        first, second = find(first), find(second)
        parent[max(first, second)] = min(first, second)
    lowest = np.array([find(atom) for atom in range(count)], dtype=int)
    return np.unique(lowest, return_inverse=True)[1]


def growTrees(neighbors, roots):
    """Yield (node, parent) along a tree from each root that no earlier tree has reached, parents first."""
    isReached = [False] * len(neighbors)
    for root in roots:
        pending = [] if isReached[root] else [root]
        isReached[root] = True
        while pending:
            parent = pending.pop()
            for node in neighbors[parent]:
                if not isReached[node]:
                    isReached[node] = True
                    pending.append(node)
                    yield node, parent


def ringBonds(neighbors):
    """Return the bonds that lie in a ring, as a set of (lower, higher) index.

    A depth-first search: a tree edge lies in a ring if a bond leads from below it to above it. O(atoms + bonds).
    """
    count = len(neighbors)
    order = [-1] * count  # when an atom was first met
    reach = [0] * count  # the earliest atom that its subtree reaches by one ring-closing bond
    inRing = set()
    clock = 0
    for start in range(count):
        if order[start] >= 0:
            continue
        order[start] = reach[start] = clock
        clock += 1
        path = [(start, -1, iter(neighbors[start]))]
        while path:
            atom, parent, remaining = path[-1]
            for other in remaining:
                if order[other] < 0:
                    order[other] = reach[other] = clock
                    clock += 1
                    path.append((other, atom, iter(neighbors[other])))
                    break
                if other != parent:
                    reach[atom] = min(reach[atom], order[other])
                    inRing.add((min(atom, other), max(atom, other)))
            else:
                path.pop()
                if parent >= 0:
                    reach[parent] = min(reach[parent], reach[atom])
                    if reach[atom] <= order[parent]:
                        inRing.add((min(atom, parent), max(atom, parent)))
    return inRing
