#ifndef OPENMM_CHAINTREE_CLOSEDWINDOWS_H_
#define OPENMM_CHAINTREE_CLOSEDWINDOWS_H_

#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <vector>

namespace ChainTreePlugin {

/**
 * The windows of closed moves: rows of torsions, each of which moves the next, that can turn so that all behind them
 * stays where it is. What each closure keeps together is left as it is, or moves as one piece.
 *
 * In a ring of a closure a row may lead over that, and over the link on which the ring hangs. The rest of the ring then
 * moves as one piece, and with it what hangs on it.
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
     * Find all windows. For each torsion there is the one of eight torsions that ends with it, if its first and its
     * last torsion can be drivers: such windows shift least of what they turn, and are accepted twice as often as
     * others. In rings of closures one ends with each torsion, too, if it leads over the closure or over the link on
     * which the ring hangs. What these leave out is turned by windows of nine, eight or seven torsions with any pivots.
     * There may be none at all.
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
    /** Lists of choices, and what they belong to: what findChoices() was given. */
    std::vector<std::vector<Pivots>> choices;
    std::vector<std::array<int, 3>> choicesOf;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CLOSEDWINDOWS_H_*/
