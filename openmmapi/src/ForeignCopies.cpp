#include "openmmchaintree/internal/ForeignCopies.h"
#include "openmm/CMAPTorsionForce.h"
#include "openmm/CustomAngleForce.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomGBForce.h"
#include "openmm/CustomHbondForce.h"
#include "openmm/CustomManyParticleForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GayBerneForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/RMSDForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include <typeindex>
#include <unordered_set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

bool ForeignCopies::canCopy(const Force& force)
{
    static const unordered_set<type_index> classes = {typeid(CMAPTorsionForce),
                                                      typeid(CustomAngleForce),
                                                      typeid(CustomBondForce),
                                                      typeid(CustomCentroidBondForce),
                                                      typeid(CustomCompoundBondForce),
                                                      typeid(CustomExternalForce),
                                                      typeid(CustomGBForce),
                                                      typeid(CustomHbondForce),
                                                      typeid(CustomManyParticleForce),
                                                      typeid(CustomNonbondedForce),
                                                      typeid(CustomTorsionForce),
                                                      typeid(GayBerneForce),
                                                      typeid(GBSAOBCForce),
                                                      typeid(HarmonicAngleForce),
                                                      typeid(HarmonicBondForce),
                                                      typeid(NonbondedForce),
                                                      typeid(PeriodicTorsionForce),
                                                      typeid(RBTorsionForce),
                                                      typeid(RMSDForce)};
    return classes.count(typeid(force)) != 0;
}

ForeignCopies::ForeignCopies(ContextImpl& context, const vector<const Force*>& forces) :
    outer(context), integrator(0.001)
{
    for (int i = 0; i < context.getSystem().getNumParticles(); i++)
        system.addParticle(context.getSystem().getParticleMass(i));
    const BoxVectors box = getBoxVectors(context);
    system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
    for (const Force* force : forces) {
        Force* copy = XmlSerializer::clone(*force);
        copy->setForceGroup(system.addForce(copy));
        if (NonbondedForce* nonbonded = dynamic_cast<NonbondedForce*>(copy))
            nonbonded->setReciprocalSpaceForceGroup(-1);
    }
    inner.reset(context.createLinkedContext(system, integrator));
}

double ForeignCopies::computeEnergy(const vector<int>& chosen)
{
    outer.getPositions(positions);
    const BoxVectors box = getBoxVectors(outer);
    inner->setPeriodicBoxVectors(box[0], box[1], box[2]);
    inner->setPositions(positions);
    for (auto& parameter : map<string, double>(inner->getParameters())) {
        const double present = outer.getParameter(parameter.first);
        if (present != parameter.second)
            inner->setParameter(parameter.first, present);
    }
    unsigned int groups = 0;
    for (int force : chosen)
        groups |= 1u << force;
    return inner->getState(State::Energy, false, (int)groups).getPotentialEnergy();
}
