#ifndef OPENMM_CHAINTREE_CLOSEDWINDOWS_H_
#define OPENMM_CHAINTREE_CLOSEDWINDOWS_H_

#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <vector>

namespace ChainTreePlugin {

/**
 * The windows of closed moves: rows of torsions, each of which moves the next, that can turn without moving the rest of
 * the chain. Links that a closure keeps together do not move, or move as one piece.
 *
 * In the ring of a closure a row may cross the closure and the link on which the ring hangs. The rest of the ring, and
 * everything that hangs on it, then moves as one piece.
 */
class OPENMM_EXPORT_CHAINTREE ClosedWindows {
public:
    /** Which torsions of a window close it, by their places in it, ascending: three pairs of neighbours. */
    typedef std::array<int, 6> Pivots;
    class Window {
    public:
        /** Its torsions, in a row. */
        std::vector<int> torsions;
        /** The particles of their axes, each once. */
        std::vector<int> particles;
        WindowAxes axes;
        /** The index of the list of its choices of pivots. */
        int choices;
    };
    /**
     * Find all windows; there may be none. For each torsion there is the window of eight torsions that ends with it, if
     * its first and last torsions can be drivers: such windows move the least, and are accepted twice as often as
     * others. The same holds for each torsion in the ring of a closure, if the window crosses the closure or the link
     * on which the ring hangs. Torsions in none of these windows are turned by windows of nine, eight or seven torsions
     * with any pivots.
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
    int findChoices(unsigned joints, int size, bool endsAreFree);
    bool addWindow(const LinkStructure& structure, const std::vector<WindowStep>& row, size_t size, bool endsAreFree,
                   bool isRing);
    std::vector<Window> windows;
    /** Lists of choices, and the arguments of findChoices() for each. */
    std::vector<std::vector<Pivots>> choices;
    std::vector<std::array<int, 3>> choicesOf;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CLOSEDWINDOWS_H_*/
