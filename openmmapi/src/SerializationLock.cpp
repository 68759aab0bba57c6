#include "openmmchaintree/internal/SerializationLock.h"

using namespace ChainTreePlugin;
using namespace std;

static recursive_mutex& getMutex()
{
    static recursive_mutex mutex;
    return mutex;
}

SerializationLock::SerializationLock() : lock(getMutex())
{
}
