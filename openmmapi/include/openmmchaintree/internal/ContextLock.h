#ifndef OPENMM_CHAINTREE_CONTEXTLOCK_H_
#define OPENMM_CHAINTREE_CONTEXTLOCK_H_

#include "windowsExportChainTree.h"
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace ChainTreePlugin {

/**
 * This keeps what this plugin holds of a Context to one thread at a time. Another thread waits. It is refused by an
 * exception if the first one may in turn wait for it, as for Python's lock, or if OpenMM itself is at work there in the
 * midst of a call of the user: what it has done before it asked for this lock would not be undone by waiting.
 */
class OPENMM_EXPORT_CHAINTREE ContextLock {
public:
    enum Caller {
        /**
         * A call of the user. It is refused within another one: there the state may be in the midst of a trial.
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
     * Let threads that work for OpenMM pass helperMayPass() while this thread holds the lock. Returns what held
     * before.
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
