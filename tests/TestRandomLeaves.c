/* Leaves in random scenes and programs: positions, pieces, and pairs of leaves, against brute force over all particles.
 * What is kept from state to state has the bits of a scene that is made from the state, after ctRenew or if there is
 * one molecule. Every instruction set gives the same bits. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chaintree.h"
#include "oracle/randomScene.h"
#include "sceneDefinition.h"

enum { SCENES = 60, OPERATIONS = 16, MOST_CHANGES = 5, FEW_PARTICLES = 800 };

static int failures;

#define EXPECT(condition)                                                                                              \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);                                                     \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

/* A scene, and what brute force knows of it. */
typedef struct Case {
    randomScene scene;
    unsigned char* flags; /* per particle: listed in the definition; or NULL */
    randomSource random;
    ctChainTree* tree;
    int leafCount;
    int* particles;        /* per slot */
    double* state;         /* positions of all particles */
    double* trial;         /* the same */
    int* body;             /* per slot, in the open trial */
    unsigned char* listed; /* leafCount * leafCount */
    double tolerance;      /* of positions */
    int isExact;           /* what is kept has the bits of a scene that is made from the state */
    int isRenewed;         /* ctRenew is called in each state */
    uint64_t hash;         /* of all answers */
} Case;

static void* allocate(size_t count, size_t size)
{
    void* memory = calloc(count + 1, size);
    if (memory == NULL)
        abort();
    return memory;
}

static void addToHash(Case* c, const void* data, size_t size)
{
    const unsigned char* bytes = data;
    for (size_t i = 0; i < size; i++)
        c->hash = (c->hash ^ bytes[i]) * 0x100000001b3u;
}

static ctChainTree* createTree(const randomScene* scene, const unsigned char* listed)
{
    const ctDefinition definition = defineScene(scene, listed);
    return createDefined(&definition);
}

/* ---- Positions ---- */

static void leafPoint(const ctLeafPositions* leaves, int slot, double x[3])
{
    x[0] = leaves[slot / CT_LEAF_WIDTH].x[slot % CT_LEAF_WIDTH];
    x[1] = leaves[slot / CT_LEAF_WIDTH].y[slot % CT_LEAF_WIDTH];
    x[2] = leaves[slot / CT_LEAF_WIDTH].z[slot % CT_LEAF_WIDTH];
}

/* Whether a leaf has these positions of particles, and 0 in empty slots. */
static int hasPositions(const Case* c, const ctLeafPositions* leaves, int leaf, const double* positions)
{
    for (int slot = leaf * CT_LEAF_WIDTH; slot < (leaf + 1) * CT_LEAF_WIDTH; slot++) {
        double x[3];
        leafPoint(leaves, slot, x);
        for (int d = 0; d < 3; d++) {
            int particle = c->particles[slot];
            double expected = particle < 0 ? 0 : positions[3 * particle + d];
            if (!(fabs(x[d] - expected) <= (particle < 0 ? 0 : c->tolerance)))
                return 0;
        }
    }
    return 1;
}

static double squaredDistance(const double* positions, int i, int j)
{
    double sum = 0;
    for (int d = 0; d < 3; d++)
        sum += (positions[3 * i + d] - positions[3 * j + d]) * (positions[3 * i + d] - positions[3 * j + d]);
    return sum;
}

/* The squared gap of the boxes around two leaves' particles; negative: one has none. */
static double squaredGap(const Case* c, int a, int b, const double* positions)
{
    double low[2][3], high[2][3];
    int leaf[2] = {a, b};
    for (int n = 0; n < 2; n++) {
        int count = 0;
        for (int slot = leaf[n] * CT_LEAF_WIDTH; slot < (leaf[n] + 1) * CT_LEAF_WIDTH; slot++) {
            if (c->particles[slot] < 0)
                continue;
            const double* x = positions + 3 * c->particles[slot];
            for (int d = 0; d < 3; d++) {
                low[n][d] = count == 0 || x[d] < low[n][d] ? x[d] : low[n][d];
                high[n][d] = count == 0 || x[d] > high[n][d] ? x[d] : high[n][d];
            }
            count++;
        }
        if (count == 0)
            return -1;
    }
    double sum = 0;
    for (int d = 0; d < 3; d++) {
        double gap = fmax(fmax(low[0][d] - high[1][d], low[1][d] - high[0][d]), 0);
        sum += gap * gap;
    }
    return sum;
}

/* ---- Pairs ---- */

/* Whether some particles of two leaves are of different bodies. */
static int areOfTwoBodies(const Case* c, int a, int b)
{
    for (int i = a * CT_LEAF_WIDTH; i < (a + 1) * CT_LEAF_WIDTH; i++)
        for (int j = b * CT_LEAF_WIDTH; j < (b + 1) * CT_LEAF_WIDTH; j++)
            if (c->particles[i] >= 0 && c->particles[j] >= 0 && c->body[i] != c->body[j])
                return 1;
    return 0;
}

/* No particle is farther from the middle of the reference positions, of which particle 0 is within the extent. */
static double farthest(const Case* c, const double* trial)
{
    double most = 0;
    for (int i = 0; i < 3 * c->scene.particleCount; i++) {
        most = fmax(most, fabs(c->state[i] - c->scene.positions[i % 3]));
        most = fmax(most, fabs(trial[i] - c->scene.positions[i % 3]));
    }
    return 2 * most + c->scene.extent;
}

/* Compares listed pairs with all that there are. In the state, `trial` is the state. */
static void checkPairs(Case* c, double cutoff, size_t count, const ctLeafPair* pairs, int inTrial)
{
    size_t leaves = (size_t)c->leafCount;
    const double* trial = inTrial ? c->trial : c->state;
    const double rounding = 1e-6 * farthest(c, trial) + c->tolerance;
    memset(c->listed, 0, leaves * leaves);
    for (size_t i = 0; i < count; i++) {
        EXPECT(0 <= pairs[i].a && pairs[i].a <= pairs[i].b && pairs[i].b < c->leafCount);
        unsigned char* listed = &c->listed[(size_t)pairs[i].a * leaves + (size_t)pairs[i].b];
        EXPECT(*listed == 0); /* each once */
        *listed = 1;
        double before = squaredGap(c, pairs[i].a, pairs[i].b, c->state);
        double gap = fmin(before, squaredGap(c, pairs[i].a, pairs[i].b, trial));
        double error = 1e-5 * sqrt(gap) + rounding;
        EXPECT(gap >= 0 && fabs(sqrt((double)pairs[i].squaredGap) - sqrt(gap)) <= error);
        EXPECT(pairs[i].a != pairs[i].b || pairs[i].squaredGap == 0);
        EXPECT(sqrt(gap) <= cutoff + error);
        EXPECT(!inTrial || areOfTwoBodies(c, pairs[i].a, pairs[i].b));
    }
    for (int a = 0; a < c->leafCount; a++)
        for (int b = a; b < c->leafCount; b++) {
            if (c->listed[(size_t)a * leaves + (size_t)b])
                continue;
            double gap = fmin(squaredGap(c, a, b, c->state), squaredGap(c, a, b, trial));
            EXPECT(gap < 0 || gap > cutoff * cutoff || (inTrial && !areOfTwoBodies(c, a, b)));
        }
    /* Particles: without boxes and bodies. */
    for (int i = 0; i < c->leafCount * CT_LEAF_WIDTH; i++)
        for (int j = i + 1; j < c->leafCount * CT_LEAF_WIDTH; j++) {
            if (c->particles[i] < 0 || c->particles[j] < 0 ||
                c->listed[(size_t)(i / CT_LEAF_WIDTH) * leaves + (size_t)(j / CT_LEAF_WIDTH)])
                continue;
            double before = squaredDistance(c->state, c->particles[i], c->particles[j]);
            double after = squaredDistance(trial, c->particles[i], c->particles[j]);
            int keepsDistance = inTrial && fabs(sqrt(before) - sqrt(after)) <= 8 * c->tolerance;
            EXPECT(keepsDistance || (before > cutoff * cutoff && after > cutoff * cutoff));
        }
}

static int hasPairs(size_t count, const ctLeafPair* pairs, size_t otherCount, const ctLeafPair* otherPairs)
{
    return count == otherCount && (count == 0 || memcmp(pairs, otherPairs, count * sizeof *pairs) == 0);
}

/* ---- Checks of a state and a trial ---- */

static double chooseCutoff(Case* c)
{
    static const double cutoffs[] = {1e-3, 0.2, 0.5, 1.0, 3.0};
    return randomChance(&c->random, 0.2) ? INFINITY : cutoffs[randomInt(&c->random, 5)];
}

/* Whether there are molecules that stay where they are while another moves: those keep the bits of their positions,
 * which a new scene computes from other frames. */
static int hasMolecules(const randomScene* scene)
{
    int molecules = 0;
    for (int link = 0; link < scene->linkCount; link++)
        molecules += scene->linkParents[link] == CT_NULL;
    return molecules > 1;
}

static void checkState(Case* c, ctChainTree* rebuilt)
{
    if (c->isRenewed)
        ctRenew(c->tree);
    const ctLeafPositions* leaves = ctGetLeaves(c->tree);
    const ctLeafPositions* others = ctGetLeaves(rebuilt);
    size_t size = (size_t)c->leafCount * sizeof(ctLeafPositions);
    ctGetPositions(c->tree, c->state);
    for (int leaf = 0; leaf < c->leafCount; leaf++)
        EXPECT(hasPositions(c, leaves, leaf, c->state));
    EXPECT(!c->isExact || memcmp(leaves, others, size) == 0);
    addToHash(c, leaves, size);
    if (!randomChance(&c->random, 0.3))
        return;
    double cutoff = chooseCutoff(c);
    size_t count, otherCount;
    const ctLeafPair *pairs, *otherPairs;
    EXPECT(ctGetLeafPairs(c->tree, cutoff, &count, &pairs, NULL) == ctSuccess);
    EXPECT(ctGetLeafPairs(rebuilt, cutoff, &otherCount, &otherPairs, NULL) == ctSuccess);
    checkPairs(c, cutoff, count, pairs, 0);
    EXPECT(!c->isExact || hasPairs(count, pairs, otherCount, otherPairs));
    if (count > 0)
        addToHash(c, pairs, count * sizeof *pairs);
}

/* Reads the bodies of slots, and checks that motions take the state to the trial. */
static void checkPieces(Case* c)
{
    const ctPiece* pieces;
    const ctTransform* motions;
    int count = ctGetTrialPieces(c->tree, &pieces, &motions);
    const ctLeafPositions* leaves = ctGetLeaves(c->tree);
    EXPECT(count > 0 && pieces[0].slotBegin == 0);
    for (int slot = 0, piece = 0; slot < c->leafCount * CT_LEAF_WIDTH; slot++) {
        if (piece + 1 < count && pieces[piece + 1].slotBegin <= slot)
            EXPECT(pieces[++piece].slotBegin == slot);
        c->body[slot] = pieces[piece].body;
        if (c->particles[slot] < 0)
            continue;
        double x[3];
        leafPoint(leaves, slot, x);
        const ctTransform* motion = &motions[c->body[slot]];
        for (int d = 0; d < 3; d++) {
            const double* r = motion->rotation + 3 * d;
            double moved = r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + motion->translation[d];
            EXPECT(fabs(moved - c->trial[3 * c->particles[slot] + d]) <= c->tolerance);
            EXPECT(c->body[slot] != 0 || moved == x[d]);
        }
    }
}

/* Changes of links, or displacements of particles. */
typedef struct Proposal {
    int changeCount, displacementCount;
    ctChange changes[MOST_CHANGES];
    ctDisplacement displacements[MOST_CHANGES];
} Proposal;

static ctStatus propose(ctChainTree* tree, const Proposal* proposal)
{
    return proposal->displacementCount > 0
               ? ctProposeDisplacements(tree, proposal->displacementCount, proposal->displacements)
               : ctPropose(tree, proposal->changeCount, proposal->changes);
}

static int countOf(int value, int count, const int* values)
{
    int times = 0;
    for (int i = 0; i < count; i++)
        times += values[i] == value;
    return times;
}

/* The trial changes these links, or displaces these particles. */
static void checkContents(Case* c, const Proposal* proposal)
{
    const int *links, *particles;
    EXPECT(ctGetTrialLinks(c->tree, &links) == proposal->changeCount);
    EXPECT(ctGetTrialParticles(c->tree, &particles) == proposal->displacementCount);
    for (int i = 0; i < proposal->changeCount; i++)
        EXPECT(countOf(proposal->changes[i].link, proposal->changeCount, links) == 1);
    for (int i = 0; i < proposal->displacementCount; i++)
        EXPECT(countOf(proposal->displacements[i].particle, proposal->displacementCount, particles) == 1);
}

static void checkTrial(Case* c, ctChainTree* rebuilt, const Proposal* proposal)
{
    double cutoff = chooseCutoff(c);
    EXPECT(ctGetTrialPositions(c->tree, c->trial) == ctSuccess);
    ctGetPositions(c->tree, c->state);
    checkContents(c, proposal);
    checkPieces(c);
    for (int calls = 1 + randomInt(&c->random, 2); calls > 0; calls--) {
        size_t count, otherCount;
        const ctLeafPair *pairs, *otherPairs;
        const ctLeafPositions *positions, *otherPositions;
        EXPECT(ctGetChangedLeafPairs(c->tree, cutoff, &count, &pairs, &positions, NULL) == ctSuccess);
        EXPECT(propose(rebuilt, proposal) == ctSuccess);
        EXPECT(ctGetChangedLeafPairs(rebuilt, cutoff, &otherCount, &otherPairs, &otherPositions, NULL) == ctSuccess);
        checkPairs(c, cutoff, count, pairs, 1);
        EXPECT(!c->isExact || hasPairs(count, pairs, otherCount, otherPairs));
        for (size_t i = 0; i < count; i++)
            for (int n = 0; n < 2; n++) {
                int leaf = n == 0 ? pairs[i].a : pairs[i].b;
                EXPECT(hasPositions(c, positions, leaf, c->trial));
                EXPECT(!c->isExact || memcmp(&positions[leaf], &otherPositions[leaf], sizeof *positions) == 0);
                addToHash(c, &positions[leaf], sizeof *positions);
            }
        if (count > 0)
            addToHash(c, pairs, count * sizeof *pairs);
        cutoff = chooseCutoff(c);
    }
    ctReject(rebuilt);
}

/* ---- Programs ---- */

static int chooseDisplacements(Case* c, ctDisplacement* displacements)
{
    int count = 0;
    for (int tries = 1 + randomInt(&c->random, MOST_CHANGES); tries > 0; tries--) {
        const int particle = randomInt(&c->random, c->scene.particleCount);
        int isNew = c->scene.linkJoints[c->scene.particleLinks[particle]] != ctFixedJoint;
        for (int i = 0; i < count; i++)
            isNew = isNew && displacements[i].particle != particle;
        if (!isNew)
            continue;
        const double size = randomChance(&c->random, 0.5) ? 0.1 : 1.0;
        displacements[count].particle = particle;
        const int isAsBefore = count > 0 && randomChance(&c->random, 0.4);
        for (int d = 0; d < 3; d++) {
            const double own = randomReal(&c->random, -size, size);
            displacements[count].shift[d] = isAsBefore ? displacements[count - 1].shift[d] : own;
        }
        count++;
    }
    return count;
}

static int chooseChanges(Case* c, ctChange* changes)
{
    int count = 0;
    for (int tries = 1 + randomInt(&c->random, MOST_CHANGES); tries > 0; tries--) {
        int link = randomInt(&c->random, c->scene.linkCount);
        int isNew = c->scene.linkJoints[link] != ctFixedJoint;
        for (int i = 0; i < count; i++)
            isNew = isNew && changes[i].link != link;
        if (!isNew)
            continue;
        ctChange change = {0};
        double size = randomChance(&c->random, 0.5) ? 0.1 : 3.0;
        change.link = link;
        change.angle = randomReal(&c->random, -size, size);
        for (int d = 0; d < 3; d++) {
            change.rotation[d] = randomReal(&c->random, -size, size);
            change.pivot[d] = c->scene.positions[d];
            change.translation[d] = randomReal(&c->random, -size, size);
        }
        changes[count++] = change;
    }
    return count;
}

static ctChainTree* rebuild(Case* c)
{
    ctChainTree* tree = createTree(&c->scene, c->flags);
    double* state = allocate(ctGetStateSize(c->tree), sizeof(double));
    ctGetState(c->tree, state);
    EXPECT(ctSetState(tree, state) == ctSuccess);
    free(state);
    return tree;
}

static void newState(Case* c)
{
    double* state = allocate(ctGetStateSize(c->tree), sizeof(double));
    if (randomChance(&c->random, 0.5)) {
        ctGetPositions(c->tree, c->state);
        for (int i = 0; i < 3 * c->scene.particleCount; i++)
            c->state[i] += randomReal(&c->random, -0.01, 0.01);
        EXPECT(ctSetPositions(c->tree, c->state) == ctSuccess);
    }
    else {
        ctGetState(c->tree, state);
        EXPECT(ctSetState(c->tree, state) == ctSuccess);
    }
    free(state);
}

static void runProgram(Case* c, int operations)
{
    for (int n = 0; n < operations; n++) {
        int64_t before, after;
        int changesState = 0;
        before = ctGetChangeCount(c->tree);
        ctChainTree* rebuilt = rebuild(c);
        checkState(c, rebuilt);
        if (randomChance(&c->random, 0.15)) {
            newState(c);
            changesState = 1;
        }
        else {
            Proposal proposal = {0};
            if (c->scene.isFlexible && randomChance(&c->random, 0.5))
                proposal.displacementCount = chooseDisplacements(c, proposal.displacements);
            else
                proposal.changeCount = chooseChanges(c, proposal.changes);
            int clash;
            bool isClash;
            EXPECT(propose(c->tree, &proposal) == ctSuccess);
            if (randomChance(&c->random, 0.3))
                EXPECT(ctTestTrial(c->tree, &isClash, NULL, NULL) == ctSuccess);
            if (randomChance(&c->random, 0.9))
                checkTrial(c, rebuilt, &proposal);
            clash = randomInt(&c->random, 3);
            if (clash == 0)
                ctReject(c->tree);
            else if (clash == 1)
                EXPECT(ctAccept(c->tree, NULL) == ctSuccess);
            changesState = clash == 1;
        }
        ctDestroy(rebuilt);
        after = ctGetChangeCount(c->tree);
        EXPECT(changesState ? after > before : after == before);
    }
}

/* Particles with a radius, and listed ones, have one slot each. */
static void checkSlots(const Case* c)
{
    int* slots = allocate((size_t)c->scene.particleCount, sizeof(int));
    for (int slot = 0; slot < c->leafCount * CT_LEAF_WIDTH; slot++)
        if (c->particles[slot] != CT_NULL)
            slots[c->particles[slot]]++;
    for (int i = 0; i < c->scene.particleCount; i++)
        EXPECT(slots[i] == (c->scene.radii[i] > 0 || (c->flags != NULL && c->flags[i])));
    free(slots);
}

static uint64_t runScene(int seed)
{
    Case c = {.random = randomSourceFromSeed((uint64_t)seed), .hash = 0xcbf29ce484222325u};
    randomSceneCreate(&c.scene, &c.random);
    if (randomChance(&c.random, 0.7)) {
        double chance = randomChance(&c.random, 0.5) ? 1 : 0.5;
        c.flags = allocate((size_t)c.scene.particleCount, 1);
        for (int i = 0; i < c.scene.particleCount; i++)
            c.flags[i] = randomChance(&c.random, chance);
    }
    c.isRenewed = randomChance(&c.random, 0.5);
    c.isExact = c.isRenewed || !hasMolecules(&c.scene);
    c.tree = createTree(&c.scene, c.flags);
    c.leafCount = ctGetLeafCount(c.tree);
    size_t slots = (size_t)c.leafCount * CT_LEAF_WIDTH, coordinates = 3 * (size_t)c.scene.particleCount;
    c.particles = allocate(slots, sizeof(int));
    c.body = allocate(slots, sizeof(int));
    c.state = allocate(coordinates, sizeof(double));
    c.trial = allocate(coordinates, sizeof(double));
    c.listed = allocate((size_t)c.leafCount * (size_t)c.leafCount, 1);
    ctGetLeafParticles(c.tree, c.particles);
    checkSlots(&c);
    double size = c.scene.extent + 100;
    for (int d = 0; d < 3; d++)
        size += fabs(c.scene.positions[d]);
    c.tolerance = 1e-14 * size; /* 1e-12 for the usual scene of 100 nm */
    runProgram(&c, c.scene.particleCount > FEW_PARTICLES ? 2 : OPERATIONS);
    ctDestroy(c.tree);
    free(c.flags);
    free(c.particles);
    free(c.body);
    free(c.state);
    free(c.trial);
    free(c.listed);
    randomSceneDestroy(&c.scene);
    return c.hash;
}

int main(void)
{
    static const char* sets[] = {"portable", "avx2", "avx512"};
    static uint64_t hashes[SCENES];
    for (int set = 0; set < 3; set++) {
        setenv("CHAINTREE_SIMD", sets[set], 1);
        for (int seed = 0; seed < SCENES && failures < 20; seed++) {
            int before = failures;
            uint64_t hash = runScene(seed);
            EXPECT(set == 0 || hash == hashes[seed]);
            hashes[seed] = hash;
            if (failures > before)
                printf("scene %d, %s\n", seed, sets[set]);
        }
    }
    return failures > 0;
}
