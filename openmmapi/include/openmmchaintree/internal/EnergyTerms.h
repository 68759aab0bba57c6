#ifndef OPENMM_CHAINTREE_ENERGYTERMS_H_
#define OPENMM_CHAINTREE_ENERGYTERMS_H_

#include <array>
#include <vector>

namespace ChainTreePlugin {

/**
 * The energy that the kernel evaluates for each trial, in numbers. This is what Forces of a System are translated to;
 * ctenergy.h, the manual of the library that evaluates it, says what each field means.
 */
class EnergyTerms {
public:
    enum TermKind {
        HarmonicBond,
        HarmonicAngle,
        PeriodicTorsion,
        RyckaertBellemans,
        TorsionMap,
        Exception,
        Expression
    };
    enum Measure { X, Y, Z, Distance, Angle, Dihedral };
    /** Something that is measured of the particles of a term. */
    struct Input {
        Measure measure;
        std::array<int, 4> particles;
    };
    /** An operation with the results of earlier ones. The operators are those of ctenergy.h, by the same names. */
    enum Operator {
        Constant,
        InputValue,
        ParameterValue,
        Add,
        Subtract,
        Multiply,
        Divide,
        Power,
        Negate,
        Sqrt,
        Exp,
        Log,
        Sin,
        Cos,
        Sec,
        Csc,
        Tan,
        Cot,
        Asin,
        Acos,
        Atan,
        Atan2,
        Sinh,
        Cosh,
        Tanh,
        Erf,
        Erfc,
        Step,
        Delta,
        Square,
        Cube,
        Reciprocal,
        AddConstant,
        MultiplyConstant,
        PowerConstant,
        Min,
        Max,
        Abs,
        Floor,
        Ceil,
        Select
    };
    struct Operation {
        Operator kind;
        std::array<int, 3> arguments;
        double constant;
    };
    struct Map {
        int size;
        std::vector<double> coefficients;
    };
    /** Terms of one kind, all of one Force. */
    struct TermSet {
        /** The index of the Force in the System. */
        int force;
        TermKind kind;
        int particlesPerTerm, parametersPerTerm;
        std::vector<int> particles;
        std::vector<double> parameters;
        std::vector<Map> maps;
        std::vector<Input> inputs;
        std::vector<Operation> operations;
    };
    /** Lennard-Jones and Coulomb between all particles. */
    struct Nonbonded {
        int force;
        std::vector<double> charges, sigmas, epsilons;
        /** Infinite if there is none. */
        double cutoff;
        double switchingDistance, dielectric;
        std::vector<std::array<int, 2>> exclusions;
    };
    /** None or one. */
    std::vector<Nonbonded> nonbonded;
    std::vector<TermSet> termSets;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENERGYTERMS_H_*/
