/* The oracle against geometry done by hand, and its sweep against two plain loops. */
#include "oracle/oracle.h"
#include "oracle/randomScene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            printf("%s:%d: %s\n", __func__, __LINE__, #condition);                                                     \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

#define CHECK_NEAR(value, expected)                                                                                    \
    do {                                                                                                               \
        double value_ = (value), expected_ = (expected);                                                               \
        if (!(fabs(value_ - expected_) < 1e-14)) {                                                                     \
            printf("%s:%d: %s is %.17g, not %.17g\n", __func__, __LINE__, #value, value_, expected_);                  \
            failures++;                                                                                                \
        }                                                                                                              \
    } while (0)

static const double pi = 3.14159265358979323846;

/* Particles of one link each, in a chain of which link 0 is the root; p2 of a link's torsion is the particle before it,
 * or with rootIsAtP3 p3 is. */
static oracleScene* makeChain(int count, const double* positions, const double* radii, int rootIsAtP3)
{
    enum { MOST = 8 };
    int links[MOST], parents[MOST], torsions[4 * MOST];
    unsigned char joints[MOST];
    for (int n = 0; n < count; n++) {
        links[n] = n;
        parents[n] = n - 1;
        joints[n] = n == 0 ? ORACLE_FIXED : ORACLE_TORSION;
        const int forward[4] = {n - 2, n - 1, n, n + 1};
        for (int k = 0; k < 4; k++)
            torsions[4 * n + k] = (forward[rootIsAtP3 ? 3 - k : k] + count) % count;
    }
    return oracleCreate(count, positions, radii, NULL, links, count, parents, joints, torsions, 0, NULL, 0, 0);
}

/* Spheres that share nothing: each a free link. */
static oracleScene* makeSpheres(int count, const double* positions, const double* radii, const unsigned char* roles,
                                int exclusionCount, const int* exclusions, double tolerance, double allowance)
{
    enum { MOST = 1000 };
    static int links[MOST], parents[MOST];
    static unsigned char joints[MOST];
    for (int n = 0; n < count; n++) {
        links[n] = n;
        parents[n] = -1;
        joints[n] = ORACLE_FREE;
    }
    return oracleCreate(count, positions, radii, roles, links, count, parents, joints, NULL, exclusionCount, exclusions,
                        tolerance, allowance);
}

static void checkPosition(const oracleScene* scene, int which, int particle, double x, double y, double z)
{
    double positions[3 * 8];
    oracleGetPositions(scene, which, positions);
    CHECK_NEAR(positions[3 * particle], x);
    CHECK_NEAR(positions[3 * particle + 1], y);
    CHECK_NEAR(positions[3 * particle + 2], z);
}

/* Seen from p2 to p3 (along +z), a p4 at angle a of the xy plane is clockwise of a p1 at angle 0: by IUPAC, +a. */
static void testDihedralSign(void)
{
    for (int n = -3; n <= 4; n++) {
        double angle = n * pi / 4, sine;
        const double positions[] = {1, 0, 0, 0, 0, 0, 0, 0, 1, cos(angle), sin(angle), 1};
        const double radii[] = {0, 0, 0, 0};
        oracleScene* scene = makeChain(4, positions, radii, 0);
        CHECK_NEAR(oracleDihedral(scene, ORACLE_STATE, 0, 1, 2, 3, &sine), angle);
        CHECK_NEAR(sine, 1);
        CHECK_NEAR(oracleDihedral(scene, ORACLE_STATE, 3, 2, 1, 0, &sine), angle);
        oracleDestroy(scene);
    }
    const double straight[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 2, 1, 0};
    double sine;
    oracleScene* scene = makeChain(4, straight, (double[]){0, 0, 0, 0}, 0);
    oracleDihedral(scene, ORACLE_STATE, 0, 1, 2, 3, &sine);
    CHECK(sine == 0);
    oracleDestroy(scene);
}

/* A turn adds to the dihedral, whichever end of the axis is the root's, and moves nothing on the root's side. */
static void testTorsion(void)
{
    const double positions[] = {1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 1};
    const double radii[] = {0, 0, 0, 0};
    for (int rootIsAtP3 = 0; rootIsAtP3 < 2; rootIsAtP3++) {
        oracleScene* scene = makeChain(4, positions, radii, rootIsAtP3);
        const int link = 2;
        const double change[ORACLE_CHANGE_SIZE] = {pi / 2};
        double sine;
        oraclePropose(scene, 1, &link, change);
        CHECK_NEAR(oracleDihedral(scene, ORACLE_TRIAL, 0, 1, 2, 3, &sine), pi / 2);
        CHECK_NEAR(oracleDihedral(scene, ORACLE_STATE, 0, 1, 2, 3, &sine), 0);
        checkPosition(scene, ORACLE_TRIAL, 0, 1, 0, 0);
        checkPosition(scene, ORACLE_TRIAL, 3, 0, 1, 1);
        CHECK(oracleIsPairChanged(scene, 1, 2) && oracleIsPairChanged(scene, 0, 3));
        CHECK(!oracleIsPairChanged(scene, 0, 1) && !oracleIsPairChanged(scene, 2, 3));
        oracleReject(scene);
        CHECK(!oracleIsPairChanged(scene, 0, 3));
        CHECK_NEAR(oracleTorsionAngle(scene, 2, &sine), 0);
        for (int turn = 1; turn <= 3; turn++) {
            oraclePropose(scene, 1, &link, change);
            oracleAccept(scene);
        }
        CHECK_NEAR(oracleTorsionAngle(scene, 2, &sine), -pi / 2);
        checkPosition(scene, ORACLE_STATE, 3, 0, -1, 1);
        oracleSetPositions(scene, positions);
        CHECK_NEAR(oracleTorsionAngle(scene, 2, &sine), 0);
        oracleDestroy(scene);
    }
}

/* An arm in the xy plane turns about axes along z at its elbows: the reach is a sum of unit vectors at summed angles.
 */
static void testNestedChanges(void)
{
    /* each link: a particle at its elbow, and one above it as the far end of the axis; the last one is the hand */
    const double positions[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 2, 0, 0, 2, 0, 1, 3, 0, 0};
    const double radii[7] = {0};
    const int links[] = {0, 1, 1, 2, 2, 3, 3};
    const int parents[] = {-1, 0, 1, 2};
    const unsigned char joints[] = {ORACLE_FIXED, ORACLE_TORSION, ORACLE_TORSION, ORACLE_TORSION};
    /* the axis of link l goes from the elbow, which is the parent's, up to the link's */
    const int torsions[] = {0, 0, 0, 0, 6, 0, 1, 6, 0, 2, 3, 6, 0, 4, 5, 6};
    oracleScene* scene = oracleCreate(7, positions, radii, NULL, links, 4, parents, joints, torsions, 0, NULL, 0, 0);
    const double angles[] = {0.3, -1.1, 2.5};
    const int orders[][3] = {{1, 2, 3}, {3, 2, 1}, {2, 3, 1}};
    for (int n = 0; n < 3; n++) {
        double changes[3 * ORACLE_CHANGE_SIZE] = {0};
        for (int k = 0; k < 3; k++)
            changes[ORACLE_CHANGE_SIZE * k] = angles[orders[n][k] - 1];
        oraclePropose(scene, 3, orders[n], changes);
        double a = angles[0], b = a + angles[1], c = b + angles[2];
        checkPosition(scene, ORACLE_TRIAL, 6, cos(a) + cos(b) + cos(c), sin(a) + sin(b) + sin(c), 0);
        checkPosition(scene, ORACLE_TRIAL, 5, cos(a) + cos(b), sin(a) + sin(b), 1);
    }
    oracleAccept(scene);
    double rotation[9], translation[3], turn = angles[1] + angles[2];
    oracleRelativeTransform(scene, 1, 3, rotation, translation);
    CHECK_NEAR(rotation[0], cos(turn));
    CHECK_NEAR(rotation[1], -sin(turn));
    CHECK_NEAR(rotation[3], sin(turn));
    CHECK_NEAR(rotation[8], 1);
    /* from link 1's particle on its axis, (0, 0, 1), to link 3's */
    CHECK_NEAR(translation[0], 1 + cos(angles[1]));
    CHECK_NEAR(translation[1], sin(angles[1]));
    CHECK_NEAR(translation[2], 0);
    double centroid[3];
    CHECK(oracleCentroid(scene, 3, centroid) == 2);
    CHECK(oracleCentroid(scene, 0, centroid) == 7);
    oracleDestroy(scene);
}

/* Particles of a flexible scene are displaced, and links turn about where they are then. */
static void testDisplacements(void)
{
    const double positions[] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0};
    const double radii[] = {0.1, 0.1, 0.1, 0.1};
    oracleScene* scene = makeChain(4, positions, radii, 0);
    oracleMakeFlexible(scene);
    const int particles[] = {2, 3, 1};
    const double shifts[] = {-1, 1, 0, -1, 1, 0, 0, 0, 0.25};
    double rotation[9], translation[3], sine;
    oracleProposeDisplacements(scene, 3, particles, shifts);
    CHECK(oracleIsPairChanged(scene, 0, 1) && oracleIsPairChanged(scene, 1, 2) && oracleIsPairChanged(scene, 0, 3));
    CHECK(!oracleIsPairChanged(scene, 2, 3));
    oracleReject(scene);
    checkPosition(scene, ORACLE_STATE, 2, 1, 0, 0);
    CHECK(!oracleIsPairChanged(scene, 0, 2));
    oracleProposeDisplacements(scene, 1, particles, shifts);
    oracleAccept(scene);
    checkPosition(scene, ORACLE_STATE, 2, 0, 1, 0);
    checkPosition(scene, ORACLE_STATE, 3, 1, 1, 0);
    CHECK_NEAR(oracleTorsionAngle(scene, 2, &sine), pi / 2); /* and before, -pi / 2 */
    oracleRelativeTransform(scene, 0, 2, rotation, translation);
    CHECK_NEAR(translation[0], 1); /* where the particle was */
    CHECK_NEAR(translation[1], 0);
    /* Link 2 turns about the y axis now, and not about the x axis. */
    const int link = 2;
    const double change[ORACLE_CHANGE_SIZE] = {pi / 2};
    oraclePropose(scene, 1, &link, change);
    checkPosition(scene, ORACLE_TRIAL, 2, 0, 1, 0);
    checkPosition(scene, ORACLE_TRIAL, 3, 0, 1, -1);
    oracleAccept(scene);
    CHECK_NEAR(fabs(oracleTorsionAngle(scene, 2, &sine)), pi);
    oracleOrientation(scene, 2, rotation);
    CHECK_NEAR(rotation[2], 1);
    CHECK_NEAR(rotation[6], -1);
    CHECK_NEAR(rotation[4], 1);
    oracleDestroy(scene);
}

/* A quarter turn about a vertical axis, then a shift. */
static void testRigidMotion(void)
{
    const double positions[] = {1, 0, 0, 2, 0, 0};
    const double radii[] = {0.1, 0.1};
    oracleScene* scene = makeSpheres(2, positions, radii, NULL, 0, NULL, 0, 0);
    const int link = 1;
    const double change[ORACLE_CHANGE_SIZE] = {0, 0, 0, pi / 2, 1, 0, 5, 0, 0, 3};
    oraclePropose(scene, 1, &link, change);
    checkPosition(scene, ORACLE_TRIAL, 0, 1, 0, 0);
    checkPosition(scene, ORACLE_TRIAL, 1, 1, 1, 3);
    CHECK(oracleIsPairChanged(scene, 0, 1));
    int pair[2];
    double before, after;
    CHECK(oracleListChangedPairs(scene, 0.99, 1, pair, &before, &after) == 0);
    CHECK(oracleListChangedPairs(scene, 1.01, 1, pair, &before, &after) == 1);
    CHECK_NEAR(before, 1);
    CHECK_NEAR(after, sqrt(10));
    oracleDestroy(scene);
}

static void testClashes(void)
{
    /* 0 and 1 overlap by 0.1, 1 and 2 by 0.05, 3 is on top of 2 but not modelled, 4 and 5 coincide far away */
    const double positions[] = {0, 0, 0, 0.3, 0, 0, 0.3, 0.35, 0, 0.3, 0.35, 0, 9, 0, 0, 9, 0, 0};
    const double radii[] = {0.2, 0.2, 0.2, 0, 0.05, 0.05};
    const unsigned char roles[] = {ORACLE_DONOR, ORACLE_ACCEPTOR, ORACLE_ACCEPTOR, 0, 0, 0};
    const int excluded[] = {5, 4};
    int pairs[8];
    double overlaps[4], margins[4], forces[18];

    oracleScene* scene = makeSpheres(6, positions, radii, NULL, 0, NULL, 0.04, 0.07);
    CHECK(oracleListClashes(scene, 0, 4, pairs, overlaps, margins) == 3);
    CHECK(memcmp(pairs, (int[]){0, 1, 1, 2, 4, 5}, 6 * sizeof(int)) == 0);
    CHECK_NEAR(overlaps[0], 0.1);
    CHECK_NEAR(margins[1], 0.01);
    CHECK_NEAR(overlaps[2], 0.1);
    CHECK_NEAR(oracleEnergy(scene, 2, forces), 0.06 * 0.06 + 0.01 * 0.01 + 0.06 * 0.06);
    CHECK_NEAR(forces[0], -2 * 0.06);
    CHECK_NEAR(forces[3], 2 * 0.06);
    CHECK_NEAR(forces[4], -2 * 0.01);
    CHECK_NEAR(forces[12], 2 * 0.06);
    CHECK_NEAR(forces[15], -2 * 0.06);
    oracleSetLimits(scene, 2, (int[]){1, 0, 1, 2}, (double[]){0.11, 0.03});
    CHECK(oracleListBeyondLimits(scene, 0, 4, pairs, overlaps, margins) == 2);
    CHECK(oracleListClashes(scene, 0, 4, pairs, overlaps, margins) == 3);
    CHECK_NEAR(oracleLimitMargin(scene, ORACLE_STATE, 1, 0), -0.01);
    CHECK_NEAR(oracleClashMargin(scene, ORACLE_STATE, 0, 1), 0.06);
    CHECK(isinf(oracleClashMargin(scene, ORACLE_STATE, 2, 3)));
    oracleDestroy(scene);

    scene = makeSpheres(6, positions, radii, roles, 1, excluded, 0.04, 0.07);
    CHECK(oracleListClashes(scene, 0, 4, pairs, overlaps, margins) == 1);
    CHECK(pairs[0] == 1 && pairs[1] == 2);
    CHECK(oracleListClashes(scene, 0.02, 4, pairs, overlaps, margins) == 2);
    CHECK_NEAR(margins[0], -0.01);
    CHECK(oracleListNeighborPairs(scene, 0.36, 4, pairs, overlaps) == 2);
    CHECK_NEAR(overlaps[0], 0.3);
    int particles[2];
    CHECK(oracleListClashesWith(scene, (double[]){0, 0, 0.1}, 0, 0, 2, particles, overlaps, margins) == 1);
    CHECK(particles[0] == 0);
    CHECK_NEAR(overlaps[0], 0.1);
    CHECK_NEAR(margins[0], 0.06);
    CHECK_NEAR(oracleMinimumDistance(scene, 2, (int[]){4, 1}, 3, (int[]){0, 1, 5}), 0);
    CHECK_NEAR(oracleMinimumDistance(scene, 1, (int[]){1}, 3, (int[]){0, 1, 5}), 0.3);
    CHECK(isinf(oracleMinimumDistance(scene, 1, (int[]){1}, 1, (int[]){1})));
    oracleDestroy(scene);
}

/* Of n^3 points a unit apart, 3 n^2 (n - 1) pairs are at distance 1, 6 n (n - 1)^2 at sqrt 2. */
static void testLattice(void)
{
    enum { N = 7 };
    static double positions[3 * N * N * N], radii[N * N * N];
    for (int i = 0; i < N * N * N; i++) {
        positions[3 * i] = i % N;
        positions[3 * i + 1] = i / N % N;
        positions[3 * i + 2] = i / N / N;
        radii[i] = 0.1;
    }
    oracleScene* scene = makeSpheres(N * N * N, positions, radii, NULL, 0, NULL, 0, 0);
    CHECK(oracleListNeighborPairs(scene, 1.01, 0, NULL, NULL) == 3 * N * N * (N - 1));
    CHECK(oracleListNeighborPairs(scene, 1.42, 0, NULL, NULL) == 3 * N * N * (N - 1) + 6 * N * (N - 1) * (N - 1));
    oracleDestroy(scene);
}

/* The sweep over x lists the same pairs as two loops over all particles. */
static void testSweep(void)
{
    randomSource random = randomSourceFromSeed(1);
    for (int n = 0; n < 300; n++) {
        randomScene r;
        randomSceneCreate(&r, &random);
        oracleScene* scene = oracleCreate(r.particleCount, r.positions, r.radii, r.roles, r.particleLinks, r.linkCount,
                                          r.linkParents, r.linkJoints, r.linkTorsions, r.exclusionCount, r.exclusions,
                                          r.overlapTolerance, r.hydrogenBondAllowance);
        const int link = randomInt(&random, r.linkCount);
        double change[ORACLE_CHANGE_SIZE] = {0.7, 0.1, 0.2, 0.3, 1, 2, 3, 0.1, 0.2, 0.3};
        if (r.linkJoints[link] != ORACLE_FIXED)
            oraclePropose(scene, 1, &link, change);
        const double cutoff = randomReal(&random, 0.1, 0.8);
        int clashes = 0, neighbors = 0, changed = 0, pair[2];
        double worst = -INFINITY;
        for (int i = 0; i < r.particleCount; i++)
            for (int j = i + 1; j < r.particleCount; j++) {
                double margin = oracleClashMargin(scene, ORACLE_STATE, i, j);
                if (isinf(margin))
                    continue;
                double before = oracleDistance(scene, ORACLE_STATE, i, j);
                double after = oracleDistance(scene, ORACLE_TRIAL, i, j);
                clashes += margin > 0;
                neighbors += before <= cutoff;
                if (oracleIsPairChanged(scene, i, j)) {
                    changed += before <= cutoff || after <= cutoff;
                    worst = fmax(worst, oracleLimitMargin(scene, ORACLE_TRIAL, i, j));
                }
            }
        CHECK(oracleListClashes(scene, 0, 0, NULL, NULL, NULL) == clashes);
        CHECK(oracleListNeighborPairs(scene, cutoff, 0, NULL, NULL) == neighbors);
        CHECK(oracleListChangedPairs(scene, cutoff, 0, NULL, NULL, NULL) == changed);
        double found = oracleWorstTrialMargin(scene, pair);
        CHECK(found == worst || fmax(found, worst) < 0);
        oracleDestroy(scene);
        randomSceneDestroy(&r);
    }
}

int main(void)
{
    testDihedralSign();
    testTorsion();
    testNestedChanges();
    testDisplacements();
    testRigidMotion();
    testClashes();
    testLattice();
    testSweep();
    return failures > 0;
}
