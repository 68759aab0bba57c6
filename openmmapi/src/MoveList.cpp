#include "openmmchaintree/internal/MoveList.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/Fingerprint.h"
#include "openmmchaintree/internal/StateNumber.h"
#include <algorithm>
#include <cstdint>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void fail(const string& message)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: " + message);
}

MoveList::MoveList() : structure(NULL)
{
}

// ---- The list ----

/**
 * Bind a move to links, if there are any.
 */
static void bindMove(MonteCarloMove& move, const LinkStructure* structure, size_t index)
{
    if (structure != NULL)
        move.bind(*structure, "TorsionMonteCarloIntegrator: move " + to_string(index));
}

static void checkWeight(double weight)
{
    checkNotNegative(weight, "TorsionMonteCarloIntegrator: the weight of a move");
}

int MoveList::add(unique_ptr<MonteCarloMove> move, double weight)
{
    checkWeight(weight);
    bindMove(*move, structure, entries.size());
    entries.push_back({std::move(move), weight, {}, {}});
    return entries.size() - 1;
}

void MoveList::set(int index, unique_ptr<MonteCarloMove> move, double weight)
{
    ASSERT_VALID_INDEX(index, entries);
    checkWeight(weight);
    bindMove(*move, structure, index);
    entries[index] = {std::move(move), weight, {}, {}};
}

void MoveList::remove(int index)
{
    ASSERT_VALID_INDEX(index, entries);
    entries.erase(entries.begin() + index);
}

const MoveList::Entry& MoveList::get(int index) const
{
    ASSERT_VALID_INDEX(index, entries);
    return entries[index];
}

void MoveList::requireKind(int index, const MoveKind& kind) const
{
    if (&get(index).move->getKind() != &kind)
        fail("move " + to_string(index) + " is not " + MoveKind::withArticle(kind.name));
}

void MoveList::bind(const LinkStructure* structure)
{
    for (size_t i = 0; i < entries.size(); i++)
        bindMove(*entries[i].move, structure, i);
    this->structure = structure;
}

double MoveList::sumWeights() const
{
    if (entries.empty())
        fail("there are no moves; add one, for example by addTorsionMove()");
    double sum = 0;
    for (const Entry& entry : entries)
        sum += entry.weight;
    if (sum == 0)
        fail("all moves have weight 0");
    return sum;
}

bool MoveList::displaceParticles() const
{
    return any_of(entries.begin(), entries.end(), [](const Entry& entry) {
        return entry.move->displacesParticles();
    });
}

double MoveList::getDisplacingShare() const
{
    double sum = 0, displacing = 0;
    for (const Entry& entry : entries) {
        sum += entry.weight;
        displacing += entry.move->displacesParticles() ? entry.weight : 0;
    }
    return sum > 0 ? displacing / sum : 0;
}

bool MoveList::changeVolume() const
{
    return any_of(entries.begin(), entries.end(), [](const Entry& entry) {
        return entry.weight > 0 && entry.move->changesVolume();
    });
}

MoveList::Entry& MoveList::draw(double weightSum, RandomNumberGenerator& random)
{
    double position = random.drawUniform() * weightSum;
    size_t lastPossible = 0;
    for (size_t i = 0; i < entries.size(); i++) {
        if (entries[i].weight == 0)
            continue;
        lastPossible = i;
        if (position < entries[i].weight)
            break;
        position -= entries[i].weight;
    }
    return entries[lastPossible];
}

void MoveList::resetStatistics()
{
    for (Entry& entry : entries)
        entry.counts = Counts();
}

// ---- XML ----

static string joinNumbers(const vector<double>& values)
{
    string text;
    for (double value : values)
        text += (text.empty() ? "" : " ") + writeNumber(value);
    return text;
}

static vector<double> splitNumbers(const string& text)
{
    stringstream numbers(text);
    numbers.imbue(locale::classic());
    vector<double> values;
    double value;
    while (numbers >> value)
        values.push_back(value);
    return values;
}

void MoveList::writeMoves(SerializationNode& node) const
{
    for (const Entry& entry : entries) {
        SerializationNode& move = node.createChildNode(entry.move->getKind().element);
        move.setDoubleProperty("weight", entry.weight);
        const vector<double>& scales = entry.move->getScales();
        if (!entry.move->hasEqualScales())
            move.setStringProperty("scales", joinNumbers(scales));
        else if (scales[0] != 1)
            move.setDoubleProperty("scale", scales[0]);
        entry.move->write(move);
    }
}

void MoveList::readMoves(const SerializationNode& node)
{
    for (auto& child : node.getChildren()) {
        const int move = add(MoveKind::find(child.getName()).read(child), child.getDoubleProperty("weight"));
        if (child.hasProperty("scale"))
            setScale(move, child.getDoubleProperty("scale"));
        if (child.hasProperty("scales"))
            setScales(move, splitNumbers(child.getStringProperty("scales")));
    }
}

// ---- Descriptions ----

static string toText(double value)
{
    return writeNumber(value);
}

static string toText(int value)
{
    return to_string(value);
}

/**
 * Write the list of a move's choices.
 */
static string toText(const vector<int>& indices)
{
    string text;
    for (int index : indices)
        text += (text.empty() ? "" : " ") + to_string(index);
    return text.empty() ? "all" : text;
}

/**
 * Write a checksum of many numbers.
 */
static string toText(const vector<double>& values)
{
    return to_string(values.size()) + " numbers with fingerprint " +
           fingerprint(values.data(), values.size() * sizeof(double));
}

MoveList::Description MoveList::describe(const Entry& entry)
{
    Description description = {{"kind", entry.move->getKind().name}, {"weight", toText(entry.weight)}};
    for (const MoveParameter& parameter : entry.move->getParameters()) {
        auto write = [](const auto& value) {
            return toText(value);
        };
        description.push_back({parameter.name, visit(write, parameter.value)});
    }
    return description;
}

/**
 * Throw an exception if a move differs from the move of a checkpoint, and say how.
 */
void MoveList::checkSame(int index, const Description& written, const Description& own)
{
    size_t i = 0, common = min(written.size(), own.size());
    while (i < common && written[i] == own[i])
        i++;
    if (i == common)
        return;
    const size_t longest = 40; // that a message can show
    const string &name = own[i].first, &value = written[i].second, &ownValue = own[i].second;
    bool isShort = (value.size() <= longest && ownValue.size() <= longest);
    fail("the checkpoint is of other moves: move " + to_string(index) + " has " +
         (isShort ? name + " " + value + " in it, but " + ownValue + " here" : "other " + name + " in it than here") +
         "; give this integrator the moves of the checkpoint, and change them after it is loaded");
}

/**
 * Write a number with commas between thousands.
 */
static string toGroupedText(size_t value)
{
    string text = to_string(value);
    for (int i = (int)text.size() - 3; i > 0; i -= 3)
        text.insert(i, ",");
    return text;
}

string MoveList::summarize(int index) const
{
    const Entry& entry = get(index);
    string text = entry.move->summarize() + " (weight " + toText(entry.weight);
    const vector<double>& scales = entry.move->getScales();
    const auto range = minmax_element(scales.begin(), scales.end());
    if (*range.first != 1) {
        stringstream scale;
        scale.imbue(locale::classic());
        scale.precision(3);
        scale << *range.first;
        if (*range.first != *range.second)
            scale << " to " << *range.second;
        text += ", scaled by " + scale.str();
    }
    for (const MoveParameter& parameter : entry.move->getParameters())
        if (auto indices = get_if<vector<int>>(&parameter.value)) {
            const string& plural = parameter.name;
            text += ", ";
            if (indices->empty())
                text += "all " + plural;
            else {
                text += toGroupedText(indices->size()) + " ";
                text += indices->size() == 1 ? plural.substr(0, plural.size() - 1) : plural;
                text += " to choose from";
            }
        }
    return text + ")";
}

// ---- Sizes ----

void MoveList::setScale(int index, double scale)
{
    setScales(index, vector<double>(get(index).move->getScales().size(), scale));
}

void MoveList::setScales(int index, const vector<double>& scales)
{
    const string name = "move " + to_string(index);
    const size_t numClasses = get(index).move->getScales().size();
    if (!get(index).move->hasSize())
        fail(name + " has no size that could be scaled");
    for (double scale : scales)
        if (!(scale > 0 && scale <= 1))
            fail("the scale of " + name + " must be above 0 and at most 1, but is " + toText(scale));
    if (scales.empty() || (structure != NULL && scales.size() != numClasses))
        fail(name + " has " + to_string(numClasses) + " scales, but was given " + to_string(scales.size()));
    Entry& entry = entries[index];
    entry.move->setScales(scales);
    entry.adaptations.clear();
    entry.counts = Counts();
}

void MoveList::restartAdaptation()
{
    for (Entry& entry : entries)
        entry.adaptations.clear();
}

// ---- Checkpoints and States ----

/** The names in States for the parts of a SizeAdaptation::State. */
static const char* const ADAPTATION_NAMES[] = {"adaptationBlocks", "adaptationTrials", "adaptationAccepted"};

/**
 * Get the state of the adaptation of each class of a move's sizes.
 */
vector<SizeAdaptation::State> MoveList::getAdaptations(const Entry& entry)
{
    vector<SizeAdaptation::State> states(entry.move->getScales().size());
    for (size_t i = 0; i < states.size() && i < entry.adaptations.size(); i++)
        states[i] = entry.adaptations[i].getState();
    return states;
}

void MoveList::createCheckpoint(CheckpointWriter& writer) const
{
    writer.write((uint64_t)entries.size());
    for (const Entry& entry : entries) {
        Description description = describe(entry);
        writer.write((uint64_t)description.size());
        for (auto& property : description) {
            writer.write(property.first);
            writer.write(property.second);
        }
        const Counts& counts = entry.counts;
        writer.write(vector<long long>({counts.impossible, counts.clashed, counts.rejectedByEnergy, counts.accepted}));
        const vector<SizeAdaptation::State> adaptations = getAdaptations(entry);
        if (entry.move->hasSizeClasses()) {
            writer.write(entry.move->getScales());
            writer.write(adaptations);
        }
        else {
            writer.write(entry.move->getScale());
            writer.write(adaptations[0]);
        }
    }
}

MoveList::Progress MoveList::readCheckpoint(CheckpointReader& reader) const
{
    uint64_t count = reader.read<uint64_t>();
    if (count != entries.size())
        fail("the checkpoint is of an integrator with " + to_string(count) + " moves, but this one has " +
             to_string(entries.size()));
    Progress progress;
    for (size_t i = 0; i < entries.size(); i++) {
        Description description;
        uint64_t size = reader.read<uint64_t>();
        for (uint64_t j = 0; j < size; j++) {
            string name = reader.readString();
            description.push_back(make_pair(name, reader.readString()));
        }
        checkSame(i, description, describe(entries[i]));
        const vector<long long> counts = reader.readVector<long long>();
        if (counts.size() != 4)
            fail("the checkpoint is damaged");
        MoveProgress move = {{counts[0], counts[1], counts[2], counts[3]}, {}, {}};
        if (entries[i].move->hasSizeClasses()) {
            move.scales = reader.readVector<double>();
            move.adaptations = reader.readVector<SizeAdaptation::State>();
        }
        else {
            move.scales = {reader.read<double>()};
            move.adaptations = {reader.read<SizeAdaptation::State>()};
        }
        if (move.scales.size() != entries[i].move->getScales().size() || move.adaptations.size() != move.scales.size())
            fail("the checkpoint is damaged");
        progress.push_back(move);
    }
    return progress;
}

void MoveList::setProgress(const Progress& progress)
{
    for (size_t i = 0; i < entries.size(); i++) {
        const MoveProgress& read = progress[i];
        entries[i].counts = read.counts;
        entries[i].move->setScales(read.scales);
        entries[i].adaptations.assign(read.adaptations.size(), {});
        for (size_t j = 0; j < read.adaptations.size(); j++)
            entries[i].adaptations[j].setState(read.adaptations[j]);
    }
}

vector<MoveList::Counts> MoveList::getStatistics() const
{
    vector<Counts> statistics;
    for (const Entry& entry : entries)
        statistics.push_back(entry.counts);
    return statistics;
}

void MoveList::setStatistics(const vector<Counts>& statistics)
{
    for (size_t i = 0; i < entries.size(); i++)
        entries[i].counts = statistics[i];
}

/**
 * Write the scale and the state of the adaptation of a class of sizes.
 */
static void writeSize(SerializationNode& node, double scale, const SizeAdaptation::State& adaptation)
{
    setNumber(node, "scale", scale);
    for (size_t i = 0; i < adaptation.size(); i++)
        node.setLongProperty(ADAPTATION_NAMES[i], adaptation[i]);
}

void MoveList::writeProgress(SerializationNode& node) const
{
    for (const Entry& entry : entries) {
        SerializationNode& move = node.createChildNode("Move");
        for (auto& property : describe(entry))
            move.setStringProperty(property.first, property.second);
        move.setLongProperty("refused", entry.counts.impossible)
            .setLongProperty("clashed", entry.counts.clashed)
            .setLongProperty("rejectedByEnergy", entry.counts.rejectedByEnergy)
            .setLongProperty("accepted", entry.counts.accepted);
        const vector<SizeAdaptation::State> adaptations = getAdaptations(entry);
        writeSize(move, entry.move->getScale(), adaptations[0]);
        for (size_t i = 1; i < adaptations.size(); i++)
            writeSize(move.createChildNode("Size"), entry.move->getScale(i), adaptations[i]);
    }
}

static void readSize(const SerializationNode& node, MoveList::MoveProgress& progress)
{
    progress.scales.push_back(node.hasProperty("scale") ? getNumber(node, "scale") : 1);
    SizeAdaptation::State state;
    for (size_t i = 0; i < state.size(); i++)
        state[i] = node.getLongProperty(ADAPTATION_NAMES[i], 0);
    progress.adaptations.push_back(state);
}

bool MoveList::readProgress(const SerializationNode& node, Progress& progress) const
{
    const vector<SerializationNode>& moves = node.getChildren();
    if (moves.size() != entries.size())
        return false;
    for (size_t i = 0; i < entries.size(); i++)
        if (moves[i].getChildren().size() + 1 != entries[i].move->getScales().size())
            return false;
    for (size_t i = 0; i < entries.size(); i++)
        for (auto& property : describe(entries[i]))
            if (moves[i].getStringProperty(property.first, "") != property.second)
                return false;
    for (const SerializationNode& move : moves) {
        // States of former versions have neither impossible trials nor scales.

        MoveProgress read = {{move.getLongProperty("refused", 0), move.getLongProperty("clashed"),
                              move.getLongProperty("rejectedByEnergy"), move.getLongProperty("accepted")},
                             {},
                             {}};
        readSize(move, read);
        for (const SerializationNode& size : move.getChildren())
            readSize(size, read);
        progress.push_back(read);
    }
    return true;
}
