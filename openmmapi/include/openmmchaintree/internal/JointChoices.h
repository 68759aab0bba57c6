#ifndef OPENMM_CHAINTREE_JOINTCHOICES_H_
#define OPENMM_CHAINTREE_JOINTCHOICES_H_

#include "openmmchaintree/internal/LinkStructure.h"
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Throw an exception if there are no torsions, or if a move names one that does not exist or names one twice.
 *
 * @param torsions  the torsions that the move names
 * @param name      the name of the move in messages
 */
void checkTorsions(const LinkStructure& structure, const std::vector<int>& torsions, const std::string& name);

/**
 * Get the torsions that a move of single torsions chooses from. It is an error if there is none, or if one lies in the
 * ring of a closure.
 *
 * @param torsions  the torsions that the move names; if empty, all outside rings of closures
 * @param name      the name of the move in messages
 */
std::vector<int> chooseTorsions(const LinkStructure& structure, const std::vector<int>& torsions,
                                const std::string& name);

/**
 * The same of ball joints.
 */
std::vector<int> chooseBallJoints(const LinkStructure& structure, const std::vector<int>& ballJoints,
                                  const std::string& name);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_JOINTCHOICES_H_*/
