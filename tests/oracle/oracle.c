#include "oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef long double real;

typedef struct vec {
    real x, y, z;
} vec;

/* Coordinates in double are this near (nm, per nm of coordinate) to those in long double, with much to spare. */
static const double screenMargin = 1e-6;

/* A rigid motion in the positions before the trial: x -> center + R (x - center) + shift. */
typedef struct motion {
    real rotation[9];
    vec center, shift;
} motion;

typedef struct limitedPair {
    int pair[2];
    real limit;
} limitedPair;

struct oracleScene {
    int particleCount, linkCount;
    vec* reference;
    vec* positions[2]; /* of the state and of the trial */
    double* radii;
    unsigned char* roles;
    int* particleLinks;
    int* linkParents;
    unsigned char* linkJoints;
    int* linkTorsions;
    int* linkOrder;  /* all links, parents first */
    vec* axes[2];    /* 4 points a link that move with it: origin of its frame, and one a unit along each axis */
    real* turns[2];  /* a link, since the reference positions */
    int* changed;    /* a link: the nearest link that the trial changes, from itself upward, or -1 */
    motion* motions; /* a link that the trial changes */
    int isFlexible;
    int* displaced; /* a particle: the first one that the trial displaces by the same shift, or -1 */
    int exclusionCount;
    int* exclusions; /* sorted, particle1 < particle2 */
    int limitCount;
    limitedPair* limits; /* sorted */
    double overlapTolerance, hydrogenBondAllowance;
};

/* ---- Memory ---- */

static void* allocate(int count, size_t size)
{
    void* memory = calloc(count > 0 ? (size_t)count : 1, size);
    if (memory == NULL)
        abort();
    return memory;
}

static void* duplicate(const void* source, int count, size_t size)
{
    void* memory = allocate(count, size);
    if (count > 0 && source != NULL)
        memcpy(memory, source, (size_t)count * size);
    return memory;
}

/* ---- Vectors ---- */

static vec add(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static vec subtract(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vec scale(vec a, real s)
{
    return (vec){a.x * s, a.y * s, a.z * s};
}

static real dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static real length(vec a)
{
    return sqrtl(dot(a, a));
}

static vec vecFromDoubles(const double* x)
{
    return (vec){x[0], x[1], x[2]};
}

static void vecToDoubles(vec a, double* x)
{
    x[0] = (double)a.x;
    x[1] = (double)a.y;
    x[2] = (double)a.z;
}

/* ---- Motions ---- */

/* Rodrigues: the right-handed rotation by an angle about an axis of any length. */
static void setRotation(motion* m, vec axis, real angle)
{
    vec u = scale(axis, 1 / length(axis));
    real s = sinl(angle), c = cosl(angle), t = 1 - c;
    const real rotation[9] = {c + t * u.x * u.x,       t * u.x * u.y - s * u.z, t * u.x * u.z + s * u.y,
                              t * u.x * u.y + s * u.z, c + t * u.y * u.y,       t * u.y * u.z - s * u.x,
                              t * u.x * u.z - s * u.y, t * u.y * u.z + s * u.x, c + t * u.z * u.z};
    memcpy(m->rotation, rotation, sizeof rotation);
}

static vec move(const motion* m, vec x)
{
    const real* r = m->rotation;
    vec d = subtract(x, m->center);
    vec turned = {r[0] * d.x + r[1] * d.y + r[2] * d.z, r[3] * d.x + r[4] * d.y + r[5] * d.z,
                  r[6] * d.x + r[7] * d.y + r[8] * d.z};
    return add(add(m->center, turned), m->shift);
}

/* The child side turns about the axis from the parent's particle to the child's, right-handed: so seen from p2 to p3 a
 * turning p4 side goes clockwise and a turning p1 side counterclockwise, and both add to the dihedral. */
static motion torsionMotion(const oracleScene* scene, int link, double angle)
{
    int p2 = scene->linkTorsions[4 * link + 1], p3 = scene->linkTorsions[4 * link + 2];
    int childParticle = scene->particleLinks[p3] == link ? p3 : p2;
    int parentParticle = childParticle == p3 ? p2 : p3;
    const vec* x = scene->positions[ORACLE_STATE];
    motion m = {.center = x[parentParticle]};
    setRotation(&m, subtract(x[childParticle], x[parentParticle]), angle);
    return m;
}

static motion freeMotion(const double* change)
{
    vec rotation = vecFromDoubles(change + 1);
    motion m = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                .center = vecFromDoubles(change + 4),
                .shift = vecFromDoubles(change + 7)};
    real angle = length(rotation);
    if (angle > 0)
        setRotation(&m, rotation, angle);
    return m;
}

/* About the particle that the joint names as p2. */
static motion ballMotion(const oracleScene* scene, int link, const double* change)
{
    motion m = freeMotion(change);
    m.center = scene->positions[ORACLE_STATE][scene->linkTorsions[4 * link + 1]];
    m.shift = (vec){0, 0, 0};
    return m;
}

/* A point of a link in the trial: the changes from its link upward, inner ones first, each about the axis that it has
 * before the trial; so an outer change carries the inner one's result along. */
static vec moveWithLink(const oracleScene* scene, int link, vec x)
{
    int changed = scene->changed[link];
    while (changed >= 0) {
        x = move(&scene->motions[changed], x);
        int parent = scene->linkParents[changed];
        changed = parent < 0 ? -1 : scene->changed[parent];
    }
    return x;
}

/* ---- Limits and exclusions ---- */

static int comparePairs(const void* a, const void* b)
{
    const int *p = a, *q = b;
    if (p[0] != q[0])
        return p[0] < q[0] ? -1 : 1;
    return (p[1] > q[1]) - (p[1] < q[1]);
}

static void sortedPair(int particle1, int particle2, int* pair)
{
    pair[0] = particle1 < particle2 ? particle1 : particle2;
    pair[1] = particle1 < particle2 ? particle2 : particle1;
}

static int isExcluded(const oracleScene* scene, int i, int j)
{
    int pair[2];
    sortedPair(i, j, pair);
    return bsearch(pair, scene->exclusions, (size_t)scene->exclusionCount, 2 * sizeof(int), comparePairs) != NULL;
}

static int isModelledPair(const oracleScene* scene, int i, int j)
{
    return scene->radii[i] > 0 && scene->radii[j] > 0 && !isExcluded(scene, i, j);
}

static real toleranceOf(const oracleScene* scene, int i, int j)
{
    int a = scene->roles[i], b = scene->roles[j];
    int bond = ((a & ORACLE_DONOR) && (b & ORACLE_ACCEPTOR)) || ((a & ORACLE_ACCEPTOR) && (b & ORACLE_DONOR));
    return (real)scene->overlapTolerance + (bond ? (real)scene->hydrogenBondAllowance : 0);
}

static real limitOf(const oracleScene* scene, int i, int j)
{
    int pair[2];
    sortedPair(i, j, pair);
    const limitedPair* own = bsearch(pair, scene->limits, (size_t)scene->limitCount, sizeof(limitedPair), comparePairs);
    return own != NULL ? own->limit : toleranceOf(scene, i, j);
}

/* ---- All pairs ---- */

static real distanceOf(const oracleScene* scene, int which, int i, int j)
{
    return length(subtract(scene->positions[which][i], scene->positions[which][j]));
}

static real overlapOf(const oracleScene* scene, int which, int i, int j)
{
    return (real)scene->radii[i] + (real)scene->radii[j] - distanceOf(scene, which, i, j);
}

typedef struct sweptParticle {
    double x, y, z;
    int index;
} sweptParticle;

static int compareSwept(const void* a, const void* b)
{
    double p = ((const sweptParticle*)a)->x, q = ((const sweptParticle*)b)->x;
    return (p > q) - (p < q);
}

typedef void visitPair(void* context, int particle1, int particle2);

/* Visits every pair of modelled particles that may be at most `reach` apart, and some that are not; the visitor decides
 * in long double. Particles in the order of their x are compared until x alone is too far. */
static void forEachPairWithin(const oracleScene* scene, int which, double reach, visitPair* visit, void* context)
{
    sweptParticle* swept = allocate(scene->particleCount, sizeof(sweptParticle));
    int count = 0;
    double greatest = 1;
    for (int i = 0; i < scene->particleCount; i++)
        if (scene->radii[i] > 0) {
            vec p = scene->positions[which][i];
            swept[count++] = (sweptParticle){(double)p.x, (double)p.y, (double)p.z, i};
            greatest = fmax(greatest, fmax(fabs((double)p.x), fmax(fabs((double)p.y), fabs((double)p.z))));
        }
    qsort(swept, (size_t)count, sizeof(sweptParticle), compareSwept);
    double far = reach + screenMargin * greatest;
    for (int a = 0; a < count; a++)
        for (int b = a + 1; b < count && swept[b].x - swept[a].x <= far; b++) {
            double dx = swept[b].x - swept[a].x, dy = swept[b].y - swept[a].y, dz = swept[b].z - swept[a].z;
            if (dx * dx + dy * dy + dz * dz <= far * far) {
                int pair[2];
                sortedPair(swept[a].index, swept[b].index, pair);
                visit(context, pair[0], pair[1]);
            }
        }
    free(swept);
}

/* No pair further apart than this overlaps by anything above -slack. */
static double overlapReach(const oracleScene* scene, double slack)
{
    double greatest = 0;
    for (int i = 0; i < scene->particleCount; i++)
        greatest = fmax(greatest, scene->radii[i]);
    return 2 * greatest + slack;
}

/* ---- Lists ---- */

typedef struct entry {
    int pair[2];
    double values[2];
} entry;

/* A visitor's data, and the entries that it has found. */
typedef struct list {
    const oracleScene* scene;
    real cutoff;
    int useLimits;
    int count, room;
    entry* entries;
} list;

static void append(list* found, int i, int j, real value1, real value2)
{
    if (found->count == found->room) {
        found->room = found->room > 0 ? 2 * found->room : 64;
        found->entries = realloc(found->entries, (size_t)found->room * sizeof(entry));
        if (found->entries == NULL)
            abort();
    }
    found->entries[found->count++] = (entry){{i, j}, {(double)value1, (double)value2}};
}

/* Sorts by one of the two particles; what has the same one stays in order. */
static void sortByParticle(list* found, int which)
{
    int end = 0;
    for (int n = 0; n < found->count; n++)
        end = found->entries[n].pair[which] >= end ? found->entries[n].pair[which] + 1 : end;
    int* begin = allocate(end + 1, sizeof(int));
    entry* sorted = allocate(found->count, sizeof(entry));
    for (int n = 0; n < found->count; n++)
        begin[found->entries[n].pair[which] + 1]++;
    for (int particle = 0; particle < end; particle++)
        begin[particle + 1] += begin[particle];
    for (int n = 0; n < found->count; n++)
        sorted[begin[found->entries[n].pair[which]]++] = found->entries[n];
    free(begin);
    free(found->entries);
    found->entries = sorted;
}

/* Sorts, writes the first `capacity` entries, frees, and returns the number of all. */
static int deliver(list* found, int capacity, int* pairs, double* values1, double* values2)
{
    for (int which = 1; which >= 0; which--)
        sortByParticle(found, which);
    for (int n = 0; n < found->count && n < capacity; n++) {
        memcpy(pairs + 2 * n, found->entries[n].pair, 2 * sizeof(int));
        values1[n] = found->entries[n].values[0];
        if (values2 != NULL)
            values2[n] = found->entries[n].values[1];
    }
    free(found->entries);
    return found->count;
}

/* ---- Life ---- */

static void orderLinks(oracleScene* scene)
{
    int ordered = 0;
    unsigned char* done = allocate(scene->linkCount, 1);
    int* waiting = allocate(scene->linkCount, sizeof(int));
    for (int start = 0; start < scene->linkCount; start++) {
        int depth = 0;
        for (int link = start; link >= 0 && !done[link]; link = scene->linkParents[link]) {
            done[link] = 1;
            waiting[depth++] = link;
        }
        while (depth > 0)
            scene->linkOrder[ordered++] = waiting[--depth];
    }
    free(waiting);
    free(done);
}

oracleScene* oracleCreate(int particleCount, const double* positions, const double* radii, const unsigned char* roles,
                          const int* particleLinks, int linkCount, const int* linkParents,
                          const unsigned char* linkJoints, const int* linkTorsions, int exclusionCount,
                          const int* exclusions, double overlapTolerance, double hydrogenBondAllowance)
{
    oracleScene* scene = allocate(1, sizeof(oracleScene));
    scene->particleCount = particleCount;
    scene->linkCount = linkCount;
    scene->reference = allocate(particleCount, sizeof(vec));
    for (int which = ORACLE_STATE; which <= ORACLE_TRIAL; which++) {
        scene->positions[which] = allocate(particleCount, sizeof(vec));
        scene->axes[which] = allocate(4 * linkCount, sizeof(vec));
        scene->turns[which] = allocate(linkCount, sizeof(real));
    }
    scene->radii = duplicate(radii, particleCount, sizeof(double));
    scene->roles = duplicate(roles, particleCount, 1);
    scene->particleLinks = duplicate(particleLinks, particleCount, sizeof(int));
    scene->linkParents = duplicate(linkParents, linkCount, sizeof(int));
    scene->linkJoints = duplicate(linkJoints, linkCount, 1);
    scene->linkTorsions = duplicate(linkTorsions, 4 * linkCount, sizeof(int));
    scene->linkOrder = allocate(linkCount, sizeof(int));
    orderLinks(scene);
    scene->changed = allocate(linkCount, sizeof(int));
    scene->motions = allocate(linkCount, sizeof(motion));
    scene->displaced = allocate(particleCount, sizeof(int));
    scene->exclusionCount = exclusionCount;
    scene->exclusions = allocate(2 * exclusionCount, sizeof(int));
    for (int n = 0; n < exclusionCount; n++)
        sortedPair(exclusions[2 * n], exclusions[2 * n + 1], scene->exclusions + 2 * n);
    qsort(scene->exclusions, (size_t)exclusionCount, 2 * sizeof(int), comparePairs);
    scene->limits = allocate(0, sizeof(limitedPair));
    scene->overlapTolerance = overlapTolerance;
    scene->hydrogenBondAllowance = hydrogenBondAllowance;
    oracleSetPositions(scene, positions);
    return scene;
}

void oracleDestroy(oracleScene* scene)
{
    if (scene == NULL)
        return;
    for (int which = ORACLE_STATE; which <= ORACLE_TRIAL; which++) {
        free(scene->positions[which]);
        free(scene->axes[which]);
        free(scene->turns[which]);
    }
    free(scene->reference);
    free(scene->radii);
    free(scene->roles);
    free(scene->particleLinks);
    free(scene->linkParents);
    free(scene->linkJoints);
    free(scene->linkTorsions);
    free(scene->linkOrder);
    free(scene->changed);
    free(scene->motions);
    free(scene->displaced);
    free(scene->exclusions);
    free(scene->limits);
    free(scene);
}

/* ---- State ---- */

/* The particle at the origin of a link's frame: that of the torsion axis, that about which a ball joint turns, else its
 * lowest-numbered; -1 if it has none. */
static int originOf(const oracleScene* scene, int link)
{
    if (scene->linkJoints[link] == ORACLE_TORSION) {
        int p3 = scene->linkTorsions[4 * link + 2];
        return scene->particleLinks[p3] == link ? p3 : scene->linkTorsions[4 * link + 1];
    }
    if (scene->linkJoints[link] == ORACLE_BALL)
        return scene->linkTorsions[4 * link + 1];
    for (int i = 0; i < scene->particleCount; i++)
        if (scene->particleLinks[i] == link)
            return i;
    return -1;
}

static void copyStateToTrial(oracleScene* scene)
{
    memcpy(scene->positions[ORACLE_TRIAL], scene->positions[ORACLE_STATE], (size_t)scene->particleCount * sizeof(vec));
    memcpy(scene->axes[ORACLE_TRIAL], scene->axes[ORACLE_STATE], 4 * (size_t)scene->linkCount * sizeof(vec));
    memcpy(scene->turns[ORACLE_TRIAL], scene->turns[ORACLE_STATE], (size_t)scene->linkCount * sizeof(real));
    for (int link = 0; link < scene->linkCount; link++)
        scene->changed[link] = -1;
    for (int i = 0; i < scene->particleCount; i++)
        scene->displaced[i] = -1;
}

void oracleMakeFlexible(oracleScene* scene)
{
    scene->isFlexible = 1;
}

void oracleSetPositions(oracleScene* scene, const double* positions)
{
    for (int i = 0; i < scene->particleCount; i++)
        scene->reference[i] = scene->positions[ORACLE_STATE][i] = vecFromDoubles(positions + 3 * i);
    for (int link = 0; link < scene->linkCount; link++) {
        int particle = originOf(scene, link);
        vec origin = particle >= 0 ? scene->reference[particle] : (vec){0, 0, 0};
        vec* axes = scene->axes[ORACLE_STATE] + 4 * link;
        axes[0] = origin;
        axes[1] = add(origin, (vec){1, 0, 0});
        axes[2] = add(origin, (vec){0, 1, 0});
        axes[3] = add(origin, (vec){0, 0, 1});
        scene->turns[ORACLE_STATE][link] = 0;
    }
    copyStateToTrial(scene);
}

void oracleGetPositions(const oracleScene* scene, int which, double* positions)
{
    for (int i = 0; i < scene->particleCount; i++)
        vecToDoubles(scene->positions[which][i], positions + 3 * i);
}

static real dihedralOf(const vec* x, const int* p, real* sine)
{
    vec b1 = subtract(x[p[1]], x[p[0]]), b2 = subtract(x[p[2]], x[p[1]]), b3 = subtract(x[p[3]], x[p[2]]);
    vec n1 = cross(b1, b2), n2 = cross(b2, b3);
    real product1 = length(b1) * length(b2), product2 = length(b2) * length(b3);
    *sine = fminl(product1 > 0 ? length(n1) / product1 : 0, product2 > 0 ? length(n2) / product2 : 0);
    return atan2l(length(b2) * dot(b1, n2), dot(n1, n2));
}

double oracleDihedral(const oracleScene* scene, int which, int p1, int p2, int p3, int p4, double* sine)
{
    const int particles[4] = {p1, p2, p3, p4};
    real exactSine;
    real angle = dihedralOf(scene->positions[which], particles, &exactSine);
    *sine = (double)exactSine;
    return (double)angle;
}

double oracleTorsionAngle(const oracleScene* scene, int link, double* sine)
{
    const real fullTurn = 2 * acosl(-1);
    const vec* x = scene->isFlexible ? scene->positions[ORACLE_STATE] : scene->reference;
    real exactSine;
    real angle = dihedralOf(x, scene->linkTorsions + 4 * link, &exactSine);
    if (!scene->isFlexible)
        angle += scene->turns[ORACLE_STATE][link];
    *sine = (double)exactSine;
    return (double)remainderl(angle, fullTurn);
}

static int hangsOn(const oracleScene* scene, int link, int ancestor)
{
    while (link >= 0 && link != ancestor)
        link = scene->linkParents[link];
    return link == ancestor;
}

int oracleCentroid(const oracleScene* scene, int link, double* centroid)
{
    vec sum = {0, 0, 0};
    int count = 0;
    for (int i = 0; i < scene->particleCount; i++)
        if (hangsOn(scene, scene->particleLinks[i], link)) {
            sum = add(sum, scene->positions[ORACLE_STATE][i]);
            count++;
        }
    if (count > 0)
        vecToDoubles(scale(sum, (real)1 / count), centroid);
    return count;
}

void oracleOrientation(const oracleScene* scene, int link, double* rotation)
{
    const vec* axes = scene->axes[ORACLE_STATE] + 4 * link;
    for (int column = 0; column < 3; column++) {
        double axis[3];
        vecToDoubles(subtract(axes[column + 1], axes[0]), axis);
        for (int row = 0; row < 3; row++)
            rotation[3 * row + column] = axis[row];
    }
}

void oracleRelativeTransform(const oracleScene* scene, int linkA, int linkB, double* rotation, double* translation)
{
    const vec* a = scene->axes[ORACLE_STATE] + 4 * linkA;
    const vec* b = scene->axes[ORACLE_STATE] + 4 * linkB;
    for (int row = 0; row < 3; row++) {
        vec axisA = subtract(a[row + 1], a[0]);
        for (int column = 0; column < 3; column++)
            rotation[3 * row + column] = (double)dot(axisA, subtract(b[column + 1], b[0]));
        translation[row] = (double)dot(axisA, subtract(b[0], a[0]));
    }
}

/* ---- Limits of single pairs ---- */

void oracleSetLimits(oracleScene* scene, int count, const int* pairs, const double* limits)
{
    free(scene->limits);
    scene->limits = allocate(count, sizeof(limitedPair));
    scene->limitCount = 0;
    for (int n = 0; n < count; n++) {
        limitedPair own = {.limit = limits[n]};
        sortedPair(pairs[2 * n], pairs[2 * n + 1], own.pair);
        if (own.limit > toleranceOf(scene, own.pair[0], own.pair[1]))
            scene->limits[scene->limitCount++] = own;
    }
    qsort(scene->limits, (size_t)scene->limitCount, sizeof(limitedPair), comparePairs);
}

/* ---- Trials ---- */

void oraclePropose(oracleScene* scene, int count, const int* links, const double* changes)
{
    copyStateToTrial(scene);
    for (int n = 0; n < count; n++) {
        const double* change = changes + ORACLE_CHANGE_SIZE * n;
        int link = links[n];
        scene->changed[link] = link;
        if (scene->linkJoints[link] == ORACLE_TORSION) {
            scene->motions[link] = torsionMotion(scene, link, change[0]);
            scene->turns[ORACLE_TRIAL][link] += change[0];
        }
        else if (scene->linkJoints[link] == ORACLE_BALL)
            scene->motions[link] = ballMotion(scene, link, change);
        else
            scene->motions[link] = freeMotion(change);
    }
    for (int n = 0; n < scene->linkCount; n++) {
        int link = scene->linkOrder[n], parent = scene->linkParents[link];
        if (scene->changed[link] < 0 && parent >= 0)
            scene->changed[link] = scene->changed[parent];
    }
    for (int i = 0; i < scene->particleCount; i++)
        scene->positions[ORACLE_TRIAL][i] =
            moveWithLink(scene, scene->particleLinks[i], scene->positions[ORACLE_STATE][i]);
    for (int n = 0; n < 4 * scene->linkCount; n++)
        scene->axes[ORACLE_TRIAL][n] = moveWithLink(scene, n / 4, scene->axes[ORACLE_STATE][n]);
}

void oracleProposeDisplacements(oracleScene* scene, int count, const int* particles, const double* shifts)
{
    copyStateToTrial(scene);
    for (int n = 0; n < count; n++) {
        vec* x = &scene->positions[ORACLE_TRIAL][particles[n]];
        int first = 0;
        while (memcmp(shifts + 3 * first, shifts + 3 * n, 3 * sizeof(double)) != 0)
            first++;
        *x = add(*x, vecFromDoubles(shifts + 3 * n));
        scene->displaced[particles[n]] = particles[first];
    }
}

/* Two particles move as one rigid body if the changes from their links upward are the same, which the first of them
 * tells: it has one way up; and if they are displaced by the same shift or not at all. */
int oracleIsPairChanged(const oracleScene* scene, int particle1, int particle2)
{
    return scene->changed[scene->particleLinks[particle1]] != scene->changed[scene->particleLinks[particle2]] ||
           scene->displaced[particle1] != scene->displaced[particle2];
}

typedef struct worstPair {
    const oracleScene* scene;
    int pair[2];
    real margin;
} worstPair;

static void findWorst(void* context, int i, int j)
{
    worstPair* worst = context;
    if (!oracleIsPairChanged(worst->scene, i, j) || isExcluded(worst->scene, i, j))
        return;
    real margin = overlapOf(worst->scene, ORACLE_TRIAL, i, j) - limitOf(worst->scene, i, j);
    if (margin > worst->margin) {
        worst->pair[0] = i;
        worst->pair[1] = j;
        worst->margin = margin;
    }
}

double oracleWorstTrialMargin(const oracleScene* scene, int* pair)
{
    worstPair worst = {scene, {-1, -1}, -INFINITY};
    forEachPairWithin(scene, ORACLE_TRIAL, overlapReach(scene, 0), findWorst, &worst);
    memcpy(pair, worst.pair, sizeof worst.pair);
    return (double)worst.margin;
}

static void findChangedBefore(void* context, int i, int j)
{
    list* found = context;
    real before = distanceOf(found->scene, ORACLE_STATE, i, j);
    if (before <= found->cutoff && oracleIsPairChanged(found->scene, i, j) && isModelledPair(found->scene, i, j))
        append(found, i, j, before, distanceOf(found->scene, ORACLE_TRIAL, i, j));
}

/* Pairs that findChangedBefore has not found. */
static void findChangedAfter(void* context, int i, int j)
{
    list* found = context;
    real before = distanceOf(found->scene, ORACLE_STATE, i, j);
    real after = distanceOf(found->scene, ORACLE_TRIAL, i, j);
    if (before > found->cutoff && after <= found->cutoff && oracleIsPairChanged(found->scene, i, j) &&
        isModelledPair(found->scene, i, j))
        append(found, i, j, before, after);
}

int oracleListChangedPairs(const oracleScene* scene, double cutoff, int capacity, int* pairs, double* before,
                           double* after)
{
    list found = {.scene = scene, .cutoff = cutoff};
    forEachPairWithin(scene, ORACLE_STATE, cutoff, findChangedBefore, &found);
    forEachPairWithin(scene, ORACLE_TRIAL, cutoff, findChangedAfter, &found);
    return deliver(&found, capacity, pairs, before, after);
}

void oracleAccept(oracleScene* scene)
{
    memcpy(scene->positions[ORACLE_STATE], scene->positions[ORACLE_TRIAL], (size_t)scene->particleCount * sizeof(vec));
    memcpy(scene->axes[ORACLE_STATE], scene->axes[ORACLE_TRIAL], 4 * (size_t)scene->linkCount * sizeof(vec));
    memcpy(scene->turns[ORACLE_STATE], scene->turns[ORACLE_TRIAL], (size_t)scene->linkCount * sizeof(real));
    copyStateToTrial(scene);
}

void oracleReject(oracleScene* scene)
{
    copyStateToTrial(scene);
}

/* ---- Pairs ---- */

double oracleDistance(const oracleScene* scene, int which, int particle1, int particle2)
{
    return (double)distanceOf(scene, which, particle1, particle2);
}

double oracleClashMargin(const oracleScene* scene, int which, int particle1, int particle2)
{
    if (!isModelledPair(scene, particle1, particle2))
        return -INFINITY;
    return (double)(overlapOf(scene, which, particle1, particle2) - toleranceOf(scene, particle1, particle2));
}

double oracleLimitMargin(const oracleScene* scene, int which, int particle1, int particle2)
{
    if (!isModelledPair(scene, particle1, particle2))
        return -INFINITY;
    return (double)(overlapOf(scene, which, particle1, particle2) - limitOf(scene, particle1, particle2));
}

/* ---- Queries of the state ---- */

static void findOverlap(void* context, int i, int j)
{
    list* found = context;
    if (isExcluded(found->scene, i, j))
        return;
    real overlap = overlapOf(found->scene, ORACLE_STATE, i, j);
    real margin = overlap - (found->useLimits ? limitOf(found->scene, i, j) : toleranceOf(found->scene, i, j));
    if (margin > found->cutoff)
        append(found, i, j, overlap, margin);
}

int oracleListClashes(const oracleScene* scene, double slack, int capacity, int* pairs, double* overlaps,
                      double* margins)
{
    list found = {.scene = scene, .cutoff = -slack};
    forEachPairWithin(scene, ORACLE_STATE, overlapReach(scene, slack), findOverlap, &found);
    return deliver(&found, capacity, pairs, overlaps, margins);
}

int oracleListBeyondLimits(const oracleScene* scene, double slack, int capacity, int* pairs, double* overlaps,
                           double* margins)
{
    list found = {.scene = scene, .cutoff = -slack, .useLimits = 1};
    forEachPairWithin(scene, ORACLE_STATE, overlapReach(scene, slack), findOverlap, &found);
    return deliver(&found, capacity, pairs, overlaps, margins);
}

static void findNeighbor(void* context, int i, int j)
{
    list* found = context;
    real distance = distanceOf(found->scene, ORACLE_STATE, i, j);
    if (distance <= found->cutoff && !isExcluded(found->scene, i, j))
        append(found, i, j, distance, 0);
}

int oracleListNeighborPairs(const oracleScene* scene, double cutoff, int capacity, int* pairs, double* distances)
{
    list found = {.scene = scene, .cutoff = cutoff};
    forEachPairWithin(scene, ORACLE_STATE, cutoff, findNeighbor, &found);
    return deliver(&found, capacity, pairs, distances, NULL);
}

int oracleListClashesWith(const oracleScene* scene, const double* position, double radius, double slack, int capacity,
                          int* particles, double* overlaps, double* margins)
{
    vec center = vecFromDoubles(position);
    int count = 0;
    for (int i = 0; i < scene->particleCount; i++) {
        if (!(scene->radii[i] > 0))
            continue;
        real distance = length(subtract(scene->positions[ORACLE_STATE][i], center));
        real overlap = (real)scene->radii[i] + (real)radius - distance;
        real margin = overlap - (real)scene->overlapTolerance;
        if (margin > -(real)slack) {
            if (count < capacity) {
                particles[count] = i;
                overlaps[count] = (double)overlap;
                margins[count] = (double)margin;
            }
            count++;
        }
    }
    return count;
}

double oracleMinimumDistance(const oracleScene* scene, int count1, const int* particles1, int count2,
                             const int* particles2)
{
    real least = INFINITY;
    for (int a = 0; a < count1; a++)
        for (int b = 0; b < count2; b++)
            if (particles1[a] != particles2[b])
                least = fminl(least, distanceOf(scene, ORACLE_STATE, particles1[a], particles2[b]));
    return (double)least;
}

typedef struct energySum {
    const oracleScene* scene;
    real k, energy;
    vec* forces;
} energySum;

static void addEnergy(void* context, int i, int j)
{
    energySum* sum = context;
    if (isExcluded(sum->scene, i, j))
        return;
    real depth = overlapOf(sum->scene, ORACLE_STATE, i, j) - toleranceOf(sum->scene, i, j);
    if (depth <= 0)
        return;
    const vec* x = sum->scene->positions[ORACLE_STATE];
    vec apart = subtract(x[i], x[j]);
    real distance = length(apart);
    vec direction = distance > 0 ? scale(apart, 1 / distance) : (vec){1, 0, 0};
    vec force = scale(direction, sum->k * depth);
    sum->energy += sum->k * depth * depth / 2;
    sum->forces[i] = add(sum->forces[i], force);
    sum->forces[j] = subtract(sum->forces[j], force);
}

double oracleEnergy(const oracleScene* scene, double k, double* forces)
{
    energySum sum = {scene, k, 0, allocate(scene->particleCount, sizeof(vec))};
    forEachPairWithin(scene, ORACLE_STATE, overlapReach(scene, 0), addEnergy, &sum);
    if (forces != NULL)
        for (int i = 0; i < scene->particleCount; i++)
            vecToDoubles(sum.forces[i], forces + 3 * i);
    free(sum.forces);
    return (double)sum.energy;
}
