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
 * Steps copy Forces, so this does not use OpenMM's XML, which shares memory among threads.
 */
static Force* copyCustomGB(const CustomGBForce& original)
{
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

static string translateCustomGB(const CustomGBForce& force, const NativeForceKind::Setting& setting, EnergyTerms& terms)
{
    const bool isPeriodic = setting.isPeriodic && force.getNonbondedMethod() == CustomGBForce::CutoffPeriodic;
    if (force.getNonbondedMethod() == CustomGBForce::CutoffPeriodic && !isPeriodic)
        return "its cutoff is periodic";
    string whyNoBorn = checkBornPartners(terms);
    try {
        if (whyNoBorn.empty()) {
            terms.born.push_back(BornReader(force, setting.parameters).read(setting.index));
            return "";
        }
    }
    catch (const UnknownBornModel& error) {
        whyNoBorn = error.what();
    }
    EnergyTerms::ValueEnergy energy;
    energy.force = setting.index;
    energy.reason = whyNoBorn;
    energy.periodic = isPeriodic;
    const string reason = translateValues(force, setting.parameters, energy);
    if (reason.empty())
        terms.valueEnergies.push_back(energy);
    return reason;
}

static const NativeForceKind CUSTOM_GB(translateCustomGB, copyCustomGB, NativeForceKind::NeedsPairs);
