#include "openmmchaintree/internal/TorsionWindows.h"
#include "openmmchaintree/internal/JointChoices.h"
#include <algorithm>
#include <array>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** The least number of torsions of a branch that is a backbone. */
static const int LEAST_BRANCH = 8;

/**
 * Get all links, each after its parent.
 */
static vector<int> sortRootFirst(const LinkStructure& structure)
{
    const auto& links = structure.getLinks();
    vector<vector<int>> children(links.size());
    for (int link = 0; link < (int)links.size(); link++)
        if (links[link].parent != -1)
            children[links[link].parent].push_back(link);
    vector<int> sorted;
    for (auto& molecule : structure.getMolecules())
        sorted.push_back(molecule.root);
    for (size_t i = 0; i < sorted.size(); i++)
        sorted.insert(sorted.end(), children[sorted[i]].begin(), children[sorted[i]].end());
    return sorted;
}

vector<int> ChainTreePlugin::findBackboneTorsions(const LinkStructure& structure)
{
    const auto& links = structure.getLinks();
    const int numLinks = links.size();
    const vector<int> sorted = sortRootFirst(structure);

    // From the ends of branches: the particles that each link carries, itself included, and the next link of its
    // backbone.

    vector<int> carried(numLinks, 0), length(numLinks, 0), next(numLinks, -1);
    for (int link : structure.getParticleLinks())
        carried[link]++;
    for (int i = numLinks - 1; i >= 0; i--) {
        const int link = sorted[i], parent = links[link].parent;
        if (next[link] != -1)
            length[link] = length[next[link]] + 1;
        if (parent == -1)
            continue;
        carried[parent] += carried[link];
        if (next[parent] == -1 || carried[link] > carried[next[parent]])
            next[parent] = link;
    }

    // From the roots: links that continue the backbone of their parent, or begin one that is long enough.

    vector<bool> isBackbone(numLinks, false);
    vector<int> torsions;
    for (int link : sorted) {
        const int parent = links[link].parent;
        isBackbone[link] =
            (parent == -1 || (isBackbone[parent] && next[parent] == link) || length[link] + 1 >= LEAST_BRANCH);
        if (isBackbone[link] && links[link].torsion != -1)
            torsions.push_back(links[link].torsion);
    }
    return torsions;
}

vector<int> ChainTreePlugin::findWindowTorsions(const LinkStructure& structure, const vector<int>& torsions,
                                                const string& name, bool keepsClosures)
{
    checkTorsions(structure, torsions, name);
    vector<int> found = torsions.empty() ? findBackboneTorsions(structure) : torsions;
    if (keepsClosures)
        return found;
    for (int torsion : torsions)
        structure.checkNoClosure(structure.getTorsionLinks()[torsion], name);
    auto isInRing = [&](int torsion) {
        return structure.getLinkClosure(structure.getTorsionLinks()[torsion]) != -1;
    };
    found.erase(remove_if(found.begin(), found.end(), isInRing), found.end());
    return found;
}

vector<vector<int>> ChainTreePlugin::findTorsionWindows(const LinkStructure& structure, const vector<int>& pool,
                                                        int size)
{
    // The torsion of the pool that precedes each link.

    const auto& links = structure.getLinks();
    const vector<int>& torsionLinks = structure.getTorsionLinks();
    vector<bool> isInPool(torsionLinks.size(), false), hasNext(torsionLinks.size(), false);
    for (int torsion : pool)
        isInPool[torsion] = true;
    vector<int> before(links.size(), -1);
    for (int link : sortRootFirst(structure)) {
        const int parent = links[link].parent, torsion = parent == -1 ? -1 : links[parent].torsion;
        if (torsion != -1)
            before[link] = isInPool[torsion] ? torsion : before[parent];
        if (before[link] != -1 && links[link].torsion != -1 && isInPool[links[link].torsion])
            hasNext[before[link]] = true;
    }
    vector<vector<int>> windows;
    for (int torsion : pool) {
        vector<int> window;
        for (int next = torsion; next != -1 && (int)window.size() < size; next = before[torsionLinks[next]])
            window.push_back(next);
        windows.emplace_back(window.rbegin(), window.rend());
    }
    const size_t numLongest = windows.size();
    for (size_t i = 0; i < numLongest; i++)
        if (!hasNext[windows[i].back()])
            for (size_t first = 1; first < windows[i].size(); first++) {
                const vector<int> longest = windows[i];
                windows.emplace_back(longest.begin() + first, longest.end());
            }
    return windows;
}

WindowAxes ChainTreePlugin::findWindowAxes(const LinkStructure& structure, const vector<int>& torsions,
                                           vector<int>& particles)
{
    vector<WindowStep> steps;
    for (int torsion : torsions)
        steps.push_back({torsion, false});
    return findWindowAxes(structure, steps, particles);
}

WindowAxes ChainTreePlugin::findWindowAxes(const LinkStructure& structure, const vector<WindowStep>& steps,
                                           vector<int>& particles)
{
    WindowAxes axes;
    particles.clear();
    for (const WindowStep& step : steps) {
        array<int, 4> row = structure.getTorsionParticles(step.torsion);
        if (step.isRootward)
            reverse(row.begin(), row.end());
        if (particles.empty() || particles.back() != row[1])
            particles.push_back(row[1]);
        particles.push_back(row[2]);
        const int last = particles.size() - 1;
        axes.push_back({last - 1, last});
    }
    return axes;
}

Vec3 ChainTreePlugin::getAxisDirection(const vector<Vec3>& positions, const pair<int, int>& axis)
{
    const Vec3 direction = positions[axis.second] - positions[axis.first];
    return direction / sqrt(direction.dot(direction));
}
