/**
 * This tests what the kernel keeps and takes back: a kernel that has been changed and taken back has the bits of one to
 * which nothing has happened, in all that can be asked.
 */

#include "NativeEnergySupport.h"
#include "openmm/PeriodicTorsionForce.h"
#include <cstring>
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef CalcStericExclusionForceKernel EnergyKernel;

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
        getKernel().raiseLimits();
        getKernel().updateEnergy(true);
    }
    /**
     * Run trials and write down all that they say.
     */
    vector<double> run(int seed, int numTrials)
    {
        OddNumbers chance(seed);
        vector<double> said;
        EnergyKernel& kernel = getKernel();
        for (int i = 0; i < numTrials; i++) {
            if (chance.below(3) == 0)
                kernel.proposeRigidMotion(1 + chance.below(3), Vec3(chance.between(-0.5, 0.5), 0.1, 0.2),
                                          Vec3(0.1, chance.between(-0.2, 0.2), 0));
            else
                kernel.proposeTorsions({chance.below(chain.force->getNumTorsions())}, {chance.between(-1, 1)});
            said.push_back(kernel.isProposalFree());
            for (int part = 0; part < 3; part++)
                said.push_back(kernel.getProposedEnergyChange((EnergyKernel::EnergyPart)part));
            append(said, kernel.followProposal());
            if (i % 3 == 1)
                kernel.rejectProposal();
            else
                kernel.acceptProposal();
        }
        return said;
    }
    /**
     * Get all that can be asked about the state.
     */
    vector<double> ask()
    {
        EnergyKernel& kernel = getKernel();
        vector<double> said;
        kernel.getState(said);
        double pairs;
        vector<double> pairSets, termSets, limits, overlaps, distances;
        ASSERT(!kernel.updateEnergy(false));
        kernel.getEnergies(pairs, pairSets, termSets);
        said.push_back(pairs);
        said.insert(said.end(), termSets.begin(), termSets.end());
        vector<pair<int, int>> limited, clashing, near;
        kernel.getLimits(limited, limits);
        kernel.getClashes(clashing, overlaps);
        kernel.getNeighborPairs(2.5, near, distances);
        for (auto& found : {limited, clashing, near})
            for (auto& each : found)
                said.insert(said.end(), {(double)each.first, (double)each.second});
        for (auto& found : {limits, overlaps, distances})
            said.insert(said.end(), found.begin(), found.end());
        vector<Vec3> positions, forces(chain.system.getNumParticles());
        kernel.getPositions(positions);
        append(said, positions);
        said.push_back(kernel.computeEnergy(forces));
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
 * Change something and take it back, in one of two scenes that are alike.
 */
static void testTakenBack(const function<void(KeptScene&)>& change)
{
    KeptScene scene, twin;
    for (KeptScene* each : {&scene, &twin})
        each->run(1, 30);
    assertSame(twin.ask(), scene.ask());
    for (int block = 0; block < 3; block++) {
        scene.getKernel().keepState();
        for (int i = 0; i < 2; i++) {
            change(scene);
            scene.getKernel().takeBackState();
            ASSERT(!scene.getKernel().hasProposal());
            assertSame(twin.ask(), scene.ask());
        }
        assertSame(twin.run(50 + block, 20), scene.run(50 + block, 20));
        assertSame(twin.ask(), scene.ask());
    }
}

static void testChanges()
{
    testTakenBack([](KeptScene& scene) {
        scene.run(7, 25);
    });
    testTakenBack([](KeptScene& scene) { // with a trial left open
        scene.run(8, 9);
        scene.getKernel().proposeTorsions({2}, {0.5});
        ASSERT(scene.getKernel().getProposedEnergyChange(EnergyKernel::BondedPart) != 0);
    });
    testTakenBack([](KeptScene& scene) { // other limits
        scene.run(9, 40);
        const int former = scene.getKernel().getNumLimits();
        ASSERT(former > 0);
        scene.getKernel().raiseLimits();
        ASSERT(scene.getKernel().getNumLimits() > former);
    });
    testTakenBack([](KeptScene& scene) { // none
        scene.getKernel().clearLimits();
        scene.run(10, 9);
    });
    testTakenBack([](KeptScene& scene) { // a recomputed energy, and an old one
        scene.run(11, 9);
        ASSERT(scene.getKernel().updateEnergy(true));
        scene.getKernel().proposeTorsions({2}, {0.5});
        scene.getKernel().acceptProposal();
    });
}

static void testNothingToTakeBack()
{
    // What was kept is of the energy and the scene there were.

    KeptScene scene;
    EnergyKernel& kernel = scene.getKernel();
    auto assertNothing = [&] {
        assertThrows("no state was kept", [&] {
            kernel.takeBackState();
        });
    };
    assertNothing();
    kernel.keepState();
    kernel.takeBackState();
    kernel.setEnergyTerms(scene.plan->getTerms());
    assertNothing();
    kernel.keepState();
    vector<double> state;
    kernel.getState(state);
    kernel.setState(state);
    assertNothing();

    // An energy that was made since belongs to nothing that was kept.

    kernel.keepState();
    kernel.updateEnergy(false);
    scene.run(3, 5);
    kernel.takeBackState();
    ASSERT(kernel.updateEnergy(false));
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testChanges();
        testNothingToTakeBack();
    });
}
