#ifndef OPENMM_CHAINTREE_CONTEXTLOCK_H_
#define OPENMM_CHAINTREE_CONTEXTLOCK_H_

#include "windowsExportChainTree.h"
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace ChainTreePlugin {

/**
 * Lets one thread at a time use the plugin's data of a Context. Another thread waits. It gets an exception instead if
 * the first thread may in turn wait for it, as for Python's lock, or if it is OpenMM's during a call of the user:
 * waiting would not undo the changes that OpenMM has already made.
 */
class OPENMM_EXPORT_CHAINTREE ContextLock {
public:
    enum Caller {
        /**
         * A call of the user. It is refused within another one, where a trial may be open.
         */
        User,
        /**
         * A call of OpenMM, which may come from within a call of the user.
         */
        OpenMM
    };
    ContextLock() : holdingCaller(User), depth(0), admitsHelpers(false)
    {
    }
    void take(Caller caller);
    void release();
    /**
     * Set whether helperMayPass() lets threads of OpenMM pass while this thread holds the lock. Returns the former
     * value.
     */
    bool admitHelpers(bool admit);
    bool helperMayPass();

private:
    std::mutex mutex;
    std::condition_variable released;
    std::thread::id holder;
    /** Who called when the holder took it first. */
    Caller holdingCaller;
    /** How often the holder has taken it. */
    int depth;
    bool admitsHelpers;
};

/**
 * Holds a lock for as long as it lives.
 */
class ContextUse {
public:
    ContextUse(const std::shared_ptr<ContextLock>& lock, ContextLock::Caller caller) : lock(lock)
    {
        lock->take(caller);
    }
    ~ContextUse()
    {
        lock->release();
    }
    ContextUse(const ContextUse&) = delete;
    ContextUse& operator=(const ContextUse&) = delete;

private:
    /** The lock outlives the Context if that ends meanwhile. */
    const std::shared_ptr<ContextLock> lock;
};

/**
 * Admits helpers for as long as it lives. An evaluation of forces in a step needs it: GPU platforms call
 * StericExclusionForceImpl::computeForce() on another thread, for which this one waits.
 */
class HelperAdmission {
public:
    explicit HelperAdmission(ContextLock& lock) : lock(lock), former(lock.admitHelpers(true))
    {
    }
    ~HelperAdmission()
    {
        lock.admitHelpers(former);
    }
    HelperAdmission(const HelperAdmission&) = delete;
    HelperAdmission& operator=(const HelperAdmission&) = delete;

private:
    ContextLock& lock;
    const bool former;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CONTEXTLOCK_H_*/
