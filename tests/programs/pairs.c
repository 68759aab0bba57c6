#include "pairs.h"

#include <stdlib.h>

void appendPair(PairList* list, int particle1, int particle2, double value1, double value2)
{
    if (list->count == list->room) {
        list->room = 2 * list->room + 64;
        list->pairs = realloc(list->pairs, (size_t)list->room * sizeof(Pair));
        if (list->pairs == NULL)
            abort();
    }
    list->pairs[list->count++] = (Pair){{particle1, particle2}, {value1, value2}};
}

int comparePairs(const void* a, const void* b)
{
    const int *x = ((const Pair*)a)->particles, *y = ((const Pair*)b)->particles;
    return x[0] != y[0] ? (x[0] > y[0]) - (x[0] < y[0]) : (x[1] > y[1]) - (x[1] < y[1]);
}

/* Sorts by one of the two particles; what has the same one stays in order. Lists are long, and a qsort of them was a
 * third of all that random programs take. */
static void sortByParticle(PairList* list, int which)
{
    int end = 0;
    for (int n = 0; n < list->count; n++)
        end = list->pairs[n].particles[which] >= end ? list->pairs[n].particles[which] + 1 : end;
    int* begin = calloc((size_t)end + 1, sizeof(int));
    Pair* sorted = malloc((size_t)list->room * sizeof(Pair));
    if (begin == NULL || sorted == NULL)
        abort();
    for (int n = 0; n < list->count; n++)
        begin[list->pairs[n].particles[which] + 1]++;
    for (int particle = 0; particle < end; particle++)
        begin[particle + 1] += begin[particle];
    for (int n = 0; n < list->count; n++)
        sorted[begin[list->pairs[n].particles[which]]++] = list->pairs[n];
    free(begin);
    free(list->pairs);
    list->pairs = sorted;
}

const Pair* sortPairs(PairList* list)
{
    bool isSorted = true;
    for (int n = 1; n < list->count && isSorted; n++)
        isSorted = comparePairs(list->pairs + n - 1, list->pairs + n) <= 0;
    for (int which = 1; which >= 0 && !isSorted; which--)
        sortByParticle(list, which);
    for (int n = 1; n < list->count; n++)
        if (comparePairs(list->pairs + n - 1, list->pairs + n) == 0)
            return list->pairs + n;
    return NULL;
}

const Pair* findPair(const PairList* list, int particle1, int particle2)
{
    const Pair key = {{particle1, particle2}, {0, 0}};
    return list->count == 0 ? NULL : bsearch(&key, list->pairs, (size_t)list->count, sizeof(Pair), comparePairs);
}

bool collectPair(void* list, int particle1, int particle2, double value)
{
    return collectChangedPair(list, particle1, particle2, value, 0);
}

bool collectChangedPair(void* list, int particle1, int particle2, double before, double after)
{
    PairList* pairs = list;
    appendPair(pairs, particle1, particle2, before, after);
    return pairs->count != pairs->end;
}

bool collectParticle(void* list, int particle, double overlap)
{
    return collectPair(list, particle, particle, overlap);
}
