#ifndef OPENMM_CHAINTREE_PARTICLEEXPRESSIONS_H_
#define OPENMM_CHAINTREE_PARTICLEEXPRESSIONS_H_

#include "lepton/ExpressionTreeNode.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Computes expressions of the parameters of one particle, or of two, for the particles of a Force. In expressions of
 * two particles, a parameter's name ends with 1 or 2.
 */
class ParticleExpressions {
public:
    typedef std::map<std::string, double> Variables;
    /** The value of an expression for one particle or for two, given the values of its other variables. */
    typedef std::function<double(int particle, const Variables& others)> OfParticle;
    typedef std::function<double(int particle1, int particle2, const Variables& others)> OfPair;
    template <class Force>
    ParticleExpressions(const Force& force, const NativeForceKind::Parameters& parameters) : functions(force)
    {
        for (int i = 0; i < force.getNumGlobalParameters(); i++)
            globals[force.getGlobalParameterName(i)] = parameters.at(force.getGlobalParameterName(i));
        for (int i = 0; i < force.getNumPerParticleParameters(); i++)
            names.push_back(force.getPerParticleParameterName(i));
        particles.resize(force.getNumParticles());
        for (int i = 0; i < force.getNumParticles(); i++) {
            force.getParticleParameters(i, particles[i]);
            particles[i].resize(names.size());
        }
        findDifferent();
    }
    int getNumParticles() const
    {
        return particles.size();
    }
    /**
     * Get one particle of each set of equal parameters.
     */
    const std::vector<int>& getDifferentParticles() const
    {
        return different;
    }
    const std::vector<std::string>& getNames() const
    {
        return names;
    }
    /**
     * Get the value of a parameter, by its index among the names.
     */
    double getParameter(int particle, int name) const
    {
        return particles[particle][name];
    }
    Lepton::ExpressionTreeNode parse(const std::string& expression) const;
    OfParticle ofParticle(const Lepton::ExpressionTreeNode& node) const;
    OfPair ofPair(const Lepton::ExpressionTreeNode& node) const;
    /**
     * Compute an expression of global parameters.
     */
    double computeNumber(const Lepton::ExpressionTreeNode& node) const;
    /** The particles on which an expression of two depends. */
    enum Dependence { OnNone = 0, OnFirst = 1, OnSecond = 2, OnBoth = 3 };
    Dependence getDependence(const Lepton::ExpressionTreeNode& node) const;
    /**
     * Get the indices of the parameters that appear in an expression of two particles.
     */
    std::set<int> findParameters(const Lepton::ExpressionTreeNode& node) const;
    /**
     * Get whether an expression is a sum, or else a product, of functions of one particle each. It suffices to test the
     * pairs with one particle (for which a product must not be 0).
     */
    bool isSeparable(const Lepton::ExpressionTreeNode& node, bool product) const;

private:
    void findDifferent();
    const TabulatedFunctions functions;
    Variables globals;
    std::vector<std::string> names;
    std::vector<std::vector<double>> particles;
    std::vector<int> different;
};

/** The number of pairs of particles that are tried to find out if an energy is the same in either order of the two. */
static const int NUM_TRIED_PAIRS = 500;

/**
 * Get whether the energies of two particles in either order agree.
 */
bool areSameInEitherOrder(double energy, double reversedEnergy);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_PARTICLEEXPRESSIONS_H_*/
