/* Handles in different threads have nothing to do with each other: random programs at the same time, each in a thread,
 * and each in another one after a while.
 *
 * Usage: TestThreads [operations in each thread]. The thread sanitizer sees more than the answers tell.
 */
#include "programs/operations.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { THREADS = 4 };

static const int defaultOperationCount = 10000;
static const int operationsAProgram = 200;
static const uint64_t firstSeed = 42000000;

typedef struct Worker {
    pthread_t thread;
    Program program;
    char name[40];
    Tally tally;
} Worker;

static void* runHalf(void* argument)
{
    Worker* worker = argument;
    runOperations(&worker->program, operationsAProgram / 2);
    return NULL;
}

static void makeProgram(Worker* worker, uint64_t seed)
{
    snprintf(worker->name, sizeof worker->name, "seed %llu", (unsigned long long)seed);
    randomSource random = randomSourceFromSeed(seed);
    randomScene scene;
    randomSceneCreate(&scene, &random);
    programCreate(&worker->program, worker->name, scene, random, false, &worker->tally);
}

static void runAll(Worker* workers)
{
    for (int n = 0; n < THREADS; n++)
        if (pthread_create(&workers[n].thread, NULL, runHalf, &workers[n]) != 0)
            abort();
    for (int n = 0; n < THREADS; n++)
        pthread_join(workers[n].thread, NULL);
}

int main(int argumentCount, char** arguments)
{
    static Worker workers[THREADS];
    int wanted = argumentCount > 1 ? atoi(arguments[1]) : defaultOperationCount;
    uint64_t seed = firstSeed;
    for (int done = 0; done < wanted; done += operationsAProgram) {
        for (int n = 0; n < THREADS; n++)
            makeProgram(&workers[n], seed++);
        runAll(workers);
        runAll(workers);
        for (int n = 0; n < THREADS; n++)
            programDestroy(&workers[n].program);
    }
    for (int n = 0; n < THREADS; n++) {
        printf("thread %d: ", n);
        printTally(&workers[n].tally);
    }
    return 0;
}
