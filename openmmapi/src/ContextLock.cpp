#include "openmmchaintree/internal/ContextLock.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/Interpreter.h"

using namespace ChainTreePlugin;
using namespace std;

void ContextLock::take(Caller caller)
{
    unique_lock<std::mutex> guard(mutex);
    if (depth > 0 && holder == this_thread::get_id()) {
        if (caller == User)
            throw OpenMM::OpenMMException(
                "this was called from within a step or another call on the same Context; call "
                "it when that has returned");
    }
    else if (depth > 0) {
        Interpreter* const interpreter = Interpreter::get();
        const bool isSafe = caller == User || holdingCaller == OpenMM;
        if (!isSafe || (interpreter != NULL && !interpreter->mayWait()))
            throw OpenMM::OpenMMException("another thread is using this Context, in a step or another call of "
                                          "openmm-chaintree; wait until that has returned");
        released.wait(guard, [this] {
            return depth == 0;
        });
    }
    if (depth++ > 0)
        return;
    holder = this_thread::get_id();
    holdingCaller = caller;
}

void ContextLock::release()
{
    lock_guard<std::mutex> guard(mutex);
    if (--depth == 0)
        released.notify_one();
}

bool ContextLock::admitHelpers(bool admit)
{
    lock_guard<std::mutex> guard(mutex);
    const bool former = admitsHelpers;
    admitsHelpers = admit;
    return former;
}

bool ContextLock::helperMayPass()
{
    lock_guard<std::mutex> guard(mutex);
    return admitsHelpers && holder != this_thread::get_id();
}
