#include "openmm/CustomGBForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/BornReader.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/SerializationLock.h"
#include "openmmchaintree/internal/ValueTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Copies share their tables with the original, whose destructor deletes them; not so if they are read from XML.
 */
static Force* copyCustomGB(const Force& force)
{
    SerializationLock lock;
    return XmlSerializer::clone<Force>(force);
}

static string translateCustomGB(const Force& owner, int index, const NativeForceKind::Parameters& parameters,
                                EnergyTerms& terms)
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
