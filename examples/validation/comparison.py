"""Tables that compare two Samples of one molecule."""

import numpy as np
from geometry import Geometry, basins, thirds
from molecules import makeMolecule
from samples import compareMeans, compareWidths, effectiveSize, totalVariation

BINS = 18  # of phi and of psi


class Comparison:
    """Two Samples, and the p-values of all that was compared."""

    def __init__(self, *samples):
        self.samples = samples
        topology, system, _ = makeMolecule(samples[0].molecule)
        self.geometry = Geometry(topology, system)
        self.measured = [self.geometry.measure(of.positions.reshape(-1, *of.positions.shape[2:])) for of in samples]
        self.pValues = []

    def report(self):
        """Print all tables."""
        for of in self.samples:
            chains, frames = of.positions.shape[:2]
            print(f"{of.molecule}, {of.temperature:g} K, {of.method}: {chains} x {frames} frames in {of.seconds:.0f} s")
        self._reportShares()
        self._reportPlanes()
        self._reportKinds("bonds, nm", [of.lengths for of in self.measured], 6)
        self._reportKinds("angles, degrees", [of.angles for of in self.measured], 3)
        self._reportEnergies()

    def _compare(self, values, compare=compareMeans):
        """Return the Estimate for the means of two arrays with a row a frame; keep its p-value."""
        found = compare(*(of.inBlocks(value).mean(axis=1) for of, value in zip(self.samples, values, strict=True)))
        self.pValues.append(found.pValue)
        return found

    def _reportShares(self):
        _printHeader("shares", "difference  errors  effective sizes")
        for residue in self._planes():
            self._printShares(residue, "", [basins(*of.planes[residue]) for of in self.measured])
        for residue, name in self.geometry.torsions:
            if name not in ("phi", "psi"):
                self._printShares(residue, name, [thirds(of.torsions[residue, name]) for of in self.measured])

    def _planes(self):
        """Return the residues that have phi and psi."""
        return self.measured[0].planes.keys()

    def _printShares(self, residue, torsion, isIn):
        for name in isIn[0]:
            found = self._compare([of[name].astype(float) for of in isIn])
            sizes = [effectiveSize(*of) for of in (found.first, found.second)]
            label = " ".join(filter(None, (self.geometry.residues[residue], torsion, name)))
            _printRow(label, found, 4, f"{found.difference:10.4f}{found.errors:8.1f}{sizes[0]:9.0f}{sizes[1]:8.0f}")

    def _reportPlanes(self):
        for residue in self._planes():
            cells = [_cellsOf(*of.planes[residue]) for of in self.measured]
            blocks = [of.inBlocks(found) for of, found in zip(self.samples, cells, strict=True)]
            seen, expected, quantile = totalVariation(*map(_histograms, blocks))
            print(
                f"{self.geometry.residues[residue]}, {BINS} x {BINS} bins of phi and psi: total variation {seen:.4f}; "
                f"of such samples of one distribution {expected:.4f}, in one of 20 above {quantile:.4f}"
            )

    def _reportKinds(self, title, measured, digits):
        """Print means and widths of bonds or angles, of the members of a kind together."""
        _printHeader(title, "errors  percent")
        for kind in measured[0]:
            values = [of[kind] for of in measured]
            mean = self._compare([of.mean(axis=1) for of in values])
            width = self._compare([((of - of.mean()) ** 2).mean(axis=1) for of in values], compareWidths)
            for label, found in ((kind, mean), ("  width", width)):
                percent = 100 * found.difference / max(abs(found.first[0]), 1e-30)
                _printRow(label, found, digits, f"{found.errors:6.1f}{percent:9.2f}")

    def _reportEnergies(self):
        _printHeader("energies, kJ/mol", "difference  errors")
        columns = [of.energies.reshape(-1, len(of.forces)) for of in self.samples]
        for index, name in enumerate(self.samples[0].forces):
            self._printEnergy(name, [of[:, index] for of in columns])
        self._printEnergy("all", [of.sum(axis=1) for of in columns])

    def _printEnergy(self, name, values):
        found = self._compare(values)
        _printRow(name, found, 3, f"{found.difference:10.3f}{found.errors:8.1f}")


def _cellsOf(phi, psi):
    """Return the number of each frame's cell of the plane."""
    column, row = (np.clip(((angle + 180) / 360 * BINS).astype(int), 0, BINS - 1) for angle in (phi, psi))
    return column * BINS + row


def _histograms(blocks):
    return np.array([np.bincount(cells, minlength=BINS**2) / len(cells) for cells in blocks])


def _printHeader(title, rest):
    print(f"\n{title:24}{'first':>20}{'second':>22}  {rest}")


def _printRow(label, found, digits, rest):
    numbers = "".join(f"{mean:12.{digits}f} ±{error:8.{digits}f}" for mean, error in (found.first, found.second))
    print(f"{label:22}{numbers}  {rest}")
