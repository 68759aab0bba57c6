#ifndef OPENMM_CHAINTREE_BORNREADER_H_
#define OPENMM_CHAINTREE_BORNREADER_H_

#include "lepton/ExpressionTreeNode.h"
#include "openmm/CustomGBForce.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/FormMatch.h"
#include "openmmchaintree/internal/ParticleExpressions.h"
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Says why a Force is not one of the models that BornReader knows.
 */
class UnknownBornModel : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/**
 * Reads a CustomGBForce that is a generalized Born model of ctBorn, however it is written.
 *
 * The expressions of the Force and of the models are brought to a normal form. The models' expressions have names for
 * the coefficients that a Force may choose. If the shapes agree, the coefficients give the value of each name. The
 * other coefficients must have the model's values for all particles. Finally the Force and the model are evaluated and
 * compared for random particles.
 */
class BornReader {
public:
    BornReader(const OpenMM::CustomGBForce& force, const NativeForceKind::Parameters& parameters) :
        force(force), model(force, parameters), numParticles(model.getNumParticles()), random(1), born()
    {
    }
    /**
     * Get the model. Throws an exception, whose text is one clause, if the Force is none of the models.
     *
     * @param index  the index of the Force in its System
     */
    EnergyTerms::Born read(int index);

private:
    static void require(bool condition, const char* what);
    static bool areSame(double a, double b, double rounding = 1e-13);
    void parse();
    int drawParticle()
    {
        return std::uniform_int_distribution<int>(0, numParticles - 1)(random);
    }
    double draw(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(random);
    }
    std::vector<double> getValues(const Lepton::ExpressionTreeNode& node,
                                  ParticleExpressions::Dependence particle) const;
    std::vector<double> getValues(const FormMatch& match, const std::string& name) const;
    double getNumber(const FormMatch& match, const std::string& name) const;
    bool arePairs(const Lepton::ExpressionTreeNode& node, bool product, std::function<double(int, int)> expected);
    void requireNumbers(const FormMatch& match, const char* what) const;
    void readPairSum();
    void readRadii();
    void readNecks(const FormMatch& match);
    void findCharges(const Lepton::ExpressionTreeNode& node);
    double findFactor(const Lepton::ExpressionTreeNode& node, const std::vector<double>& charges);
    void readPairEnergy();
    void readDielectrics(bool isScreened);
    void readSelfEnergy();
    void readSurface(const std::vector<double>& surface);
    void findRadii(const std::vector<double>& surface);
    void guard();
    const OpenMM::CustomGBForce& force;
    const ParticleExpressions model;
    const int numParticles;
    std::mt19937 random;
    std::string sumName, radiusName;
    Lepton::ExpressionTreeNode pairSum, radius, selfEnergy, pairEnergy;
    /** The coefficients of q1 q2 / f and of exp(k f) q1 q2 / f. */
    double plain, screened;
    EnergyTerms::Born born;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BORNREADER_H_*/
