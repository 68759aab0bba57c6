#ifndef OPENMM_CHAINTREE_OUTERTESTSUPPORT_H_
#define OPENMM_CHAINTREE_OUTERTESTSUPPORT_H_

/**
 * Common code of the tests of outer tests: a scene with native energies and a foreign one, and a run on it.
 */

#include "CheckpointSupport.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/NonbondedForce.h"
#include "SamplingSupport.h"
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** What getOuterStatistics() says. */
class Tests {
public:
    explicit Tests(const TorsionMonteCarloIntegrator& integrator)
    {
        integrator.getOuterStatistics(attempted, accepted, trialsTakenBack, mean, deviation);
    }
    long long attempted, accepted, trialsTakenBack;
    double mean, deviation;
};

/**
 * A chain that clashes with itself at first, with native energies and a foreign one with a given value.
 */
class OuterScene : public BeadChain {
public:
    OuterScene() : BeadChain(12, 0.75, 0.6), probe(new Probe())
    {
        addMolecule(7, 0.5, 2, Vec3(1, 2, 3));
        NonbondedForce* nonbonded = new NonbondedForce();
        for (int i = 0; i < system.getNumParticles(); i++)
            nonbonded->addParticle(i % 2 == 0 ? 0.2 : -0.2, 0.3, 0.1);
        CustomTorsionForce* torsions = new CustomTorsionForce("2*cos(theta)");
        for (int i = 0; i < 9; i++)
            torsions->addTorsion(i, i + 1, i + 2, i + 3);
        system.addForce(nonbonded);
        system.addForce(torsions);
        system.addForce(probe);
        probe->setForceGroup(1);
        probe->energy = [&](const vector<Vec3>& x) {
            numEvaluations++;
            return say(x);
        };
    }
    Probe* probe;
    function<double(const vector<Vec3>&)> say = [](const vector<Vec3>&) {
        return 0.0;
    };
    int numEvaluations = 0;
};

class OuterRun : public Run {
public:
    OuterRun(OuterScene& scene, Platform& platform, int trialsPerTest, int seed = 3) : Run(scene.system, seed, platform)
    {
        integrator.setTrialsPerOuterTest(trialsPerTest);
        integrator.setStepSize(1);
    }
    long long sumMoves(long long Statistics::*count)
    {
        long long sum = 0;
        for (int i = 0; i < integrator.getNumMoves(); i++)
            sum += Statistics(integrator, i).*count;
        return sum;
    }
};

#endif /*OPENMM_CHAINTREE_OUTERTESTSUPPORT_H_*/
