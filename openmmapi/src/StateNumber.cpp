#include "openmmchaintree/internal/StateNumber.h"
#include "openmm/OpenMMException.h"
#include <cmath>
#include <cstdlib>
#include <limits>
#include <locale>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

string ChainTreePlugin::writeNumber(double value)
{
    for (int digits = 1;; digits++) {
        stringstream text;
        text.imbue(locale::classic());
        text.precision(digits);
        text << value;
        double read;
        if ((text >> read && read == value) || digits == numeric_limits<double>::max_digits10)
            return text.str();
    }
}

SerializationNode& ChainTreePlugin::setNumber(SerializationNode& node, const string& name, double value)
{
    return node.setStringProperty(name, writeNumber(value));
}

double ChainTreePlugin::getNumber(const SerializationNode& node, const string& name)
{
    const string& property = node.getStringProperty(name);
    istringstream text(property);
    text.imbue(locale::classic());
    double value;
    if (text >> value && text.eof())
        return value;

    // Streams write infinities and NaN, but do not read them. strtod() does, in every locale.

    char* end;
    value = strtod(property.c_str(), &end);
    if (!isfinite(value) && *end == '\0')
        return value;
    throw OpenMMException("the State is damaged: " + name + " is \"" + property + "\", which is no number");
}
