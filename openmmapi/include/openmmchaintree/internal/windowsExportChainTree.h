#ifndef OPENMM_WINDOWSEXPORTCHAINTREE_H_
#define OPENMM_WINDOWSEXPORTCHAINTREE_H_

/*
 * Marks the classes that libOpenMMChainTree offers to others. The build of that library defines
 * OPENMM_CHAINTREE_BUILDING_SHARED_LIBRARY; whoever uses it defines nothing.
 */

#ifdef _MSC_VER
// Private members of standard library types are never touched from outside.
#pragma warning(disable : 4251)
#if defined(OPENMM_CHAINTREE_BUILDING_SHARED_LIBRARY)
#define OPENMM_EXPORT_CHAINTREE __declspec(dllexport)
#else
#define OPENMM_EXPORT_CHAINTREE __declspec(dllimport)
#endif
#else
#define OPENMM_EXPORT_CHAINTREE __attribute__((visibility("default")))
#endif

#endif /*OPENMM_WINDOWSEXPORTCHAINTREE_H_*/
