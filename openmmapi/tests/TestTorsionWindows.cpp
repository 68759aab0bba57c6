/**
 * This tests which torsions are backbones, and which of them are windows.
 */

#include "openmmchaintree/internal/TorsionWindows.h"
#include "TestSupport.h"
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef vector<vector<int>> Windows;

/**
 * A chain of particles, bonded in a row, to which branches are added.
 */
class Tree {
public:
    explicit Tree(int length)
    {
        addParticles(length);
        for (int i = 1; i < length; i++)
            force.addBond(i - 1, i);
    }
    /**
     * Add a row of particles that hangs on one, and return the first of them.
     */
    int addBranch(int particle, int length)
    {
        const int first = force.getNumParticles();
        addParticles(length);
        force.addBond(particle, first);
        for (int i = 1; i < length; i++)
            force.addBond(first + i - 1, first + i);
        return first;
    }
    LinkStructure findLinks() const
    {
        return LinkStructure(system, force);
    }
    System system;
    StericExclusionForce force;

private:
    void addParticles(int count)
    {
        for (int i = 0; i < count; i++) {
            system.addParticle(1);
            force.addParticle(0.1);
        }
    }
};

static set<vector<int>> toSet(const Windows& windows)
{
    set<vector<int>> unique(windows.begin(), windows.end());
    ASSERT_EQUAL(windows.size(), unique.size());
    return unique;
}

static void assertWindows(const Windows& expected, const Tree& tree, const vector<int>& pool, int size)
{
    ASSERT(toSet(expected) == toSet(findTorsionWindows(tree.findLinks(), pool, size)));
}

/**
 * A chain with torsions 0 ... 5 in a row, every second given from its end to its start.
 */
static Tree makeChain()
{
    Tree tree(9);
    for (int i = 0; i < 6; i++)
        if (i % 2 == 0)
            tree.force.addTorsion(i, i + 1, i + 2, i + 3);
        else
            tree.force.addTorsion(i + 3, i + 2, i + 1, i);
    return tree;
}

static void testWindowsOfChain()
{
    const Tree tree = makeChain();
    const vector<int> all = {0, 1, 2, 3, 4, 5};
    ASSERT_EQUAL_CONTAINERS(all, findBackboneTorsions(tree.findLinks()));
    const Windows ofThree = {{0}, {0, 1}, {0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 5}, {4, 5}, {5}};
    assertWindows(ofThree, tree, all, 3);
    assertWindows({{0}, {1}, {2}, {3}, {4}, {5}}, tree, all, 1);

    // Whatever the order of the pool is, and if the chain is shorter than the window.

    assertWindows(ofThree, tree, {4, 2, 0, 5, 3, 1}, 3);
    const Windows ofMany = {{1}, {1, 4}, {1, 4, 5}, {4, 5}, {5}};
    assertWindows(ofMany, tree, {5, 1, 4}, 3);
    assertWindows(ofMany, tree, {5, 1, 4}, 8);
}

static void testOtherRoots()
{
    // Held at its end, the chain begins there; in the middle, it has two ends.

    Tree atEnd = makeChain();
    atEnd.system.setParticleMass(8, 0);
    assertWindows({{5}, {5, 4}, {4, 3}, {3, 2}, {2, 1}, {1, 0}, {0}}, atEnd, {0, 1, 2, 3, 4, 5}, 2);
    Tree inside = makeChain();
    inside.system.setParticleMass(4, 0);
    assertWindows({{2}, {2, 1}, {1, 0}, {0}, {3}, {3, 4}, {4, 5}, {5}}, inside, {0, 1, 2, 3, 4, 5}, 2);
}

static void testTorsionParticles()
{
    const LinkStructure forward = makeChain().findLinks();
    Tree tree = makeChain();
    tree.system.setParticleMass(8, 0);
    const LinkStructure backward = tree.findLinks();
    for (int i = 0; i < 6; i++) {
        const array<int, 4> up = {{i, i + 1, i + 2, i + 3}}, down = {{i + 3, i + 2, i + 1, i}};
        ASSERT(forward.getTorsionParticles(i) == up);
        ASSERT(backward.getTorsionParticles(i) == down);
    }
}

static void testSideChains()
{
    // Side chains of two torsions (6, 7) and (8, 9), of which the first carries more than the end of the chain. Windows
    // of the backbone pass by the second.

    Tree tree = makeChain();
    const int first = tree.addBranch(6, 9), second = tree.addBranch(3, 4);
    tree.force.addTorsion(5, 6, first, first + 1);
    tree.force.addTorsion(6, first, first + 1, first + 2);
    tree.force.addTorsion(2, 3, second, second + 1);
    tree.force.addTorsion(3, second, second + 1, second + 2);
    const LinkStructure structure = tree.findLinks();
    const vector<int> backbone = {0, 1, 2, 3, 4, 6, 7};
    ASSERT_EQUAL_CONTAINERS(backbone, findWindowTorsions(structure, {}, "move"));
    assertWindows({{0}, {0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 6}, {6, 7}, {7}}, tree, backbone, 2);

    // What is named is taken: a window may lead into a side chain, and the stem is in windows of both branches.

    ASSERT_EQUAL_CONTAINERS((vector<int>{9, 1}), findWindowTorsions(structure, {9, 1}, "move"));
    assertWindows({{1}, {1, 2}, {1, 8}, {8, 9}, {2}, {9}}, tree, {1, 2, 8, 9}, 2);
}

static void testLongBranches()
{
    // A branch of eight torsions has a backbone of its own, one of seven has none; the chain continues with the
    // heaviest.

    for (int length : {7, 8}) {
        Tree tree(40);
        for (int i = 0; i < 10; i++)
            tree.force.addTorsion(i, i + 1, i + 2, i + 3);
        const int first = tree.addBranch(5, length + 2);
        tree.force.addTorsion(4, 5, first, first + 1);
        tree.force.addTorsion(5, first, first + 1, first + 2);
        for (int i = 2; i < length; i++)
            tree.force.addTorsion(first + i - 2, first + i - 1, first + i, first + i + 1);
        ASSERT_EQUAL(length == 8 ? 18 : 10, findBackboneTorsions(tree.findLinks()).size());
    }
}

static void testBadTorsions()
{
    const LinkStructure structure = makeChain().findLinks();
    assertThrows("move 3 names torsion 6, but there are 6 torsions", [&] {
        findWindowTorsions(structure, {1, 6}, "move 3");
    });
    assertThrows("move 3 names torsion 1 twice", [&] {
        findWindowTorsions(structure, {1, 2, 1}, "move 3");
    });
    assertThrows("move 3 turns torsions, but the StericExclusionForce has none", [&] {
        findWindowTorsions(Tree(3).findLinks(), {}, "move 3");
    });
}

int main()
{
    try {
        testWindowsOfChain();
        testOtherRoots();
        testTorsionParticles();
        testSideChains();
        testLongBranches();
        testBadTorsions();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
