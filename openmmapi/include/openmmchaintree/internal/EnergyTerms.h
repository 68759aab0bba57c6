#ifndef OPENMM_CHAINTREE_ENERGYTERMS_H_
#define OPENMM_CHAINTREE_ENERGYTERMS_H_

#include "ctenergy.h"
#include <array>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * The energy that a Scene evaluates for each trial, in numbers: the translation of Forces of a System. ctenergy.h, the
 * manual of the library that evaluates it, explains each field.
 */
class EnergyTerms {
public:
    struct Map {
        int size;
        std::vector<double> coefficients;
    };
    /** Terms of one kind, all of one Force. */
    struct TermSet {
        /** The index of the Force in the System. */
        int force;
        ctTermKind kind;
        int particlesPerTerm, parametersPerTerm;
        std::vector<int> particles;
        std::vector<double> parameters;
        std::vector<Map> maps;
        std::vector<ctInput> inputs;
        std::vector<ctOperation> operations;
        /** 0 but for ctCentroidTerm. */
        int groupsPerTerm = 0;
        /** Whether differences of positions are those of nearest images. */
        bool periodic = false;
    };
    /** Lennard-Jones and Coulomb between all particles. */
    struct Nonbonded {
        int force;
        std::vector<double> charges, sigmas, epsilons;
        /** Infinite if there is none. */
        double cutoff;
        double switchingDistance, dielectric;
        std::vector<std::array<int, 2>> exclusions;
        bool periodic = false;
        /** The long-range correction times the volume of the box, kJ/mol nm^3. */
        double dispersion = 0;
        /** Of Ewald summation, 1/nm; 0 if there is none. The reciprocal space is no part of these terms. */
        double ewaldAlpha = 0;
    };
    /** A function by a table; see ctTable. */
    struct TableFunction {
        bool discrete, periodic;
        int dimensions;
        std::array<int, 3> sizes;
        std::array<double, 3> minima, maxima;
        std::vector<double> values;
    };
    /** Two sets of particles that interact. */
    typedef std::array<std::vector<int>, 2> InteractionGroup;
    /** An expression of two particles, summed over pairs. */
    struct PairSet {
        int force;
        std::vector<ctOperation> operations;
        std::vector<TableFunction> tables;
        int parametersPerParticle;
        std::vector<double> parameters;
        /** Infinite if there is none. */
        double cutoff;
        double switchingDistance;
        std::vector<std::array<int, 2>> exclusions;
        std::vector<InteractionGroup> groups;
        bool periodic = false;
        /** As dispersion in Nonbonded. */
        double longRange = 0;
    };
    /** Generalized Born solvation. */
    struct Born {
        int force;
        std::vector<double> charges, radii, offsetRadii, scaledRadii;
        bool filled, rescaled;
        std::vector<double> alphas, betas, gammas;
        int numNeckTypes;
        std::vector<int> neckTypes;
        std::vector<double> neckHeights, neckDistances;
        double neckScale, neckCut;
        double coulomb, soluteDielectric, solventDielectric, kappa, surfaceEnergy, probeRadius;
        /** Infinite if there is none. */
        double cutoff;
        double shift;
        bool periodic;
    };
    /** An expression of the numbers of a particle or of two. */
    struct ValueExpression {
        ctExtent extent;
        std::vector<ctOperation> operations;
        std::vector<TableFunction> tables;
    };
    /** An energy of values that particles have; see ctValueEnergy. */
    struct ValueEnergy {
        int force;
        /** One clause that says why it is not a Born. */
        std::string reason;
        int parametersPerParticle;
        std::vector<double> parameters;
        std::vector<ValueExpression> values, terms;
        /** Infinite if there is none. */
        double cutoff;
        std::vector<std::array<int, 2>> exclusions;
        bool periodic = false;
    };
    /** How trials approximate nonbonded and born, with the defaults of TorsionMonteCarloIntegrator. */
    struct StandIn : ctStandIn {
        StandIn() : ctStandIn{0.55, 0.8, 0.08}
        {
        }
        bool operator==(const StandIn& other) const
        {
            return bornCutoff == other.bornCutoff && pairCutoff == other.pairCutoff && gridWidth == other.gridWidth;
        }
    };
    /** None or one. */
    std::vector<Nonbonded> nonbonded;
    /** None or one, which needs a Nonbonded. */
    std::vector<Born> born;
    /** Read with a Born alone. */
    StandIn standIn;
    std::vector<PairSet> pairSets;
    std::vector<TermSet> termSets;
    std::vector<ValueEnergy> valueEnergies;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENERGYTERMS_H_*/
