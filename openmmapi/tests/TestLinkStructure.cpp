/**
 * This tests how LinkStructure cuts molecules into links, and what it refuses.
 */

#include "openmm/VirtualSite.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "TestSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Particles of mass 1 and the bonds between them.
 */
class Graph {
public:
    Graph(int numParticles, const vector<pair<int, int>>& bonds)
    {
        for (int i = 0; i < numParticles; i++) {
            system.addParticle(1);
            force.addParticle(0.1);
        }
        for (auto& bond : bonds)
            force.addBond(bond.first, bond.second);
    }
    LinkStructure findLinks() const
    {
        return LinkStructure(system, force);
    }
    void assertRefused(const string& message) const
    {
        assertThrows(message, [this] {
            findLinks();
        });
    }
    System system;
    StericExclusionForce force;
};

void testChain()
{
    // 0-1-2-3-4-5 with torsions about 1-2 and 3-2.

    Graph graph(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
    graph.force.addTorsion(0, 1, 2, 3);
    graph.force.addTorsion(4, 3, 2, 1);
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL_CONTAINERS((vector<int>{0, 0, 1, 2, 2, 2}), structure.getParticleLinks());
    ASSERT_EQUAL_CONTAINERS((vector<int>{1, 2}), structure.getTorsionLinks());
    ASSERT_EQUAL(1, structure.getMolecules().size());
    ASSERT_EQUAL(0, structure.getMolecules()[0].root);
    ASSERT(!structure.getMolecules()[0].fixed);
    ASSERT_EQUAL(-1, structure.getLinks()[0].parent);
    ASSERT_EQUAL(-1, structure.getLinks()[0].torsion);
    ASSERT_EQUAL(0, structure.getLinks()[1].parent);
    ASSERT_EQUAL(0, structure.getLinks()[1].torsion);
    ASSERT_EQUAL(1, structure.getLinks()[2].parent);
    ASSERT_EQUAL(1, structure.getLinks()[2].torsion);
}

void testFixedRoot()
{
    // The same chain, held at its other end: torsions now move the other side.

    Graph graph(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
    graph.force.addTorsion(0, 1, 2, 3);
    graph.force.addTorsion(4, 3, 2, 1);
    graph.system.setParticleMass(4, 0);
    graph.system.setParticleMass(5, 0);
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL(2, structure.getMolecules()[0].root);
    ASSERT(structure.getMolecules()[0].fixed);
    ASSERT_EQUAL_CONTAINERS((vector<int>{0, 1}), structure.getTorsionLinks());
    ASSERT_EQUAL(1, structure.getLinks()[0].parent);
    ASSERT_EQUAL(2, structure.getLinks()[1].parent);
    ASSERT_EQUAL(-1, structure.getLinks()[2].parent);
}

void testMolecules()
{
    // A branched molecule of which the lowest-numbered particle is in the middle, a lone particle, a rigid pair.

    Graph graph(10, {{1, 3}, {3, 4}, {4, 5}, {1, 6}, {6, 7}, {7, 8}, {2, 9}});
    graph.force.addTorsion(5, 4, 3, 1);
    graph.force.addTorsion(3, 1, 6, 7);
    graph.force.addTorsion(1, 6, 7, 8);
    graph.system.setParticleMass(2, 0);
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL(3, structure.getMolecules().size());
    ASSERT_EQUAL_CONTAINERS((vector<int>{0, 1, 2, 1, 3, 3, 4, 5, 5, 2}), structure.getParticleLinks());
    ASSERT_EQUAL_CONTAINERS((vector<int>{3, 4, 5}), structure.getTorsionLinks());
    for (int particle : {1, 3, 4, 5, 6, 7, 8})
        ASSERT_EQUAL(1, structure.getParticleMolecule(particle));
    ASSERT_EQUAL(0, structure.getParticleMolecule(0));
    ASSERT_EQUAL(2, structure.getParticleMolecule(9));
    ASSERT(!structure.getMolecules()[0].fixed);
    ASSERT(!structure.getMolecules()[1].fixed);
    ASSERT(structure.getMolecules()[2].fixed);
}

void testVirtualSites()
{
    // A virtual site goes with the particles that define it, and its mass of 0 does not fix it.

    Graph graph(7, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
    graph.force.addTorsion(0, 1, 2, 3);
    graph.system.setParticleMass(5, 0);
    graph.system.setVirtualSite(5, new TwoParticleAverageSite(3, 4, 0.5, 0.5));
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL_CONTAINERS((vector<int>{0, 0, 1, 1, 1, 1, 2}), structure.getParticleLinks());
    ASSERT(!structure.getMolecules()[0].fixed);

    // One that a torsion would deform is refused.

    graph.system.setParticleMass(6, 0);
    graph.system.setVirtualSite(6, new ThreeParticleAverageSite(0, 1, 3, 0.2, 0.3, 0.5));
    graph.assertRefused("virtual site 6 is defined by particles 0 and 3, which torsion 0 (0-1-2-3) would move relative "
                        "to each other");

    // A particle on the axis keeps its place relative to both sides: the site goes with the others.

    for (int other : {0, 3}) {
        graph.system.setVirtualSite(6, new ThreeParticleAverageSite(1, 2, other, 0.2, 0.3, 0.5));
        ASSERT_EQUAL(graph.findLinks().getParticleLinks()[other], graph.findLinks().getParticleLinks()[6]);
    }
    graph.system.setVirtualSite(6, new TwoParticleAverageSite(1, 2, 0.5, 0.5));
    ASSERT_EQUAL(2, graph.findLinks().getLinks().size());
}

void testJointBetween()
{
    Graph graph(8, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {2, 6}, {6, 7}});
    graph.force.addTorsion(0, 1, 2, 3);
    graph.force.addTorsion(2, 3, 4, 5);
    graph.force.addTorsion(1, 2, 6, 7);
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL(string("torsion 0"), structure.findJointBetween(0, 3));
    ASSERT_EQUAL(string("torsion 0"), structure.findJointBetween(3, 0));
    ASSERT_EQUAL(string("torsion 1"), structure.findJointBetween(5, 2));
    ASSERT_EQUAL(string("torsion 2"), structure.findJointBetween(7, 3));
    ASSERT_EQUAL(string(), structure.findJointBetween(2, 3));

    // Particles on the axis keep their distance to both sides of it.

    ASSERT_EQUAL(string(), structure.findJointBetween(1, 2));
    ASSERT_EQUAL(string(), structure.findJointBetween(1, 3));
    ASSERT_EQUAL(string(), structure.findJointBetween(2, 4));
    ASSERT_EQUAL(string(), structure.findJointBetween(0, 2));
}

void testBallJoints()
{
    // 0-1-2-3-4-5, which may turn about 1 and 4; between, a torsion. Beyond 4, joints move the side without the root.

    Graph graph(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
    graph.force.addBallJoint(4, 5);
    graph.force.addTorsion(1, 2, 3, 4);
    graph.force.addBallJoint(1, 2);
    LinkStructure structure = graph.findLinks();
    ASSERT_EQUAL_CONTAINERS((vector<int>{0, 0, 1, 2, 2, 3}), structure.getParticleLinks());
    ASSERT_EQUAL_CONTAINERS((vector<int>{2}), structure.getTorsionLinks());
    ASSERT_EQUAL_CONTAINERS((vector<int>{3, 1}), structure.getBallJointLinks());
    ASSERT_EQUAL(1, structure.getLinks()[1].ballJoint);
    ASSERT_EQUAL(-1, structure.getLinks()[1].torsion);
    ASSERT_EQUAL(-1, structure.getLinks()[2].ballJoint);
    ASSERT_EQUAL(0, structure.getLinks()[2].torsion);
    ASSERT_EQUAL(0, structure.getLinks()[3].ballJoint);

    // The particle that a joint turns about keeps its distance to both sides, the other one does not.

    ASSERT_EQUAL(string("ball joint 1"), structure.findJointBetween(0, 2));
    ASSERT_EQUAL(string("ball joint 0"), structure.findJointBetween(3, 5));
    ASSERT_EQUAL(string("torsion 0"), structure.findJointBetween(1, 4));
    ASSERT_EQUAL(string(), structure.findJointBetween(1, 2));
    ASSERT_EQUAL(string(), structure.findJointBetween(1, 3));
    ASSERT_EQUAL(string(), structure.findJointBetween(4, 5));

    // With the root at the end the same joints move the other sides.

    graph.system.setParticleMass(5, 0);
    LinkStructure reversed = graph.findLinks();
    ASSERT_EQUAL_CONTAINERS((vector<int>{2, 0}), reversed.getBallJointLinks());
    ASSERT_EQUAL(string("ball joint 1"), reversed.findJointBetween(0, 2));
    ASSERT(structure.describe() != reversed.describe());
}

void testBadBallJoints()
{
    const vector<pair<int, int>> chain = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
    auto assertRefused = [&](const string& message, const vector<pair<int, int>>& ballJoints) {
        Graph graph(5, chain);
        graph.force.addTorsion(0, 1, 2, 3);
        for (auto& joint : ballJoints)
            graph.force.addBallJoint(joint.first, joint.second);
        graph.assertRefused(message);
    };
    assertRefused("ball joint 1 (4-5) names particle 5, but there are 5 particles", {{2, 3}, {4, 5}});
    assertRefused("ball joint 0 (3-3) names a particle twice", {{3, 3}});
    assertRefused("the particles of ball joint 0 (1-3) must be bonded, but there is no bond between particles 1 and 3",
                  {{1, 3}});
    assertRefused("torsion 0 (0-1-2-3) and ball joint 0 (2-1) are about the same bond", {{2, 1}});
    assertRefused("ball joint 0 (3-4) and ball joint 1 (4-3) are about the same bond", {{3, 4}, {4, 3}});

    // A group at one end of a torsion may not turn about its axis, but the whole side may.

    assertRefused("ball joint 0 (1-0) changes the dihedral of torsion 0 (0-1-2-3); name another particle bonded to "
                  "particle 1",
                  {{1, 0}});
    assertRefused("ball joint 1 (2-3) changes the dihedral of torsion 0 (0-1-2-3)", {{3, 4}, {2, 3}});
    Graph sound(5, chain);
    sound.force.addTorsion(0, 1, 2, 3);
    sound.force.addBallJoint(0, 1);
    sound.force.addBallJoint(3, 2);
    sound.findLinks();

    Graph ring(4, {{0, 1}, {1, 2}, {2, 0}, {2, 3}});
    ring.force.addBallJoint(2, 3);
    ring.force.addBallJoint(0, 1);
    ring.assertRefused("ball joint 1 (0-1) lies in a ring: 0-2-1-0");

    Graph fixed(4, {{0, 1}, {1, 2}, {2, 3}});
    fixed.force.addBallJoint(1, 2);
    fixed.system.setParticleMass(0, 0);
    fixed.system.setParticleMass(3, 0);
    fixed.assertRefused("ball joint 0 (1-2) lies between two fixed parts: particles 0 and 3 both have mass 0");
}

void testBadBonds()
{
    Graph(3, {{0, 1}, {1, 3}}).assertRefused("bond 1 names particle 3, but there are 3 particles");
    Graph(3, {{-1, 1}}).assertRefused("bond 0 names particle -1, but there are 3 particles");
    Graph(3, {{0, 1}, {2, 2}}).assertRefused("bond 1 ties particle 2 to itself");
    Graph(3, {{0, 1}, {1, 0}, {0, 1}}).findLinks();
}

void testBadTorsions()
{
    const vector<pair<int, int>> chain = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
    Graph outOfRange(5, chain);
    outOfRange.force.addTorsion(2, 3, 4, 5);
    outOfRange.assertRefused("torsion 0 (2-3-4-5) names particle 5, but there are 5 particles");

    Graph repeated(5, chain);
    repeated.force.addTorsion(0, 1, 2, 1);
    repeated.assertRefused("torsion 0 (0-1-2-1) names a particle twice");

    Graph unbonded(5, chain);
    unbonded.force.addTorsion(0, 1, 2, 3);
    unbonded.force.addTorsion(0, 2, 3, 4);
    unbonded.assertRefused("the particles of torsion 1 (0-2-3-4) must be bonded in a row, but there is no bond between "
                           "particles 0 and 2");

    Graph twice(6, {{0, 1}, {1, 2}, {2, 3}, {2, 4}, {1, 5}});
    twice.force.addTorsion(0, 1, 2, 3);
    twice.force.addTorsion(5, 1, 2, 4);
    twice.assertRefused("torsion 0 (0-1-2-3) and torsion 1 (5-1-2-4) are about the same bond");

    Graph reversed(5, chain);
    reversed.force.addTorsion(0, 1, 2, 3);
    reversed.force.addTorsion(3, 2, 1, 0);
    reversed.assertRefused("torsion 0 (0-1-2-3) and torsion 1 (3-2-1-0) are about the same bond");
}

void testRings()
{
    // A ring of five with two tails. A bond outside may turn, bonds of the ring may not, alone or together.

    const vector<pair<int, int>> bonds = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}, {0, 5}, {5, 6}, {2, 7}, {7, 8}};
    Graph outside(9, bonds);
    outside.force.addTorsion(1, 0, 5, 6);
    outside.force.addTorsion(1, 2, 7, 8);
    ASSERT_EQUAL(3, outside.findLinks().getLinks().size());

    Graph one(9, bonds);
    one.force.addTorsion(1, 0, 5, 6);
    one.force.addTorsion(0, 1, 2, 7);
    one.assertRefused("torsion 1 (0-1-2-7) lies in a ring: 1-0-4-3-2-1");

    Graph two(9, bonds);
    two.force.addTorsion(0, 1, 2, 3);
    two.force.addTorsion(2, 3, 4, 0);
    two.assertRefused("torsion 1 (2-3-4-0) lies in a ring: 3-2-1-0-4-3");

    // A ring of which every bond turns, closed by the last torsion.

    Graph all(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 0}});
    all.force.addTorsion(0, 1, 2, 3);
    all.force.addTorsion(2, 1, 0, 5);
    for (int i = 1; i < 5; i++)
        all.force.addTorsion(i, i + 1, (i + 2) % 6, (i + 3) % 6);
    all.assertRefused("torsion 5 (4-5-0-1) lies in a ring: 5-4-3-2-1-0-5");
}

void testTwoFixedParts()
{
    Graph graph(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
    graph.force.addTorsion(0, 1, 2, 3);
    graph.force.addTorsion(2, 3, 4, 5);
    graph.system.setParticleMass(0, 0);
    graph.system.setParticleMass(5, 0);
    graph.assertRefused("torsion 1 (2-3-4-5) lies between two fixed parts: particles 0 and 5 both have mass 0");
}

void testDescriptions()
{
    // Two torsions in either order, one of them the other way round; an extra bond within a link.

    auto describe = [](const vector<array<int, 4>>& torsions, const vector<pair<int, int>>& extraBonds = {},
                       int fixed = -1) {
        Graph graph(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
        for (auto& bond : extraBonds)
            graph.force.addBond(bond.first, bond.second);
        for (auto& t : torsions)
            graph.force.addTorsion(t[0], t[1], t[2], t[3]);
        if (fixed != -1)
            graph.system.setParticleMass(fixed, 0);
        return graph.findLinks().describe();
    };
    const array<int, 4> first{{0, 1, 2, 3}}, second{{1, 2, 3, 4}}, third{{2, 3, 4, 5}};
    vector<int> description = describe({first, third});
    ASSERT(description == describe({third, first}));
    ASSERT(description == describe({{{3, 2, 1, 0}}, third}));
    ASSERT(description == describe({first, third}, {{0, 1}}));
    ASSERT(description != describe({first}));
    ASSERT(description != describe({first, second}));
    ASSERT(description != describe({first, second, third}));
    ASSERT(description != describe({first, third}, {}, 0));
    ASSERT(description != describe({first, third}, {}, 5));
    ASSERT(describe({first, third}, {}, 0) == describe({first, third}, {}, 1));

    // A ball joint is described by what turns about which particle.

    auto describeJoint = [](int particle1, int particle2) {
        Graph graph(3, {{0, 1}, {1, 2}});
        graph.force.addBallJoint(particle1, particle2);
        return graph.findLinks().describe();
    };
    ASSERT(describeJoint(0, 1) != describeJoint(1, 0));
    ASSERT(describeJoint(1, 0) != describeJoint(1, 2));
}

int main()
{
    try {
        testChain();
        testFixedRoot();
        testMolecules();
        testVirtualSites();
        testJointBetween();
        testBallJoints();
        testBadBallJoints();
        testBadBonds();
        testBadTorsions();
        testRings();
        testTwoFixedParts();
        testDescriptions();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
