/**
 * This tests save() and restore() of a Scene: a scene that was changed and restored has the bits of one that was never
 * changed, in every answer.
 */

#include "NativeEnergySupport.h"
#include "openmm/PeriodicTorsionForce.h"
#include <cstring>
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Spheres with clashes, and energies of all kinds of parts.
 */
class KeptScene : public NativeScene {
public:
    KeptScene()
    {
        for (int i = 0; i < NUM_BEADS; i++)
            chain.force->setParticleParameters(i, 0.7);
        chain.addMolecule(12, 0.4, 1.7, Vec3(-1.5, 0.5, 0.5));
        chain.addMolecule(1, 0.3, 0, Vec3(2, 2, 2));
        NonbondedForce* nonbonded = new NonbondedForce();
        nonbonded->setNonbondedMethod(NonbondedForce::CutoffNonPeriodic);
        nonbonded->setCutoffDistance(2.2);
        PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
        for (int i = 0; i < chain.system.getNumParticles(); i++)
            nonbonded->addParticle(i % 2 == 0 ? 0.4 : -0.4, 0.5, 0.3);
        for (int i = 0; i + 3 < 9; i++)
            torsions->addTorsion(i, i + 1, i + 2, i + 3, 2, 0.3, 4);
        add(nonbonded);
        add(torsions);
        build();
        getScene().raiseLimits();
        getEnergy().update(true);
    }
    /**
     * Run trials and write down all that they say.
     */
    vector<double> run(int seed, int numTrials)
    {
        OddNumbers chance(seed);
        vector<double> said;
        Scene& scene = getScene();
        for (int i = 0; i < numTrials; i++) {
            if (chance.below(3) == 0)
                scene.propose(Proposal().addRigidMotion(1 + chance.below(3), Vec3(chance.between(-0.5, 0.5), 0.1, 0.2),
                                                        Vec3(0.1, chance.between(-0.2, 0.2), 0)));
            else
                scene.propose(
                    Proposal().addTorsion(chance.below(chain.force->getNumTorsions()), chance.between(-1, 1)));
            said.push_back(scene.test());
            for (int part = 0; part < 3; part++)
                said.push_back(getEnergy().computeEnergyChange((ctEnergyPart)part));
            append(said, scene.followTrial());
            if (i % 3 == 1)
                scene.reject();
            else
                scene.accept();
        }
        return said;
    }
    /**
     * Get all that can be asked about the state.
     */
    vector<double> ask()
    {
        Scene& scene = getScene();
        vector<double> said;
        scene.getState(said);
        double pairs;
        vector<double> pairSets, termSets, limits, overlaps, distances;
        ASSERT(!getEnergy().update(false));
        getEnergy().getEnergies(pairs, pairSets, termSets);
        said.push_back(pairs);
        said.insert(said.end(), termSets.begin(), termSets.end());
        vector<pair<int, int>> limited, clashing, near;
        scene.getLimits(limited, limits);
        scene.getClashes(clashing, overlaps);
        scene.getNeighborPairs(2.5, near, distances);
        for (auto& found : {limited, clashing, near})
            for (auto& each : found)
                said.insert(said.end(), {(double)each.first, (double)each.second});
        for (auto& found : {limits, overlaps, distances})
            said.insert(said.end(), found.begin(), found.end());
        vector<Vec3> positions, forces(chain.system.getNumParticles());
        scene.getPositions(positions);
        append(said, positions);
        said.push_back(scene.computeEnergy(forces));
        append(said, forces);
        return said;
    }

private:
    static void append(vector<double>& said, const vector<Vec3>& vectors)
    {
        for (const Vec3& each : vectors)
            said.insert(said.end(), {each[0], each[1], each[2]});
    }
};

static void assertSame(const vector<double>& expected, const vector<double>& found)
{
    ASSERT_EQUAL(expected.size(), found.size());
    ASSERT(memcmp(expected.data(), found.data(), expected.size() * sizeof(double)) == 0);
}

/**
 * Change something and restore the state, in one of two equal scenes.
 */
static void testRestored(const function<void(KeptScene&)>& change)
{
    KeptScene scene, twin;
    for (KeptScene* each : {&scene, &twin})
        each->run(1, 30);
    assertSame(twin.ask(), scene.ask());
    for (int block = 0; block < 3; block++) {
        scene.getScene().save();
        for (int i = 0; i < 2; i++) {
            change(scene);
            scene.getScene().restore();
            ASSERT(!scene.getScene().hasTrial());
            assertSame(twin.ask(), scene.ask());
        }
        assertSame(twin.run(50 + block, 20), scene.run(50 + block, 20));
        assertSame(twin.ask(), scene.ask());
    }
}

static void testChanges()
{
    testRestored([](KeptScene& scene) {
        scene.run(7, 25);
    });
    testRestored([](KeptScene& scene) { // with a trial left open
        scene.run(8, 9);
        scene.getScene().propose(Proposal().addTorsion(2, 0.5));
        ASSERT(scene.getEnergy().computeEnergyChange(ctTermsPart) != 0);
    });
    testRestored([](KeptScene& scene) { // other limits
        scene.run(9, 40);
        const int former = scene.getScene().getNumLimits();
        ASSERT(former > 0);
        scene.getScene().raiseLimits();
        ASSERT(scene.getScene().getNumLimits() > former);
    });
    testRestored([](KeptScene& scene) { // none
        scene.getScene().clearLimits();
        scene.run(10, 9);
    });
    testRestored([](KeptScene& scene) { // a recomputed energy, and an old one
        scene.run(11, 9);
        ASSERT(scene.getEnergy().update(true));
        scene.getScene().propose(Proposal().addTorsion(2, 0.5));
        scene.getScene().accept();
    });
}

static void testNothingToRestore()
{
    // What was saved belongs to the former energy and tree.

    KeptScene kept;
    Scene& scene = kept.getScene();
    auto assertNothing = [&] {
        assertThrows("no state was saved", [&] {
            scene.restore();
        });
    };
    assertNothing();
    scene.save();
    scene.restore();
    scene.getEnergy().setTerms(kept.plan->getTerms());
    assertNothing();
    scene.save();
    vector<double> state;
    scene.getState(state);
    scene.setState(state);
    assertNothing();

    // An energy that was made after save() was not saved.

    scene.save();
    scene.getEnergy().update(false);
    kept.run(3, 5);
    scene.restore();
    ASSERT(scene.getEnergy().update(false));
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testChanges();
        testNothingToRestore();
    });
}
