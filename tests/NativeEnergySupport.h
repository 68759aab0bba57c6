#ifndef OPENMM_CHAINTREE_NATIVEENERGYSUPPORT_H_
#define OPENMM_CHAINTREE_NATIVEENERGYSUPPORT_H_

/**
 * Common code of the tests of native energies: a System that takes Forces, and its energies by a Scene and by OpenMM.
 */

#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Scene.h"
#include "TestSupport.h"
#include <memory>
#include <random>

namespace ChainTreePlugin {

/**
 * Names what Forces know of Contexts.
 */
class ContextOpener : public OpenMM::Force {
public:
    OpenMM::ContextImpl& open(OpenMM::Context& context)
    {
        return getContextImpl(context);
    }

protected:
    OpenMM::ForceImpl* createImpl() const
    {
        return NULL;
    }
};

/**
 * Numbers for parameters that nobody would choose.
 */
class OddNumbers {
public:
    explicit OddNumbers(int seed) : engine(seed)
    {
    }
    double between(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(engine);
    }
    int below(int end)
    {
        return std::uniform_int_distribution<int>(0, end - 1)(engine);
    }
    /** Different particles. */
    std::vector<int> particles(int count, int end)
    {
        std::vector<int> all(end);
        for (int i = 0; i < end; i++)
            all[i] = i;
        std::shuffle(all.begin(), all.end(), engine);
        all.resize(count);
        return all;
    }

private:
    std::mt19937 engine;
};

/**
 * Two chains of beads, one without radii and one with tiny ones, in a Context with the Forces of a test. Forces are in
 * the System from index 1 on, in separate force groups unless the test sets a group other than 0.
 */
class NativeScene {
public:
    static const int NUM_BEADS = 15;
    NativeScene() : chain(9, 0, 2.1), numbers(17)
    {
        chain.addMolecule(6, 0.001, -1.3, OpenMM::Vec3(0.6, 1.7, 1.9));
        for (OpenMM::Vec3& position : chain.positions)
            position +=
                OpenMM::Vec3(numbers.between(-0.1, 0.1), numbers.between(-0.1, 0.1), numbers.between(-0.1, 0.1));
    }
    /**
     * Add a Force, which belongs to the System from then on. Returns its index.
     */
    int add(OpenMM::Force* force)
    {
        const int index = chain.system.addForce(force);
        if (force->getForceGroup() == 0)
            force->setForceGroup(index % 32);
        return index;
    }
    /**
     * Make the Context and the plan.
     */
    void makePlan()
    {
        integrator.reset(new OpenMM::VerletIntegrator(0.001));
        context.reset(new OpenMM::Context(chain.system, *integrator, OpenMM::Platform::getPlatform("Reference")));
        context->setPositions(chain.positions);
        plan.reset(new EnergyPlan(getImpl()));
        plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
    }
    /**
     * Make the Context, the plan and the scene.
     */
    void build()
    {
        makePlan();
        scene = createScene();
        scene->getEnergy().setTerms(plan->getTerms());
        scene->setPositions(chain.positions);
    }
    /**
     * Make a scene that has no state yet.
     */
    std::unique_ptr<Scene> createScene()
    {
        return std::unique_ptr<Scene>(new Scene(*chain.force, LinkStructure(chain.system, *chain.force)));
    }
    OpenMM::ContextImpl& getImpl()
    {
        return ContextOpener().open(*context);
    }
    Scene& getScene()
    {
        return *scene;
    }
    SceneEnergy& getEnergy()
    {
        return scene->getEnergy();
    }
    /**
     * Get the energy of each Force as the scene has it.
     */
    std::vector<double> computeEnergies(bool force = false)
    {
        getEnergy().update(force);
        return plan->computeByForce(getEnergy());
    }
    /**
     * Get OpenMM's energy of force groups at the scene's positions.
     */
    double computeOpenMMEnergy(int groups)
    {
        std::vector<OpenMM::Vec3> positions;
        scene->getPositions(positions);
        context->setPositions(positions);
        return context->getState(OpenMM::State::Energy, false, groups).getPotentialEnergy();
    }
    /**
     * Compare the energy of a Force, which has to be native, with OpenMM's: recomputed, and as random
     * trials change it.
     */
    void assertAgreement(int index, double tolerance = 1e-7)
    {
        using OpenMM::throwException;
        const EnergyPlan::Entry& entry = plan->getEntries()[index];
        if (entry.kind != EnergyPlan::Native)
            throw OpenMM::OpenMMException("force " + std::to_string(index) + " is not native: " + entry.reason);
        double former = computeOpenMMEnergy(entry.groups);
        assertClose(former, computeEnergies()[index], tolerance);
        for (int trial = 0; trial < 30; trial++) {
            const int torsion = numbers.below(chain.force->getNumTorsions());
            scene->propose(Proposal().addTorsion(torsion, numbers.between(-2, 2)));
            double change = 0;
            for (int part = 0; part < 3; part++)
                change += getEnergy().computeEnergyChange((ctEnergyPart)part);
            if (trial % 3 == 0) {
                scene->reject();
                continue;
            }
            scene->accept();
            const double energy = computeOpenMMEnergy(entry.groups);
            if (chain.system.getNumForces() == 2)
                assertClose(energy - former, change, tolerance * (1 + fabs(former)));
            assertClose(energy, computeEnergies()[index], tolerance);
            former = energy;
        }
    }
    BeadChain chain;
    OddNumbers numbers;
    std::unique_ptr<OpenMM::VerletIntegrator> integrator;
    std::unique_ptr<OpenMM::Context> context;
    std::unique_ptr<EnergyPlan> plan;

private:
    static void assertClose(double expected, double found, double tolerance)
    {
        if (!(fabs(expected - found) <= tolerance * (1 + fabs(expected)))) {
            std::stringstream message;
            message.precision(12);
            message << "expected the energy " << expected << ", found " << found;
            throw OpenMM::OpenMMException(message.str());
        }
    }
    std::unique_ptr<Scene> scene;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_NATIVEENERGYSUPPORT_H_*/
