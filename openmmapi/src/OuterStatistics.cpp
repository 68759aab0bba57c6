#include "openmmchaintree/internal/OuterStatistics.h"
#include "openmmchaintree/internal/StateNumber.h"
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

OuterStatistics::OuterStatistics() :
    attempted(0), accepted(0), trialsTakenBack(0), numDifferences(0), mean(0), squares(0)
{
}

void OuterStatistics::add(double difference)
{
    numDifferences++;
    const double fromFormerMean = difference - mean;
    mean += fromFormerMean / numDifferences;
    squares += fromFormerMean * (difference - mean);
}

double OuterStatistics::getStandardDeviation() const
{
    return numDifferences < 2 ? 0 : sqrt(squares / (numDifferences - 1));
}

void OuterStatistics::write(CheckpointWriter& writer) const
{
    writer.write(*this);
}

void OuterStatistics::read(CheckpointReader& reader)
{
    *this = reader.read<OuterStatistics>();
}

void OuterStatistics::write(SerializationNode& node) const
{
    node.setLongProperty("attempted", attempted)
        .setLongProperty("accepted", accepted)
        .setLongProperty("trialsTakenBack", trialsTakenBack)
        .setLongProperty("numDifferences", numDifferences);
    setNumber(node, "mean", mean);
    setNumber(node, "squares", squares);
}

void OuterStatistics::read(const SerializationNode& node)
{
    attempted = node.getLongProperty("attempted");
    accepted = node.getLongProperty("accepted");
    trialsTakenBack = node.getLongProperty("trialsTakenBack");
    numDifferences = node.getLongProperty("numDifferences");
    mean = getNumber(node, "mean");
    squares = getNumber(node, "squares");
}
