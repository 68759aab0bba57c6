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
 * Computes expressions of the parameters of one particle, or of two, for the particles of a Force. Expressions of two
 * have the number 1 or 2 behind the name of a parameter.
 */
class ParticleExpressions {
public:
    typedef std::map<std::string, double> Variables;
    /** What an expression is for one particle or for two, and values of what else it depends on. */
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
     * Get one of the particles with the same parameters, for each that differ.
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
    /** What an expression of two particles depends on. */
    enum Dependence { OnNone = 0, OnFirst = 1, OnSecond = 2, OnBoth = 3 };
    Dependence getDependence(const Lepton::ExpressionTreeNode& node) const;
    /**
     * Get the indices of the parameters that appear in an expression of two particles.
     */
    std::set<int> findParameters(const Lepton::ExpressionTreeNode& node) const;
    /**
     * Get whether an expression is a sum, or else a product, of functions of one particle each. It is known for all
     * pairs if it is known for those with one particle (for which a product may not be 0).
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

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_PARTICLEEXPRESSIONS_H_*/
