#ifndef OPENMM_CHAINTREE_TORSIONWINDOWS_H_
#define OPENMM_CHAINTREE_TORSIONWINDOWS_H_

#include "openmm/Vec3.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * Get the torsions of the backbones of all molecules. A backbone begins at the root of a molecule and follows the
 * torsion that moves most particles, to the end of the chain. A branch is a backbone, too, if it has at least 8
 * torsions, more than side chains of proteins and nucleic acids have.
 */
OPENMM_EXPORT_CHAINTREE std::vector<int> findBackboneTorsions(const LinkStructure& structure);

/**
 * Get the torsions that moves of windows choose from: the given ones or, if none are given, the torsions of the
 * backbones. Torsions in rings of closures are left out, unless the move keeps closures.
 *
 * Throws an exception if there are no torsions, or if a given one does not exist, is given twice, or lies in the ring
 * of a closure that the move does not keep.
 *
 * @param name          the move's name in exceptions
 * @param keepsClosures whether the move keeps closures
 */
OPENMM_EXPORT_CHAINTREE std::vector<int> findWindowTorsions(const LinkStructure& structure,
                                                            const std::vector<int>& torsions, const std::string& name,
                                                            bool keepsClosures = false);

/**
 * Get all windows: rows of consecutive torsions of a pool, the one nearest to the root first. Each torsion of a window
 * moves the axes of all after it. Torsions between them that are not in the pool do not turn.
 *
 * For each torsion of the pool there is the window of `size` torsions that ends with it. Where a chain begins or ends,
 * there are also the shorter windows that begin or end with it, so that a torsion there is in as many as others.
 */
OPENMM_EXPORT_CHAINTREE std::vector<std::vector<int>> findTorsionWindows(const LinkStructure& structure,
                                                                         const std::vector<int>& pool, int size);

/**
 * A torsion of a window, and whether the window runs towards the root there.
 */
class WindowStep {
public:
    int torsion;
    bool isRootward;
};

/**
 * The axis of each torsion of a window: the indices of its two particles in a list, in the window's direction.
 */
typedef std::vector<std::pair<int, int>> WindowAxes;

/**
 * Find the axes of the torsions of a window.
 *
 * @param steps            the torsions in a row
 * @param[out] particles   the particles of all axes, each once, in the order of the row
 */
OPENMM_EXPORT_CHAINTREE WindowAxes findWindowAxes(const LinkStructure& structure, const std::vector<WindowStep>& steps,
                                                  std::vector<int>& particles);
/**
 * Find the axes of torsions each of which moves the next.
 */
OPENMM_EXPORT_CHAINTREE WindowAxes findWindowAxes(const LinkStructure& structure, const std::vector<int>& torsions,
                                                  std::vector<int>& particles);

/**
 * Get the unit vector of an axis, in the window's direction.
 *
 * @param positions  the positions of the particles that findWindowAxes() has listed
 */
OPENMM_EXPORT_CHAINTREE OpenMM::Vec3 getAxisDirection(const std::vector<OpenMM::Vec3>& positions,
                                                      const std::pair<int, int>& axis);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_TORSIONWINDOWS_H_*/
