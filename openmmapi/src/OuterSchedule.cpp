#include "openmmchaintree/internal/OuterSchedule.h"
#include <algorithm>
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace std;

/** The numbers of trials to a test, in the order in which they are tried. With fewer, a test saves less than it
 *  costs. */
static const vector<int> TRIALS = {12, 25, 50, 100, 200, 400};

/** The number of measured tests for each number of trials. It gives the acceptance within a tenth. */
static const int TESTS_PER_ROUND = 20;

static const double LEAST_ACCEPTANCE = 0.5;

void OuterSchedule::Spread::add(double change)
{
    count++;
    acceptance += ((isfinite(change) ? min(1.0, exp(-change)) : 0) - acceptance) / count;
    acceptanceBack += ((isfinite(change) ? min(1.0, exp(change)) : 0) - acceptanceBack) / count;
}

bool OuterSchedule::Spread::isSmall() const
{
    // In equilibrium the opposite changes are accepted more often; while the energy still falls, they are not.

    return acceptance > LEAST_ACCEPTANCE && acceptanceBack > LEAST_ACCEPTANCE;
}

OuterSchedule::OuterSchedule() : measuring(false), level(0), trials(0)
{
}

void OuterSchedule::restart()
{
    measuring = !energies.empty();
    level = 0;
    left.assign(energies.size(), 1);
    beginRound();
}

void OuterSchedule::beginRound()
{
    spreads.assign(energies.size(), Spread());
    whole = Spread();
}

void OuterSchedule::begin(const vector<int>& energies, int longest)
{
    if (energies != this->energies) {
        this->energies = energies;
        restart();
    }
    if (!measuring)
        return;
    if (whole.count >= TESTS_PER_ROUND) {
        endRound(longest);
        beginRound();
    }
    trials = min(TRIALS[level], longest);
}

/**
 * Choose the next number of trials by the measurements with the present one.
 */
void OuterSchedule::endRound(int longest)
{
    if (!whole.isSmall() && level == 0)
        leaveOutLargest();
    else if (!whole.isSmall()) {
        level--;
        measuring = false;
    }
    else if (TRIALS[level] >= longest || level + 1 == (int)TRIALS.size())
        measuring = false;
    else
        level++;
}

/**
 * Let the energies that change too much, or the one that changes most, decide each trial.
 */
void OuterSchedule::leaveOutLargest()
{
    vector<int> candidates;
    for (size_t i = 0; i < energies.size(); i++)
        if (left[i])
            candidates.push_back(i);
    const int largest = *min_element(candidates.begin(), candidates.end(), [&](int i, int j) {
        return spreads[i].getLeastAcceptance() < spreads[j].getLeastAcceptance();
    });
    for (int i : candidates)
        if (i == largest || !spreads[i].isSmall())
            left[i] = 0;
    measuring = any_of(left.begin(), left.end(), [](char isLeft) {
        return isLeft;
    });
}

void OuterSchedule::add(const vector<double>& changes, double change)
{
    for (size_t i = 0; i < energies.size(); i++)
        if (left[i])
            spreads[i].add(changes[i]);
    whole.add(change);
}

// ---- Checkpoints ----

vector<double> OuterSchedule::getNumbers() const
{
    if (energies.empty())
        return {};
    vector<double> numbers = {(double)measuring, (double)level, (double)trials, (double)energies.size()};
    auto write = [&](const Spread& spread) {
        numbers.insert(numbers.end(), {spread.count, spread.acceptance, spread.acceptanceBack});
    };
    for (size_t i = 0; i < energies.size(); i++) {
        numbers.insert(numbers.end(), {(double)energies[i], (double)left[i]});
        write(spreads[i]);
    }
    write(whole);
    return numbers;
}

void OuterSchedule::setNumbers(const vector<double>& numbers)
{
    *this = OuterSchedule();
    const size_t NUM_FIRST = 4, NUM_EACH = 5, NUM_LAST = 3;
    if (numbers.size() < NUM_FIRST + NUM_LAST || (numbers.size() - NUM_FIRST - NUM_LAST) % NUM_EACH != 0 ||
        numbers[3] != (numbers.size() - NUM_FIRST - NUM_LAST) / NUM_EACH ||
        !(numbers[1] >= 0 && numbers[1] < TRIALS.size()) || !(numbers[2] >= 0 && numbers[2] <= TRIALS.back()))
        return;
    measuring = numbers[0] != 0;
    level = numbers[1];
    trials = numbers[2];
    const double* next = &numbers[NUM_FIRST];
    auto read = [&](Spread& spread) {
        spread.count = *next++;
        spread.acceptance = *next++;
        spread.acceptanceBack = *next++;
    };
    for (int i = 0; i < numbers[3]; i++) {
        if (!(next[0] >= 0 && next[0] <= numeric_limits<int>::max())) {
            *this = OuterSchedule();
            return;
        }
        energies.push_back(*next++);
        left.push_back(*next++ != 0);
        spreads.push_back(Spread());
        read(spreads.back());
    }
    read(whole);
}
