#ifndef OPENMM_CHAINTREE_CLOSEDWINDOWS_H_
#define OPENMM_CHAINTREE_CLOSEDWINDOWS_H_

#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * The windows of closed moves: rows of torsions, each of which moves the next, that can turn so that all behind them
 * stays where it is. What each closure keeps together is left as it is, or moves as one piece.
 */
class OPENMM_EXPORT_CHAINTREE ClosedWindows {
public:
    /** Which torsions of a window close it, by their places in it, ascending: three pairs of neighbours. */
    typedef std::array<int, 6> Pivots;
    class Window {
    public:
        /** Its torsions, each of which moves those behind it. */
        std::vector<int> torsions;
        /** The particles of their axes, each once. */
        std::vector<int> particles;
        /** The axis of each torsion: the places of its two particles in `particles`, the one on the root's side first.
         */
        std::vector<std::pair<int, int>> axes;
        /** The index of the list of its choices of pivots. */
        int choices;
    };
    /**
     * Find all windows: for each torsion the one that ends with it, of eight torsions, or of nine or seven where there
     * is none of eight. There may be none at all.
     *
     * @param structure  the links of the molecules
     * @param torsions   the torsions that windows may have
     */
    ClosedWindows(const LinkStructure& structure, const std::vector<int>& torsions);
    const std::vector<Window>& getWindows() const
    {
        return windows;
    }
    /**
     * Get all choices of pivots of a window.
     */
    const std::vector<Pivots>& getChoices(const Window& window) const
    {
        return choices[window.choices];
    }

private:
    bool addWindow(const LinkStructure& structure, const std::vector<int>& torsions);
    std::vector<Window> windows;
    /** Lists of choices, and what they belong to: a bit for each torsion that shares a particle with the next. */
    std::vector<std::vector<Pivots>> choices;
    std::vector<unsigned> choicesOf;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CLOSEDWINDOWS_H_*/
