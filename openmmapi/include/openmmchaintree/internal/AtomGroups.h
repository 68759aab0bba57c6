#ifndef OPENMM_CHAINTREE_ATOMGROUPS_H_
#define OPENMM_CHAINTREE_ATOMGROUPS_H_

#include "openmm/System.h"
#include "openmmchaintree/internal/VirtualPlace.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

class LinkStructure;

/**
 * Which particles an atom move displaces together, from the masses, constraints and virtual sites of a System and the
 * bonds of a StericExclusionForce.
 *
 * Particles that constraints join, directly or in a row, are a unit: they move as one. A hydrogen is a particle of less
 * than 4.5 amu with a single bond; its mass may have been repartitioned. A virtual site follows the particles that
 * define it. Particles in a link with a fixed particle do not move.
 */
class OPENMM_EXPORT_CHAINTREE AtomGroups {
public:
    AtomGroups(const OpenMM::System& system, const StericExclusionForce& force, const LinkStructure& structure);
    ~AtomGroups();
    AtomGroups(const AtomGroups&) = delete;
    AtomGroups& operator=(const AtomGroups&) = delete;
    /** Particles that are displaced together. */
    class Group {
    public:
        /** The particles that move by one shift. */
        std::vector<int> particles;
        /** The virtual sites that the others of their particles move by another shift, by their places. */
        std::vector<const VirtualPlace*> sites;
        /** The mass in amu, rounded, and the number of bonds to other particles: groups that are equal in both are
         *  about equally stiff. */
        std::pair<int, int> stiffness;
    };
    /**
     * Get the particles that an atom move chooses from by default: all that can move, in molecules with a radius, a
     * torsion or a ball joint.
     */
    std::vector<int> findDefaults() const;
    /**
     * Get the first of these particles in each unit.
     */
    std::vector<int> findFirstOfUnits(const std::vector<int>& particles) const;
    /**
     * Get what moves with a particle: its unit and, unless this is a hydrogen, the hydrogens that are bonded to it.
     * Throws an exception if the particle cannot move.
     *
     * @param withHydrogens  whether hydrogens follow
     * @param name           the name of the move in error messages
     */
    Group makeGroup(int particle, bool withHydrogens, const std::string& name) const;

private:
    void joinUnits(const OpenMM::System& system);
    bool isHydrogen(int particle) const;
    void checkUnit(int unit, const std::string& name) const;
    void addSites(Group& group, const std::string& name) const;
    void describe(Group& group) const;
    std::vector<double> masses;
    std::vector<int> links;
    /** Whether each particle is in a link with a fixed particle; and whether its molecule has a radius or a joint. */
    std::vector<bool> isFixed, isDefault;
    /** The particles bonded to each, by the bonds of the force and of its closures, without virtual sites. */
    std::vector<std::vector<int>> neighbors;
    /** The unit of each particle, and the particles of each unit. */
    std::vector<int> units;
    std::vector<std::vector<int>> members;
    /** Of units with particles of several links: the particles of their first constraint between two links. */
    std::map<int, std::pair<int, int>> torn;
    /** The virtual sites; for each particle the site that it is, if any, and the sites that it defines. */
    std::vector<VirtualPlace> sites;
    std::vector<const VirtualPlace*> siteOf;
    std::vector<std::vector<const VirtualPlace*>> sitesBy;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ATOMGROUPS_H_*/
