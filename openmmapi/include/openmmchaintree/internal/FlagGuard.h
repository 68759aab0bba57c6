#ifndef OPENMM_CHAINTREE_FLAGGUARD_H_
#define OPENMM_CHAINTREE_FLAGGUARD_H_

namespace ChainTreePlugin {

/**
 * Sets a flag until the end of the scope.
 */
class FlagGuard {
public:
    explicit FlagGuard(bool& flag) : flag(flag)
    {
        flag = true;
    }
    ~FlagGuard()
    {
        flag = false;
    }
    FlagGuard(const FlagGuard&) = delete;
    FlagGuard& operator=(const FlagGuard&) = delete;

private:
    bool& flag;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FLAGGUARD_H_*/
