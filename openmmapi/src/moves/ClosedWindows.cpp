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
 * Get how many of the torsions of a window move a link; 0 if all do, which leaves it where it is.
 */
static int findPiece(const LinkStructure& structure, const vector<int>& torsions, int link)
{
    size_t piece = 0;
    while (piece < torsions.size() && structure.moves(torsions[piece], link))
        piece++;
    return piece == torsions.size() ? 0 : piece;
}

/**
 * Get whether the links of each closure stay, or move as one piece.
 */
static bool keepsClosures(const LinkStructure& structure, const vector<int>& torsions)
{
    for (auto& links : structure.getClosures())
        if (findPiece(structure, torsions, links.first) != findPiece(structure, torsions, links.second))
            return false;
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
 */
bool ClosedWindows::addWindow(const LinkStructure& structure, const vector<int>& row, size_t size, bool endsAreFree)
{
    if (row.size() < size)
        return false;
    Window window;
    window.torsions.assign(row.end() - size, row.end());
    if (!keepsClosures(structure, window.torsions))
        return false;
    window.axes = findWindowAxes(structure, window.torsions, window.particles);
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
    vector<vector<int>> rows(numTorsions);
    for (const vector<int>& row : findTorsionWindows(structure, torsions, LARGEST_SIZE))
        if (row.size() > rows[row.back()].size())
            rows[row.back()] = row;
    for (const vector<int>& row : rows)
        addWindow(structure, row, 8, true);
    vector<bool> isTurned(numTorsions, false);
    for (const Window& window : windows)
        for (int torsion : window.torsions)
            isTurned[torsion] = true;
    auto isLeftOut = [&](int torsion) {
        return !isTurned[torsion];
    };
    for (const vector<int>& row : rows)
        if (any_of(row.begin(), row.end(), isLeftOut))
            addWindow(structure, row, 9, true) || addWindow(structure, row, 8, false) ||
                addWindow(structure, row, 9, false) || addWindow(structure, row, 7, false);
}
