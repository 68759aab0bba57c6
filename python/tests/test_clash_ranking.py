"""Residues and pairs of atoms that clash, counted as frames come in: as counted by hand, and in batches of any size."""

import numpy as np
import pytest
from openmmchaintree.command.reports import clashranking
from openmmchaintree.command.reports.clashranking import ClashRanking
from openmmchaintree.naming import AtomName
from openmmchaintree.structures.clashsearch import FrameOverlaps

NAMES = [AtomName("A", f"R {atom // 3}", f"C{atom % 3}") for atom in range(12)]


def randomFrames(count):
    """Frames with 0 to 20 clashes, many of them equal in pair, residue and overlap."""
    random = np.random.default_rng(1)
    frames = []
    for number in range(count):
        pairs = {tuple(sorted(random.choice(12, 2, replace=False).tolist())) for _ in range(random.integers(21))}
        overlaps = random.choice([0.05, 0.06, 0.07], len(pairs))
        frames.append(FrameOverlaps(number, np.array(sorted(pairs), dtype=np.int32).reshape(-1, 2), overlaps, 0.0))
    return frames


def rankByHand(frames, keysOf):
    """Return the rows of keys by the rule: most clashes first, then the worst, then the first."""
    met = {}
    for frame in frames:
        for pair, overlap in zip(frame.pairs.tolist(), frame.overlaps.tolist(), strict=True):
            for key in dict.fromkeys(keysOf(pair)):
                met.setdefault(key, []).append((overlap, frame.number))
    rows = []
    for key, entries in met.items():
        worst = max(overlap for overlap, _ in entries)
        first = min(number for overlap, number in entries if overlap == worst)
        rows.append((key, len(entries), len({number for _, number in entries}), worst, first))
    return sorted(rows, key=lambda row: (-row[1], -row[3]))


def numbers(entry):
    return entry["clashes"], entry["frames"], entry["worstOverlap"], entry["worstFrame"]


@pytest.mark.parametrize("batch", [1, 17, 10**9])
def test_ranking(monkeypatch, batch):
    monkeypatch.setattr(clashranking, "_BATCH", batch)
    frames = randomFrames(60)
    ranking = ClashRanking(NAMES)
    for frame in frames:
        ranking.add(frame)
    for _ in range(2):  # asking changes nothing
        pairs, residues = ranking.rankPairs(), ranking.rankResidues()
        found = [(tuple(entry["particles"]), *numbers(entry)) for entry in pairs]
        assert found == rankByHand(frames, lambda pair: [tuple(pair)]) and len(found) == 66
        assert all(entry["atoms"] == [str(NAMES[atom]) for atom in entry["particles"]] for entry in pairs)
        found = [(entry["residue"], *numbers(entry)) for entry in residues]
        assert found == rankByHand(frames, lambda pair: [NAMES[atom].describeResidue() for atom in pair])
    assert len(residues) == 4 and residues[0]["clashes"] > residues[0]["frames"]


def test_noClashes():
    ranking = ClashRanking(NAMES)
    ranking.add(FrameOverlaps(0, np.empty((0, 2), dtype=np.int32), np.empty(0), 0.0))
    assert ranking.rankPairs() == [] and ranking.rankResidues() == []
