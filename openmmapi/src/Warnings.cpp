#include "openmmchaintree/internal/Warnings.h"
#include <atomic>
#include <iostream>

using namespace std;

static void print(const string& message)
{
    cerr << "Warning: " << message << endl;
}

static atomic<void (*)(const string&)> currentHandler(print);

void ChainTreePlugin::warn(const string& message)
{
    currentHandler.load()(message);
}

void ChainTreePlugin::setWarningHandler(void (*handler)(const string& message))
{
    currentHandler = handler;
}
