#include "openmmchaintree/internal/ContextSnapshot.h"
#include "openmm/State.h"
#include <cstring>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Write each parameter of a Context after its name.
 */
static void writeParameters(CheckpointWriter& writer, const map<string, double>& parameters)
{
    writer.write((uint64_t)parameters.size());
    for (auto& parameter : parameters) {
        writer.write(parameter.first);
        writer.write(parameter.second);
    }
}

static map<string, double> readParameters(CheckpointReader& reader)
{
    map<string, double> parameters;
    uint64_t count = reader.read<uint64_t>();
    for (uint64_t i = 0; i < count; i++) {
        string name = reader.readString();
        parameters[name] = reader.read<double>();
    }
    return parameters;
}

ContextSnapshot::ContextSnapshot(const Context& context, bool positionsAreSet) : box(3)
{
    State state = context.getState(State::Positions | State::Velocities | State::Parameters);
    if (positionsAreSet)
        positions = state.getPositions();
    velocities = state.getVelocities();
    parameters = state.getParameters();
    state.getPeriodicBoxVectors(box[0], box[1], box[2]);
    time = state.getTime();
    stepCount = state.getStepCount();
}

ContextSnapshot::ContextSnapshot(CheckpointReader& reader) :
    positions(reader.readVector<Vec3>()), velocities(reader.readVector<Vec3>()), box(reader.readVector<Vec3>()),
    parameters(readParameters(reader)), time(reader.read<double>()), stepCount(reader.read<long long>())
{
    if (box.size() != 3)
        throw OpenMMException("loadCheckpoint: the checkpoint is damaged");
}

void ContextSnapshot::write(CheckpointWriter& writer) const
{
    writer.write(positions);
    writer.write(velocities);
    writer.write(box);
    writeParameters(writer, parameters);
    writer.write(time);
    writer.write(stepCount);
}

bool ContextSnapshot::updatePositions(const Context& context)
{
    vector<Vec3> present = context.getState(State::Positions).getPositions();
    present.swap(positions);
    return present.size() != positions.size() ||
           memcmp(present.data(), positions.data(), positions.size() * sizeof(Vec3)) != 0;
}

void ContextSnapshot::updateVelocities(const Context& context)
{
    velocities = context.getState(State::Velocities).getVelocities();
}

void ContextSnapshot::restore(Context& context) const
{
    context.setTime(time);
    context.setStepCount(stepCount);
    context.setPeriodicBoxVectors(box[0], box[1], box[2]);
    if (!positions.empty())
        context.setPositions(positions);
    context.setVelocities(velocities);
    for (auto& parameter : context.getParameters()) {
        auto known = parameters.find(parameter.first);
        if (known != parameters.end())
            context.setParameter(known->first, known->second);
    }
}
