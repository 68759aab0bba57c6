#include "openmmchaintree/internal/ClosedWindows.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace std;

/** How many torsions a window has, in the order in which they are tried: two drivers are best, one can do. */
static const size_t SIZES[] = {8, 9, 7};
static const int LARGEST_SIZE = 9;

/**
 * List the ways to choose three pairs of neighbours.
 *
 * @param joints  a bit for each torsion that shares a particle with the next
 */
static vector<ClosedWindows::Pivots> listChoices(unsigned joints)
{
    vector<ClosedWindows::Pivots> choices;
    for (int i = 0; i < LARGEST_SIZE; i++)
        for (int j = i + 2; j < LARGEST_SIZE; j++)
            for (int k = j + 2; k < LARGEST_SIZE; k++)
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
 * Add a window of these torsions. Returns false if they can't be one.
 */
bool ClosedWindows::addWindow(const LinkStructure& structure, const vector<int>& torsions)
{
    if (!keepsClosures(structure, torsions))
        return false;
    Window window;
    window.torsions = torsions;
    unsigned joints = 0;
    for (size_t i = 0; i < torsions.size(); i++) {
        const array<int, 4> p = structure.getTorsionParticles(torsions[i]);
        if (i > 0 && window.particles.back() == p[1])
            joints |= 1u << (i - 1);
        else
            window.particles.push_back(p[1]);
        window.particles.push_back(p[2]);
        const int last = window.particles.size() - 1;
        window.axes.push_back({last - 1, last});
    }
    auto known = find(choicesOf.begin(), choicesOf.end(), joints);
    window.choices = known - choicesOf.begin();
    if (known == choicesOf.end()) {
        choicesOf.push_back(joints);
        choices.push_back(listChoices(joints));
    }
    if (choices[window.choices].empty())
        return false;
    windows.push_back(window);
    return true;
}

ClosedWindows::ClosedWindows(const LinkStructure& structure, const vector<int>& torsions)
{
    // Of rows that end with the same torsion all but the longest are parts of it.

    vector<vector<int>> rows(structure.getTorsionLinks().size());
    for (const vector<int>& row : findTorsionWindows(structure, torsions, LARGEST_SIZE))
        if (row.size() > rows[row.back()].size())
            rows[row.back()] = row;
    for (const vector<int>& row : rows)
        for (size_t size : SIZES)
            if (size <= row.size() && addWindow(structure, vector<int>(row.end() - size, row.end())))
                break;
}
