#include "openmmchaintree/internal/SceneDefinition.h"
#include "openmmchaintree/internal/EngineArrays.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

SceneDefinition::SceneDefinition(const StericExclusionForce& force, const LinkStructure& structure) :
    parameters(force), isPeriodic(force.usesPeriodicBoundaryConditions()), isFlexible(structure.isFlexible()),
    torsionLinks(structure.getTorsionLinks()), ballJointLinks(structure.getBallJointLinks()),
    particleLinks(structure.getParticleLinks())
{
    for (const LinkStructure::Molecule& molecule : structure.getMolecules())
        moleculeRoots.push_back(molecule.root);
    for (const LinkStructure::Link& link : structure.getLinks()) {
        array<int, 4> torsion = {{CT_NULL, CT_NULL, CT_NULL, CT_NULL}};
        uint8_t joint = structure.getMolecules()[link.molecule].fixed ? ctFixedJoint : ctFreeJoint;
        if (link.torsion != -1) {
            force.getTorsionParticles(link.torsion, torsion[0], torsion[1], torsion[2], torsion[3]);
            joint = ctTorsionJoint;
        }
        else if (link.ballJoint != -1) {
            force.getBallJointParticles(link.ballJoint, torsion[1], torsion[2]);
            joint = ctBallJoint;
        }
        linkParents.push_back(link.parent);
        linkJoints.push_back(joint);
        linkTorsions.push_back(torsion);
    }
    exclusions.resize(force.getNumExclusions());
    for (int i = 0; i < force.getNumExclusions(); i++)
        force.getExclusionParticles(i, exclusions[i][0], exclusions[i][1]);
}

SceneDefinition::Parameters::Parameters(const StericExclusionForce& force) :
    radii(force.getNumParticles()), roles(force.getNumParticles()), overlapTolerance(force.getOverlapTolerance()),
    hydrogenBondAllowance(force.getHydrogenBondAllowance()), forceConstant(force.getForceConstant())
{
    for (int i = 0; i < force.getNumParticles(); i++) {
        StericExclusionForce::HydrogenBondRole role;
        force.getParticleParameters(i, radii[i], role);
        roles[i] = role;
    }
}

double SceneDefinition::Parameters::getTolerance(int particle1, int particle2) const
{
    const int role1 = roles[particle1], role2 = roles[particle2];
    const bool mayBond = ((role1 & ctDonor) && (role2 & ctAcceptor)) || ((role1 & ctAcceptor) && (role2 & ctDonor));
    return overlapTolerance + (mayBond ? hydrogenBondAllowance : 0);
}

ctDefinition SceneDefinition::describe(const vector<Vec3>& positions) const
{
    ctDefinition definition = {};
    definition.particleCount = getNumParticles();
    definition.positions = coordinatesOf(positions);
    definition.radii = parameters.radii.data();
    definition.hydrogenBondRoles = parameters.roles.data();
    definition.particleLinks = particleLinks.data();
    definition.listed = listed.empty() ? NULL : listed.data();
    definition.linkCount = getNumLinks();
    definition.linkParents = linkParents.data();
    definition.linkJoints = linkJoints.data();
    definition.linkTorsions = rowsOf(linkTorsions);
    definition.exclusionCount = exclusions.size();
    definition.exclusions = rowsOf(exclusions);
    definition.box = isPeriodic ? rowsOf(box) : NULL;
    definition.overlapTolerance = parameters.overlapTolerance;
    definition.hydrogenBondAllowance = parameters.hydrogenBondAllowance;
    definition.isFlexible = isFlexible;
    return definition;
}
