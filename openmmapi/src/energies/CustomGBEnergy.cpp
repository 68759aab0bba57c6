#include "openmm/CustomGBForce.h"
#include "openmmchaintree/internal/BornReader.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include "openmmchaintree/internal/ValueTranslation.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Not by OpenMM's XML: its numbers share memory among all threads, and steps copy Forces.
 */
static Force* copyCustomGB(const Force& force)
{
    const CustomGBForce& original = dynamic_cast<const CustomGBForce&>(force);
    unique_ptr<CustomGBForce> copy(new CustomGBForce());
    copyGlobals(original, *copy);
    copy->setNonbondedMethod(original.getNonbondedMethod());
    copy->setCutoffDistance(original.getCutoffDistance());
    for (int i = 0; i < original.getNumPerParticleParameters(); i++)
        copy->addPerParticleParameter(original.getPerParticleParameterName(i));
    vector<double> parameters;
    for (int i = 0; i < original.getNumParticles(); i++) {
        original.getParticleParameters(i, parameters);
        copy->addParticle(parameters);
    }
    for (int i = 0; i < original.getNumExclusions(); i++) {
        int particle1, particle2;
        original.getExclusionParticles(i, particle1, particle2);
        copy->addExclusion(particle1, particle2);
    }
    string name, expression;
    CustomGBForce::ComputationType type;
    for (int i = 0; i < original.getNumComputedValues(); i++) {
        original.getComputedValueParameters(i, name, expression, type);
        copy->addComputedValue(name, expression, type);
    }
    for (int i = 0; i < original.getNumEnergyTerms(); i++) {
        original.getEnergyTermParameters(i, expression, type);
        copy->addEnergyTerm(expression, type);
    }
    return copy.release();
}

static string translateCustomGB(const Force& owner, int index, const System&,
                                const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomGBForce& force = dynamic_cast<const CustomGBForce&>(owner);
    if (force.getNonbondedMethod() == CustomGBForce::CutoffPeriodic)
        return "its cutoff is periodic";
    string whyNoBorn = checkBornPartners(terms);
    try {
        if (whyNoBorn.empty()) {
            terms.born.push_back(BornReader(force, parameters).read(index));
            return "";
        }
    }
    catch (const UnknownBornModel& error) {
        whyNoBorn = error.what();
    }
    EnergyTerms::ValueEnergy energy;
    energy.force = index;
    energy.reason = whyNoBorn;
    const string reason = translateValues(force, parameters, energy);
    if (reason.empty())
        terms.valueEnergies.push_back(energy);
    return reason;
}

static const NativeForceKind KIND(typeid(CustomGBForce), translateCustomGB, copyCustomGB, NativeForceKind::NeedsPairs);
