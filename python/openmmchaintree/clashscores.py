"""Scoring the clashes of files by the definitions of other programs."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .clashes import Path, listFrames
from .nearnames import didYouMean

if TYPE_CHECKING:
    from .scoring.modelscores import ClashScores


def scoreClashes(
    structure: Path,
    trajectory: Path | None = None,
    definitions: str | Iterable[str] = "molprobity",
    keepHydrogens: bool = False,
    flips: bool = False,
) -> "list[ClashScores]":
    """Score the clashes of all models of a structure, or of all frames of a trajectory, by the field's definitions.

        for scores in scoreClashes("model.pdb", definitions=("molprobity", "af3")):
            print(scores.molprobity.clashscore, any(chain.hasClash for chain in scores.chains))

    A clashscore of a model of 2,500 atoms takes 0.3 s. Sources: cctbx (mmtbx/validation/clashscore.py), Reduce 4.16 and
    Probe 2.26; AlphaFold 3 (confidences.py); PoseBusters 0.6 (dock.yml).

    Parameters
    ----------
    structure, trajectory : str or Path
        as for `findClashes`
    definitions : str or iterable of str
        "own": the clashes of `findClashes`. "molprobity": MolProbity's clashscore, with hydrogens as Reduce places them
        and contacts as Probe counts them; ligands have the hydrogens of the file.
        "af3": AlphaFold 3's `has_clash`. "posebusters": PoseBusters' checks of distance and volume of each ligand,
        which needs RDKit.
    keepHydrogens : bool
        score the hydrogens of the file instead
    flips : bool
        for a clashscore, first flip side chains of Asn, Gln and His where hydrogens fit clearly better

    Returns
    -------
    list of ClashScores
        the scores by these definitions, with broken bonds, and rings that a bond passes through

    Raises
    ------
    InputError
        a ValueError, if a file cannot be read or is damaged, or a package is missing. Its attribute `frames` holds the
        results of earlier frames.
    ValueError
        if a definition is not known
    """
    from .scoring.modelscores import DEFINITIONS, ScoreSearch

    chosen = [definitions] if isinstance(definitions, str) else list(definitions)
    for definition in chosen:
        if definition not in DEFINITIONS:
            raise ValueError(f"there is no definition {definition!r}{didYouMean(definition, DEFINITIONS)}")
    return listFrames(ScoreSearch(structure, trajectory, chosen, keepHydrogens, flips))
