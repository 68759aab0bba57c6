#ifndef OPENMM_CHAINTREE_BOXVECTORS_H_
#define OPENMM_CHAINTREE_BOXVECTORS_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/Vec3.h"
#include <array>

namespace ChainTreePlugin {

/**
 * The three vectors of a periodic box, in nm.
 */
typedef std::array<OpenMM::Vec3, 3> BoxVectors;

/**
 * Get the periodic box of a Context.
 */
inline BoxVectors getBoxVectors(OpenMM::ContextImpl& context)
{
    BoxVectors box;
    context.getPeriodicBoxVectors(box[0], box[1], box[2]);
    return box;
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BOXVECTORS_H_*/
