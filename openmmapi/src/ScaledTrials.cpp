/* The trials of a Scene that scale its box. They change all pairs, so they are made as the state of another tree, which
 * an accepted trial exchanges with the tree of the state. A rejected one leaves that tree as it is, bit by bit. */

#include "openmmchaintree/internal/EngineArrays.h"
#include "openmmchaintree/internal/Scene.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

bool Scene::proposeScaled(double factor)
{
    reject();
    if (!other)
        other = createTree(definition, arrangement);
    vector<double> numbers(ctGetStateSize(tree.get()));
    ctGetState(tree.get(), numbers.data());
    check(ctSetBox(other.get(), rowsOf(definition.box)), other.get());
    check(ctSetState(other.get(), numbers.data()), other.get());
    const ctStatus status = ctScaleBox(other.get(), factor);
    if (status == ctInvalidArgument)
        return false;
    check(status, other.get());
    copyLimits(other.get());
    ctGetBox(other.get(), rowsOf(scaledBox));
    isScaled = true;
    return true;
}

/**
 * Exchange the trees and their energies.
 */
void Scene::exchangeTrees()
{
    tree.swap(other);
    energy.exchange();
    saved.isInOther = !saved.isInOther;
    followed.clear();
    set1 = PreparedSet();
    set2 = PreparedSet();
}

bool Scene::testScaled()
{
    bool clash;
    check(ctTestState(other.get(), &clash, NULL, &counts), other.get());
    numQueries++;
    return !clash;
}

const vector<Vec3>& Scene::getScaledPositions()
{
    scaledPositions.resize(definition.getNumParticles());
    ctGetPositions(other.get(), coordinatesOf(scaledPositions));
    return scaledPositions;
}
