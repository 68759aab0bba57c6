#include "openmmchaintree/internal/Scene.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/EngineArrays.h"
#include <algorithm>
#include <cstring>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void fail(const string& message)
{
    throw OpenMMException("StericExclusionForce: " + message);
}

void Scene::Deleter::operator()(ctChainTree* tree) const
{
    ctDestroy(tree);
}

void Scene::Deleter::operator()(ctSelection* selection) const
{
    ctFreeSelection(selection);
}

Scene::Scene(const StericExclusionForce& force, const LinkStructure& structure) :
    definition(force, structure), energy(*this), counts(), numQueries(0)
{
}

Scene::~Scene()
{
}

void Scene::copyParameters(const StericExclusionForce& force)
{
    // The engine checks parameters when it makes a tree, for which any positions will do.

    SceneDefinition changed(definition);
    changed.parameters = SceneDefinition::Parameters(force);
    vector<Vec3> positions(definition.getNumParticles());
    if (tree)
        getPositions(positions);
    Tree created = createTree(changed, positions);
    if (tree) {
        copyLimits(created.get());
        setTree(std::move(created), std::move(positions));
    }
    definition = std::move(changed);
}

Scene::Tree Scene::createTree(const SceneDefinition& definition, const vector<Vec3>& positions)
{
    const ctDefinition described = definition.describe(positions);
    ctChainTree* created;
    char errorText[256];
    if (ctCreate(&described, &created, errorText, sizeof(errorText)) != ctSuccess)
        fail(errorText);
    return Tree(created);
}

void Scene::setTree(Tree created, vector<Vec3> positions)
{
    energy.reset();
    saved.exists = false;
    isScaled = false;
    other.reset();
    arrangement = std::move(positions);
    tree = std::move(created);
    followed.clear();
    set1 = PreparedSet();
    set2 = PreparedSet();
}

/**
 * Copy the limits of the present tree to a new one.
 */
void Scene::copyLimits(ctChainTree* created) const
{
    PairList pairs;
    vector<double> limits;
    readLimits(pairs, limits);
    if (ctSetLimits(created, pairs.size(), rowsOf(pairs), limits.data()) != ctSuccess)
        fail(ctGetErrorText(created));
}

/**
 * Set which particles the energy needs in leaves. If particles without a radius are added or dropped, this makes a new
 * tree with the same state.
 */
void Scene::setListed(vector<uint8_t> needed)
{
    saved.exists = false;
    bool treeIsOld = false;
    for (size_t i = 0; i < needed.size(); i++) {
        needed[i] = needed[i] && definition.parameters.radii[i] == 0;
        treeIsOld |= needed[i] != (definition.listed.empty() ? 0 : definition.listed[i]);
    }
    if (!treeIsOld)
        return;
    SceneDefinition changed(definition);
    changed.listed = std::move(needed);
    if (tree) {
        vector<double> state(ctGetStateSize(tree.get()));
        ctGetState(tree.get(), state.data());
        Tree created = createTree(changed, arrangement);
        if (ctSetState(created.get(), state.data()) != ctSuccess)
            fail(ctGetErrorText(created.get()));
        copyLimits(created.get());
        setTree(std::move(created), vector<Vec3>(arrangement));
    }
    definition = std::move(changed);
}

void Scene::check(ctStatus status) const
{
    check(status, tree.get());
}

void Scene::check(ctStatus status, const ctChainTree* failed) const
{
    if (status != ctSuccess)
        fail(ctGetErrorText(failed));
}

// ---- State ----

void Scene::setBox(const BoxVectors& box)
{
    SceneDefinition changed(definition);
    changed.box = box;
    createTree(changed, vector<Vec3>(definition.getNumParticles())); // which checks it
    definition.box = box;
}

bool Scene::hasBox(const BoxVectors& box) const
{
    return !isPeriodic() || memcmp(box.data(), definition.box.data(), sizeof(BoxVectors)) == 0;
}

void Scene::setPositions(const vector<Vec3>& positions, const BoxVectors& box)
{
    const bool boxIsNew = !hasBox(box);
    if (!tree) {
        SceneDefinition changed(definition);
        changed.box = box;
        setTree(createTree(changed, positions), positions);
        definition.box = box;
        return;
    }
    isScaled = false;
    if (boxIsNew)
        check(ctSetBox(tree.get(), rowsOf(box)));
    if (ctSetPositions(tree.get(), coordinatesOf(positions)) != ctSuccess) {
        const string reason = ctGetErrorText(tree.get());
        if (boxIsNew)
            check(ctSetBox(tree.get(), rowsOf(definition.box)));
        fail(reason);
    }
    definition.box = box;
}

void Scene::getPositions(vector<Vec3>& positions)
{
    positions.resize(definition.getNumParticles());
    ctGetPositions(tree.get(), coordinatesOf(positions));
}

void Scene::getPositionsOf(const vector<int>& particles, vector<Vec3>& positions)
{
    positions.resize(particles.size());
    check(ctGetPositionsOf(tree.get(), false, particles.size(), particles.data(), coordinatesOf(positions)));
}

// Trees that were arranged by other positions agree only up to rounding, so the arrangement is part of the state. In a
// periodic scene, the box comes after it.

/** How many numbers the vectors of a box are. */
static const size_t BOX_SIZE = 9;

void Scene::getState(vector<double>& state)
{
    state.clear();
    if (!tree)
        return;
    state.assign(coordinatesOf(arrangement), coordinatesOf(arrangement) + 3 * arrangement.size());
    if (isPeriodic())
        state.insert(state.end(), rowsOf(definition.box)[0], rowsOf(definition.box)[0] + BOX_SIZE);
    const size_t split = state.size();
    state.resize(split + ctGetStateSize(tree.get()));
    ctGetState(tree.get(), &state[split]);

    // This gives a continued run the same bits as a run that starts from these numbers.

    ctRenew(tree.get());
}

void Scene::setState(const vector<double>& state)
{
    if (state.empty()) {
        setTree(Tree(), {});
        return;
    }
    vector<Vec3> positions(definition.getNumParticles());
    SceneDefinition changed(definition);
    const size_t split = 3 * positions.size() + (isPeriodic() ? BOX_SIZE : 0);
    if (state.size() < split)
        fail("the state is of another structure");
    copy_n(state.begin(), 3 * positions.size(), coordinatesOf(positions));
    if (isPeriodic())
        for (size_t i = 0; i < BOX_SIZE; i++)
            changed.box[i / 3][i % 3] = state[3 * positions.size() + i];
    Tree created = createTree(changed, positions);
    if (state.size() != split + ctGetStateSize(created.get()))
        fail("the state is of another structure");
    if (ctSetState(created.get(), &state[split]) != ctSuccess)
        fail(ctGetErrorText(created.get()));
    setTree(std::move(created), std::move(positions));
    definition.box = changed.box;
}

void Scene::save()
{
    saved.exists = saved.isInOther = false;
    saved.box = definition.box;
    saved.numbers.resize(ctGetStateSize(tree.get()));
    ctGetState(tree.get(), saved.numbers.data());
    readLimits(saved.limitedPairs, saved.limits);
    energy.save();
    saved.exists = true;
}

void Scene::restore()
{
    if (!saved.exists)
        fail("no state was saved");
    isScaled = false;
    if (saved.isInOther)
        exchangeTrees();
    if (!hasBox(saved.box)) {
        check(ctSetBox(tree.get(), rowsOf(saved.box)));
        definition.box = saved.box;
    }
    check(ctSetState(tree.get(), saved.numbers.data()));
    PairList pairs;
    vector<double> limits;
    readLimits(pairs, limits);
    if (pairs != saved.limitedPairs || limits != saved.limits)
        check(ctSetLimits(tree.get(), saved.limits.size(), rowsOf(saved.limitedPairs), saved.limits.data()));
    energy.restore();
}

Vec3 Scene::getCentroid(int molecule) const
{
    Vec3 centroid;
    check(ctGetCentroid(tree.get(), definition.moleculeRoots[molecule], &centroid[0]));
    return centroid;
}

double Scene::getTorsionAngle(int torsion)
{
    double angle;
    if (ctGetTorsionAngle(tree.get(), definition.torsionLinks[torsion], &angle) != ctSuccess)
        fail("torsion " + to_string(torsion) + " has no value: " + ctGetErrorText(tree.get()));
    return angle;
}

void Scene::getOrientations(vector<array<double, 9>>& orientations)
{
    orientations.resize(definition.getNumLinks());
    ctGetOrientations(tree.get(), reinterpret_cast<double(*)[9]>(orientations.data()));
}

// ---- Limits ----

void Scene::clearLimits()
{
    if (tree)
        check(ctSetLimits(tree.get(), 0, NULL, NULL));
}

void Scene::raiseLimits()
{
    int raised;
    check(ctRaiseLimits(tree.get(), &raised, &counts));
}

int Scene::getNumLimits() const
{
    return tree ? ctGetLimitCount(tree.get()) : 0;
}

void Scene::readLimits(PairList& pairs, vector<double>& limits) const
{
    pairs.resize(getNumLimits());
    limits.resize(pairs.size());
    if (!pairs.empty())
        ctGetLimits(tree.get(), pairs.size(), rowsOf(pairs), limits.data());
}

void Scene::getLimits(vector<pair<int, int>>& pairs, vector<double>& limits) const
{
    PairList found;
    readLimits(found, limits);
    pairs.clear();
    for (const array<int, 2>& pair : found)
        pairs.push_back(make_pair(pair[0], pair[1]));
}

void Scene::setLimits(const vector<pair<int, int>>& pairs, const vector<double>& limits)
{
    PairList given;
    given.reserve(pairs.size());
    for (const pair<int, int>& pair : pairs)
        given.push_back({{pair.first, pair.second}});
    check(ctSetLimits(tree.get(), given.size(), rowsOf(given), limits.data()));
}

// ---- Trials ----

/**
 * Write a change in the engine's form.
 */
void Scene::describe(const Proposal::Change& proposed, ctChange& change) const
{
    Vec3 pivot;
    if (proposed.kind == Proposal::Torsion)
        change.link = definition.torsionLinks[proposed.index];
    else if (proposed.kind == Proposal::BallJoint)
        change.link = definition.ballJointLinks[proposed.index];
    else {
        change.link = definition.moleculeRoots[proposed.index];
        pivot = getCentroid(proposed.index);
    }
    change.angle = proposed.angle;
    for (int i = 0; i < 3; i++) {
        change.pivot[i] = pivot[i];
        change.rotation[i] = proposed.rotation[i];
        change.translation[i] = proposed.translation[i];
    }
}

void Scene::proposeDisplacements(const vector<Proposal::Displacement>& proposed)
{
    displacements.resize(proposed.size());
    for (size_t i = 0; i < proposed.size(); i++)
        displacements[i] = {proposed[i].particle, {proposed[i].shift[0], proposed[i].shift[1], proposed[i].shift[2]}};
    check(ctProposeDisplacements(tree.get(), displacements.size(), displacements.data()));
}

bool Scene::propose(const Proposal& proposal)
{
    if (proposal.getBoxFactor() != 1)
        return proposeScaled(proposal.getBoxFactor());
    isScaled = false;
    if (!proposal.getDisplacements().empty()) {
        proposeDisplacements(proposal.getDisplacements());
        return true;
    }
    const vector<Proposal::Change>& proposed = proposal.getChanges();
    changes.resize(proposed.size());
    for (int i = 0; i < (int)proposed.size(); i++)
        describe(proposed[i], changes[i]);
    check(ctPropose(tree.get(), changes.size(), changes.data()));
    return true;
}

bool Scene::hasTrial() const
{
    return isScaled || ctHasTrial(tree.get());
}

bool Scene::test()
{
    if (isScaled)
        return testScaled();
    bool clash;
    check(ctTestTrial(tree.get(), &clash, NULL, &counts));
    numQueries++;
    return !clash;
}

void Scene::getTrialPositions(vector<Vec3>& positions)
{
    if (isScaled) {
        positions = getScaledPositions();
        return;
    }
    positions.resize(definition.getNumParticles());
    check(ctGetTrialPositions(tree.get(), coordinatesOf(positions)));
}

void Scene::getTrialPositionsOf(const vector<int>& particles, vector<Vec3>& positions)
{
    positions.resize(particles.size());
    if (isScaled) {
        check(ctGetPositionsOf(other.get(), false, particles.size(), particles.data(), coordinatesOf(positions)));
        return;
    }
    check(ctGetPositionsOf(tree.get(), true, particles.size(), particles.data(), coordinatesOf(positions)));
}

const vector<Vec3>& Scene::followTrial()
{
    if (isScaled)
        return getScaledPositions();
    const bool isNew = followed.empty();
    vector<Vec3> made(isNew ? definition.getNumParticles() : 0);
    check(ctFollowTrialPositions(tree.get(), isNew, coordinatesOf(isNew ? made : followed)));
    if (isNew)
        followed = std::move(made);
    return followed;
}

const vector<Vec3>& Scene::followState()
{
    const bool isNew = followed.empty();
    followed.resize(definition.getNumParticles());
    ctFollowPositions(tree.get(), isNew, coordinatesOf(followed));
    return followed;
}

void Scene::accept()
{
    if (isScaled) {
        exchangeTrees();
        definition.box = scaledBox;
        isScaled = false;
        return;
    }
    check(ctAccept(tree.get(), &counts));
    energy.accept();
}

void Scene::reject()
{
    isScaled = false;
    if (tree)
        ctReject(tree.get());
}
