#ifndef OPENMM_CHAINTREE_MOLECULECHOICES_H_
#define OPENMM_CHAINTREE_MOLECULECHOICES_H_

#include "openmmchaintree/internal/LinkStructure.h"
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Get the molecules that a move of molecules chooses from. It is an error if there is none, or if one is named twice or
 * has fixed particles.
 *
 * @param particles  a particle of each molecule that the move names; if empty, all molecules without fixed particles
 * @param name       the name of the move in messages
 */
std::vector<int> chooseMolecules(const LinkStructure& structure, const std::vector<int>& particles,
                                 const std::string& name);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_MOLECULECHOICES_H_*/
