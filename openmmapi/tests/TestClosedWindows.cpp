/**
 * This tests which windows closed moves find, and what they refuse.
 */

#include "openmmchaintree/internal/ClosedWindows.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Bonded particles, with a torsion about each bond that one is asked for.
 */
class Molecule {
public:
    /**
     * Add a particle that is bonded to another, unless that is -1. Returns it.
     */
    int add(int neighbor)
    {
        const int particle = system.addParticle(1);
        force.addParticle(0);
        neighbors.push_back({});
        if (neighbor != -1) {
            force.addBond(neighbor, particle);
            neighbors[neighbor].push_back(particle);
            neighbors[particle].push_back(neighbor);
        }
        return particle;
    }
    /**
     * Add particles in a row, the first bonded to a particle unless that is -1. Returns the last.
     */
    int addRow(int neighbor, int count)
    {
        for (int i = 0; i < count; i++)
            neighbor = add(neighbor);
        return neighbor;
    }
    /**
     * Add a torsion about a bond. Returns its index.
     */
    int turn(int particle1, int particle2)
    {
        auto findOther = [&](int particle, int not1, int not2) {
            for (int other : neighbors[particle])
                if (other != not1 && other != not2)
                    return other;
            throw OpenMMException("no neighbor");
        };
        const int p1 = findOther(particle1, particle2, -1);
        return force.addTorsion(p1, particle1, particle2, findOther(particle2, particle1, p1));
    }
    ClosedWindows find(const vector<int>& torsions = vector<int>()) const
    {
        LinkStructure structure(system, force);
        return ClosedWindows(structure, findWindowTorsions(structure, torsions, "test"));
    }
    System system;
    StericExclusionForce force;

private:
    vector<vector<int>> neighbors;
};

/**
 * List the rows of torsions of all windows.
 */
static set<vector<int>> listRows(const ClosedWindows& windows)
{
    set<vector<int>> rows;
    for (auto& window : windows.getWindows())
        ASSERT(rows.insert(window.torsions).second);
    return rows;
}

static vector<int> count(int first, int last)
{
    vector<int> numbers;
    for (int i = first; first <= last ? i <= last : i >= last; i += (first <= last ? 1 : -1))
        numbers.push_back(i);
    return numbers;
}

/**
 * Check that windows say of their torsions what the structure says.
 */
static void assertConsistent(const Molecule& molecule, const ClosedWindows& windows)
{
    LinkStructure structure(molecule.system, molecule.force);
    for (auto& window : windows.getWindows()) {
        const int size = window.torsions.size();
        ASSERT(size >= 7 && size <= 9);
        for (int i = 0; i < size; i++) {
            auto p = structure.getTorsionParticles(window.torsions[i]);
            ASSERT_EQUAL(p[1], window.particles[window.axes[i].first]);
            ASSERT_EQUAL(p[2], window.particles[window.axes[i].second]);
        }
        ASSERT_EQUAL(window.particles.size(), set<int>(window.particles.begin(), window.particles.end()).size());
        set<ClosedWindows::Pivots> different;
        ASSERT(!windows.getChoices(window).empty());
        for (auto& pivots : windows.getChoices(window)) {
            ASSERT(different.insert(pivots).second);
            ASSERT(pivots[0] >= 0 && pivots[5] < size);
            for (int i = 1; i < 6; i++)
                ASSERT(pivots[i] > pivots[i - 1]);
            for (int i = 0; i < 6; i += 2) {
                ASSERT_EQUAL(pivots[i] + 1, pivots[i + 1]);
                ASSERT_EQUAL(window.axes[pivots[i]].second, window.axes[pivots[i + 1]].first);
            }
        }
    }
}

static void testBeads()
{
    // Fourteen beads in a row have eleven torsions. All neighbours share a bead.

    Molecule chain;
    chain.addRow(-1, 14);
    for (int i = 1; i < 12; i++)
        chain.turn(i, i + 1);
    ClosedWindows windows = chain.find();
    ASSERT(listRows(windows) == (set<vector<int>>{count(0, 7), count(1, 8), count(2, 9), count(3, 10)}));
    for (auto& window : windows.getWindows())
        ASSERT(windows.getChoices(window) == vector<ClosedWindows::Pivots>({{1, 2, 3, 4, 5, 6}}));
    assertConsistent(chain, windows);

    // Held at its other end, or in the middle, windows lead away from there.

    chain.system.setParticleMass(13, 0);
    windows = chain.find();
    ASSERT(listRows(windows) == (set<vector<int>>{count(10, 3), count(9, 2), count(8, 1), count(7, 0)}));
    assertConsistent(chain, windows);
    chain.system.setParticleMass(13, 1);
    chain.system.setParticleMass(4, 0);
    windows = chain.find();
    ASSERT(listRows(windows) == (set<vector<int>>{count(3, 10)}));
    assertConsistent(chain, windows);

    // Where eight are not to be had seven do, with any pivots: C(4, 3) choices. Six torsions have no driver.

    Molecule sevenTorsions;
    sevenTorsions.addRow(-1, 10);
    for (int i = 1; i < 8; i++)
        sevenTorsions.turn(i, i + 1);
    windows = sevenTorsions.find();
    ASSERT(listRows(windows) == (set<vector<int>>{count(0, 6)}));
    ASSERT_EQUAL(4, windows.getChoices(windows.getWindows()[0]).size());
    assertConsistent(sevenTorsions, windows);

    Molecule shortChain;
    shortChain.addRow(-1, 9);
    for (int i = 1; i < 7; i++)
        shortChain.turn(i, i + 1);
    ASSERT_EQUAL(0, shortChain.find().getWindows().size());
}

/**
 * Backbones of n, alpha, c in a row with side chains of a number of particles each, and phi and psi as torsions.
 */
class Backbone : public Molecule {
public:
    /**
     * @param sides      the length of the side chain of each residue; all its bonds turn
     * @param isProline  of each residue whether phi does not turn
     */
    Backbone(const vector<int>& sides, const vector<bool>& isProline)
    {
        const int numResidues = sides.size();
        int last = -1;
        vector<int> alphas;
        for (int i = 0; i < numResidues; i++) {
            alphas.push_back(addRow(last, 2));
            last = add(alphas.back());
        }
        add(last);
        vector<int> firstOfSide(numResidues, -1);
        for (int i = 0; i < numResidues; i++)
            for (int j = 0, end = alphas[i]; j < sides[i]; j++) {
                end = add(end);
                if (j == 0)
                    firstOfSide[i] = end;
            }
        for (int i = 0; i < numResidues; i++) {
            phi.push_back(i > 0 && !isProline[i] ? turn(alphas[i] - 1, alphas[i]) : -1);
            psi.push_back(turn(alphas[i], alphas[i] + 1));
            chi.push_back({});
            for (int j = 0; j < sides[i] - 1; j++)
                chi[i].push_back(j == 0 ? turn(alphas[i], firstOfSide[i])
                                        : turn(firstOfSide[i] + j - 1, firstOfSide[i] + j));
        }
    }
    vector<int> phi, psi;
    vector<vector<int>> chi;
};

static void testSideChains()
{
    // Side chains ride along. Windows begin with a psi and end with a phi, between which three residues close them.

    Backbone chain({0, 3, 3, 3, 3, 3, 3, 3}, vector<bool>(8, false));
    ClosedWindows windows = chain.find();
    assertConsistent(chain, windows);
    const vector<int>&phi = chain.phi, &psi = chain.psi;
    set<vector<int>> rows = listRows(windows);
    ASSERT(rows.count({psi[0], phi[1], psi[1], phi[2], psi[2], phi[3], psi[3], phi[4]}));
    ASSERT(rows.count({psi[3], phi[4], psi[4], phi[5], psi[5], phi[6], psi[6], phi[7]}));
    for (auto& window : windows.getWindows())
        if (window.torsions.size() == 8)
            ASSERT(windows.getChoices(window) == vector<ClosedWindows::Pivots>({{1, 2, 3, 4, 5, 6}}));

    // All torsions of a given list follow each other, whichever branch is heaviest.

    vector<int> backbone;
    for (int i = 0; i < 8; i++)
        for (int torsion : {phi[i], psi[i]})
            if (torsion != -1)
                backbone.push_back(torsion);
    rows = listRows(chain.find(backbone));
    ASSERT_EQUAL(5, rows.size()); // one of nine torsions, for the last psi
    ASSERT(rows.count(vector<int>(backbone.end() - 9, backbone.end())));
    vector<int> withSide = backbone;
    withSide.push_back(chain.chi[5][0]);
    rows = listRows(chain.find(withSide));
    ASSERT_EQUAL(6, rows.size());
    vector<int> expected(backbone.begin() + 2, backbone.begin() + 10);
    expected.push_back(chain.chi[5][0]);
    ASSERT(rows.count(expected));

    // What is not given does not count.

    vector<int> gap = backbone;
    gap.erase(find(gap.begin(), gap.end(), phi[4]));
    rows = listRows(chain.find(gap));
    ASSERT(rows.count({psi[0], phi[1], psi[1], phi[2], psi[2], phi[3], psi[3], psi[4]}));
    ASSERT(rows.count({psi[1], phi[2], psi[2], phi[3], psi[3], psi[4], phi[5], psi[5], phi[6]}));
    assertConsistent(chain, chain.find(gap));
}

static void testProlines()
{
    // A residue whose phi does not turn is no pivot, and a window may take one torsion more for it.

    vector<bool> isProline(8, false);
    isProline[2] = isProline[4] = true;
    Backbone chain(vector<int>(8, 0), isProline);
    const vector<int>&phi = chain.phi, &psi = chain.psi;
    ClosedWindows windows = chain.find();
    assertConsistent(chain, windows);
    set<vector<int>> rows = listRows(windows);
    ASSERT(rows.count({phi[1], psi[1], psi[2], phi[3], psi[3], psi[4], phi[5], psi[5]}));
    ASSERT(!rows.count({psi[1], psi[2], phi[3], psi[3], psi[4], phi[5], psi[5], phi[6]}));
    ASSERT(rows.count({phi[1], psi[1], psi[2], phi[3], psi[3], psi[4], phi[5], psi[5], phi[6]}));
    for (auto& window : windows.getWindows())
        if (window.torsions[0] == phi[1] && window.torsions.size() == 8)
            ASSERT(windows.getChoices(window) == vector<ClosedWindows::Pivots>({{0, 1, 3, 4, 6, 7}}));
}

static void testErrors(Platform& platform)
{
    auto assertRefused = [&](const string& message, const System& system, const vector<int>& torsions) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addClosedMove(1, 0.1, torsions);
        assertThrows("TorsionMonteCarloIntegrator: move 0 " + message, [&] {
            Context context(system, integrator, platform);
        });
    };
    BeadChain chain(12, 0), shorter(9, 0), rigid(3, 0);
    assertRefused("turns torsions, but the StericExclusionForce has none", rigid.system, {});
    assertRefused("turns windows of eight torsions in a row, but its torsions have none", shorter.system, {});
    assertRefused("turns windows of eight torsions in a row, but its torsions have none", chain.system,
                  {0, 1, 3, 4, 6, 8});
    assertRefused("names torsion 9, but there are 9 torsions", chain.system, {0, 9});
    assertRefused("names torsion 2 twice", chain.system, {2, 1, 2});
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addClosedMove(1, 0.1, {}, 1);
    integrator.addClosedMove(1, 0.1, {}, 0);
    for (double bad : {-0.1, 1.1, nan("")}) {
        assertThrows("the share of hops of a closed move must be from 0 to 1", [&] {
            integrator.addClosedMove(1, 0.1, {}, bad);
        });
        assertThrows("the share of hops of a closed move must be from 0 to 1", [&] {
            integrator.setClosedMoveParameters(0, 1, 0.1, {}, bad);
        });
    }
    assertThrows("the largest angle of a closed move must be at most pi", [&] {
        integrator.addClosedMove(1, 20);
    });
    assertThrows("the weight of a move must be", [&] {
        integrator.addClosedMove(-1, 0.1);
    });
    ASSERT_EQUAL(2, integrator.getNumMoves());
    integrator.addTorsionMove(1, 0.1);
    double weight, angle, hop;
    vector<int> torsions;
    assertThrows("move 2 is not a closed move", [&] {
        integrator.getClosedMoveParameters(2, weight, angle, torsions, hop);
    });
    assertThrows("move 2 is not a closed move", [&] {
        integrator.setClosedMoveParameters(2, 1, 0.1);
    });
    assertThrows("move 0 is not a torsion move", [&] {
        integrator.setTorsionMoveParameters(0, 1, 0.1);
    });
    integrator.setClosedMoveParameters(1, 0.5, 0.3, {4, 5}, 0.7);
    integrator.getClosedMoveParameters(1, weight, angle, torsions, hop);
    ASSERT_EQUAL(0.5, weight);
    ASSERT_EQUAL(0.3, angle);
    ASSERT(torsions == vector<int>({4, 5}));
    ASSERT_EQUAL(0.7, hop);
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::ClosedMove, integrator.getMoveType(1));
    ASSERT_EQUAL("closed ±0.3 rad (weight 0.5, 2 torsions to choose from)", integrator.getMoveDescription(1));
}

/**
 * In a ring windows lead over the closure, and over the link on which the ring hangs.
 */
static void testRings()
{
    // Fourteen beads in a ring. The torsions beside the closure share no bead: they are in no pair of pivots.

    Molecule ring;
    ring.addRow(-1, 14);
    for (int i = 1; i < 12; i++)
        ring.turn(i, i + 1);
    ring.force.addClosure(12, 13, 0, 1);
    LinkStructure structure(ring.system, ring.force);
    set<vector<int>> expected;
    for (int first : {0, 1, 2, 3, 4, 6, 8, 10}) {
        vector<int> row;
        for (int i = 0; i < 8; i++)
            row.push_back((first + i) % 11);
        expected.insert(row);
    }
    ClosedWindows windows(structure, count(0, 10));
    ASSERT(listRows(windows) == expected);
    assertConsistent(ring, windows);

    // Held in the middle, the ring hangs on two branches. Windows lead up the one and down the other, those of one
    // branch down it.

    ring.system.setParticleMass(7, 0);
    LinkStructure held(ring.system, ring.force);
    ClosedWindows both(held, count(0, 10));
    ASSERT(listRows(both) == expected);
    for (auto& window : both.getWindows())
        for (size_t i = 1; i < window.torsions.size(); i++) {
            const int step = window.torsions[i] - window.torsions[i - 1];
            ASSERT(step == 1 || step == -10);

            // Axes are those of beads in a row, in the direction of the ring.

            ASSERT_EQUAL(window.particles[window.axes[i].first] + 1, window.particles[window.axes[i].second]);
        }

    // What is held at both ends of a loop is one part.

    Molecule loop;
    loop.addRow(-1, 11);
    for (int i = 1; i < 9; i++)
        loop.turn(i, i + 1);
    const int other = loop.add(-1);
    loop.addRow(other, 1);
    for (int particle : {0, 1, other, other + 1})
        loop.system.setParticleMass(particle, 0);
    loop.force.addClosure(9, 10, other, other + 1);
    LinkStructure between(loop.system, loop.force);
    ASSERT_EQUAL(5, ClosedWindows(between, count(0, 7)).getWindows().size());
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testBeads();
        testRings();
        testSideChains();
        testProlines();
        testErrors(platform);
    });
}
