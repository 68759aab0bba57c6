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

const Pair* sortPairs(PairList* list)
{
    if (list->count > 1)
        qsort(list->pairs, (size_t)list->count, sizeof(Pair), comparePairs);
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
