#include "openmmchaintree/internal/ClosedWindows.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace std;

/** The most torsions of a window. */
static const size_t LARGEST_SIZE = 9;

/**
 * List the ways to choose three pairs of neighbours.
 *
 * @param joints        a bit for each torsion that shares a particle with the next
 * @param size          the number of torsions
 * @param endsAreFree   whether neither the first nor the last torsion may be in a pair
 */
static vector<ClosedWindows::Pivots> listChoices(unsigned joints, int size, bool endsAreFree)
{
    const int begin = endsAreFree ? 1 : 0, end = endsAreFree ? size - 2 : size - 1;
    vector<ClosedWindows::Pivots> choices;
    for (int i = begin; i < end; i++)
        for (int j = i + 2; j < end; j++)
            for (int k = j + 2; k < end; k++)
                if ((joints >> i & joints >> j & joints >> k & 1) != 0)
                    choices.push_back({i, i + 1, j, j + 1, k, k + 1});
    return choices;
}

/**
 * Get whether the links of each closure keep their relative place: none of the torsions is between them, or all are.
 */
static bool keepsClosures(const LinkStructure& structure, const vector<WindowStep>& row)
{
    for (auto& links : structure.getClosures()) {
        size_t between = 0;
        for (const WindowStep& step : row)
            if (structure.moves(step.torsion, links.first) != structure.moves(step.torsion, links.second))
                between++;
        if (between != 0 && between != row.size())
            return false;
    }
    return true;
}

/**
 * Get the torsions of a pool in the ring of a closure, in a row from the second of its links to the first.
 */
static vector<WindowStep> findRing(const LinkStructure& structure, const pair<int, int>& links,
                                   const vector<bool>& isInPool)
{
    const auto path = structure.findPath(links.second, links.first);
    vector<WindowStep> ring;
    auto add = [&](int link, bool isRootward) {
        const int torsion = structure.getLinks()[link].torsion;
        if (torsion != -1 && isInPool[torsion])
            ring.push_back({torsion, isRootward});
    };
    for (int link : path.first)
        add(link, true);
    for (auto link = path.second.rbegin(); link != path.second.rend(); ++link)
        add(*link, false);
    return ring;
}

/**
 * Get whether each torsion of a row moves the next, or each is moved by the next: then all lie on one path to a root.
 */
static bool isOnWayToRoot(const LinkStructure& structure, const vector<WindowStep>& row)
{
    const vector<int>& links = structure.getTorsionLinks();
    for (size_t i = 1; i < row.size(); i++) {
        const WindowStep &step = row[i - 1], &next = row[i];
        if (step.isRootward != next.isRootward)
            return false;
        if (!(step.isRootward ? structure.moves(next.torsion, links[step.torsion])
                              : structure.moves(step.torsion, links[next.torsion])))
            return false;
    }
    return true;
}

/**
 * Get the index of a list of choices, and make the list if there is none.
 */
int ClosedWindows::findChoices(unsigned joints, int size, bool endsAreFree)
{
    const array<int, 3> key = {{(int)joints, size, endsAreFree}};
    auto known = find(choicesOf.begin(), choicesOf.end(), key);
    if (known != choicesOf.end())
        return known - choicesOf.begin();
    choicesOf.push_back(key);
    choices.push_back(listChoices(joints, size, endsAreFree));
    return choices.size() - 1;
}

/**
 * Add the window of the last torsions of a row. Returns false if they are not a window.
 *
 * @param isRing   whether the row is part of a ring: then a window must cross a closure or the link on which the ring
 *                 hangs
 */
bool ClosedWindows::addWindow(const LinkStructure& structure, const vector<WindowStep>& row, size_t size,
                              bool endsAreFree, bool isRing)
{
    if (row.size() < size)
        return false;
    const vector<WindowStep> steps(row.end() - size, row.end());
    if (!keepsClosures(structure, steps) || (isRing && isOnWayToRoot(structure, steps)))
        return false;
    Window window;
    for (const WindowStep& step : steps)
        window.torsions.push_back(step.torsion);
    window.axes = findWindowAxes(structure, steps, window.particles);
    unsigned joints = 0;
    for (size_t i = 1; i < size; i++)
        if (window.axes[i].first == window.axes[i - 1].second)
            joints |= 1u << (i - 1);
    window.choices = findChoices(joints, size, endsAreFree);
    if (choices[window.choices].empty())
        return false;
    windows.push_back(window);
    return true;
}

ClosedWindows::ClosedWindows(const LinkStructure& structure, const vector<int>& torsions)
{
    // The longest row that ends with a torsion includes all others.

    const int numTorsions = structure.getTorsionLinks().size();
    vector<vector<WindowStep>> rows(numTorsions);
    for (const vector<int>& row : findTorsionWindows(structure, torsions, LARGEST_SIZE))
        if (row.size() > rows[row.back()].size()) {
            rows[row.back()].clear();
            for (int torsion : row)
                rows[row.back()].push_back({torsion, false});
        }

    // In a ring a row can end at any torsion.

    vector<bool> isInPool(numTorsions, false);
    for (int torsion : torsions)
        isInPool[torsion] = true;
    for (auto& links : structure.getClosures()) {
        const vector<WindowStep> ring = findRing(structure, links, isInPool);
        const size_t length = min(LARGEST_SIZE, ring.size());
        for (size_t first = 0; first < ring.size(); first++) {
            rows.push_back({});
            for (size_t i = 0; i < length; i++)
                rows.back().push_back(ring[(first + i) % ring.size()]);
        }
    }
    auto add = [&](size_t row, size_t size, bool endsAreFree) {
        return addWindow(structure, rows[row], size, endsAreFree, (int)row >= numTorsions);
    };
    for (size_t row = 0; row < rows.size(); row++)
        add(row, 8, true);
    vector<bool> isTurned(numTorsions, false);
    for (const Window& window : windows)
        for (int torsion : window.torsions)
            isTurned[torsion] = true;
    auto isLeftOut = [&](const WindowStep& step) {
        return !isTurned[step.torsion];
    };
    for (size_t row = 0; row < rows.size(); row++)
        if (any_of(rows[row].begin(), rows[row].end(), isLeftOut))
            add(row, 9, true) || add(row, 8, false) || add(row, 9, false) || add(row, 7, false);
}
