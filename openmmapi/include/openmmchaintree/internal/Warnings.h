#ifndef OPENMM_CHAINTREE_WARNINGS_H_
#define OPENMM_CHAINTREE_WARNINGS_H_

#include "windowsExportChainTree.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Tell the user of something that is allowed, but perhaps not what was meant. OpenMM has no way for this. It goes to
 * the standard error stream unless setWarningHandler() says otherwise.
 */
void warn(const std::string& message);

/**
 * Say who is to tell the user. The Python module hands warnings to Python's own.
 *
 * @param handler  what to call with the message of each warning. It may throw an OpenMMException.
 */
OPENMM_EXPORT_CHAINTREE void setWarningHandler(void (*handler)(const std::string& message));

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_WARNINGS_H_*/
