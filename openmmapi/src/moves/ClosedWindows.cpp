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
 * Get whether the links of each closure keep their place relative to each other: none of the torsions is between them,
 * or all are.
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
 * Get the torsions of a pool on the way from a link to the root, each as it is met.
 */
static vector<WindowStep> findRootward(const LinkStructure& structure, int link, const vector<bool>& isInPool)
{
    vector<WindowStep> way;
    for (; structure.getLinks()[link].parent != -1; link = structure.getLinks()[link].parent) {
        const int torsion = structure.getLinks()[link].torsion;
        if (torsion != -1 && isInPool[torsion])
            way.push_back({torsion, true});
    }
    return way;
}

/**
 * Get the torsions of a pool in the ring of a closure, in a row from the second of its links to the first.
 */
static vector<WindowStep> findRing(const LinkStructure& structure, const pair<int, int>& links,
                                   const vector<bool>& isInPool)
{
    vector<WindowStep> ring = findRootward(structure, links.second, isInPool);
    vector<WindowStep> other = findRootward(structure, links.first, isInPool);
    while (!ring.empty() && !other.empty() && ring.back().torsion == other.back().torsion) {
        ring.pop_back();
        other.pop_back();
    }
    for (auto step = other.rbegin(); step != other.rend(); ++step)
        ring.push_back({step->torsion, false});
    return ring;
}

/**
 * Get whether each torsion of a row moves the next, or each is moved by the next: then all lie on one way to a root.
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
 * Get the index of a list of choices, which is made if there is none like it.
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
 * Add the window of the last torsions of a row. Returns false if they can't be one.
 *
 * @param isRing   whether the row is one of a ring: then it is no window unless it leads over a closure or over what
 *                 the ring hangs on
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
    // Of rows that end with the same torsion all but the longest are parts of it.

    const int numTorsions = structure.getTorsionLinks().size();
    vector<vector<WindowStep>> rows(numTorsions);
    for (const vector<int>& row : findTorsionWindows(structure, torsions, LARGEST_SIZE))
        if (row.size() > rows[row.back()].size()) {
            rows[row.back()].clear();
            for (int torsion : row)
                rows[row.back()].push_back({torsion, false});
        }

    // In a ring one can end anywhere.

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
