"""The picture of an ensemble: radii of gyration, distances and contacts of residues."""

import numpy as np

from .figures import makeFigure, setTitle, writeFigure

_CONTACT = 0.8  # nm
_MOST_CONFORMERS = 500  # whose distances are averaged


def savePicture(output, name, ensemble):
    """Write the picture of an Ensemble to an Output."""
    positions = ensemble.positions[:: max(1, len(ensemble.positions) // _MOST_CONFORMERS)]
    positions = positions[:, _residuePlaces(ensemble)].astype(np.float64)
    count = positions.shape[1]
    squares, contacts = np.zeros((count, count)), np.zeros((count, count))
    for each in positions:
        distances = np.linalg.norm(each[:, np.newaxis] - each, axis=2)
        squares += distances**2
        contacts += distances < _CONTACT
    figure = makeFigure(13, 4)
    histogram, ofDistances, ofContacts = figure.subplots(1, 3)
    histogram.hist(ensemble.shapes.radiusOfGyration, bins="auto", color="tab:blue", density=True)
    mean = ensemble.estimates["radius of gyration"].mean
    histogram.axvline(mean, color="black", linewidth=1, label=f"mean {mean:.2f} nm")
    histogram.set(xlabel="radius of gyration (nm)", ylabel="density (1/nm)", title="Radius of gyration")
    histogram.legend(frameon=False)
    image = ofDistances.imshow(np.sqrt(squares / len(positions)), origin="lower", extent=_extent(count))
    figure.colorbar(image, ax=ofDistances, label="root mean square (nm)", shrink=0.85)
    ofDistances.set(xlabel="residue", ylabel="residue", title="Distances")
    shares = np.where(np.abs(np.subtract.outer(np.arange(count), np.arange(count))) < 3, np.nan, contacts)
    image = ofContacts.imshow(100 * shares / len(positions), origin="lower", extent=_extent(count), cmap="magma_r")
    figure.colorbar(image, ax=ofContacts, label=f"conformers within {_CONTACT:g} nm (%)", shrink=0.85)
    ofContacts.set(xlabel="residue", ylabel="residue", title="Contacts")
    setTitle(figure, name, f", {len(ensemble.positions):,} conformers")
    writeFigure(figure, output)


def _residuePlaces(ensemble):
    """Return the particles that stand for residues: beads or Cα atoms."""
    return [atom.index for atom in ensemble.topology.atoms() if atom.name == "CA"]


def _extent(count):
    """Return the limits of an image whose pixels are residues, numbered from 1."""
    return 0.5, count + 0.5, 0.5, count + 0.5
