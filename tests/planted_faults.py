"""Do the tests notice? Puts one fault after another into a copy of the repository and runs tests of its layer on it.

    python tests/planted_faults.py [--list | --check] [NAME ...]

A fault is a small edit of a source file, such as one could make by mistake. It is caught if a test of its layer fails,
hangs or crashes: the tests of the engine for the engine, those of the C++ classes for all that lies over it, and those
in Python for what is in Python, which take what is compiled from where the package is imported (PYTHONPATH). Faults
that nobody catches, or whose text is no longer in the source, make the exit status 1. The copy lies in a temporary
folder, or in that which --folder names, where a later run finds what is built. Takes about half a minute a fault; see
CONTRIBUTING.md. --check builds nothing: it only looks whether the text of each fault is in its file once.
"""

import argparse
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Layer:
    """Where faults are planted, and who may catch them."""

    folder: str  # in which their files lie
    label: str  # of its tests
    slow: str  # tests that are asked one by one if the others, which take little time, have not caught a fault
    never: str  # tests that are not asked


# The oracle's test knows nothing of the engine; trajectories may be wrong as long as they are the same; random programs
# run without a setting take longest; and what is installed is built by its test.
ENGINE = Layer(
    "platforms/reference/chaintree/src",
    "engine",
    slow="TestCommitCost|TestSizes|TestCrowds|TestScales|TestRandomPrograms",
    never="^(TestOracle|TestTrajectories|TestRandomPrograms|TestInstalled)$",
)
# Of the engine, what energies alone ask for is here, too.
ENERGY = Layer("platforms/reference/energy/src", "energy", slow="TestEnergyPrograms", never="^$")
GEOMETRY = Layer("platforms/reference/moves/src", "moves", slow="^$", never="^$")
# The platforms differ in little, and OpenCL takes a quarter of an hour.
API = Layer(".", "api", slow="TestReferenceTorsionMonteCarloIntegrator|TestCpu", never="TestOpenCL")
# Of Python, what is done by many at a time; other tests know nothing of it.
PYTHON = Layer(
    "python/openmmchaintree",
    "python",
    slow="test_(resuming|cluster)",
    never="^(?!test_(replica|clash_|parallel_sampler|resuming|cluster))",
)


@dataclass(frozen=True)
class Fault:
    name: str  # what is wrong, and the subject before the colon
    file: str
    old: str  # text that is in the file once
    new: str


# fmt: off
ENGINE_FAULTS = [
    # ---- Borders ----
    Fault("border: a trial may have more changes than there are links", "verdict.c",
          "if (count < 0 || count > tree->sequence.userLinkCount) {", "if (count < 0) {"),
    Fault("border: a count below 0 selects nothing", "scene.c",
          "if (count < 0 || count > CT_MOST_COUNT || (count", "if (count > CT_MOST_COUNT || (count"),
    Fault("border: a scene has the structure of links that hang elsewhere", "structure.c",
          "if (s->parent[link] != (parent", "if (false && s->parent[link] != (parent"),
    # ---- Volumes ----
    Fault("volume: a sphere around members leaves out their radii", "volume.h",
          "centre.y, centre.z)), load16(radii)));", "centre.y, centre.z)), all16(0)));"),
    Fault("volume: a bound is a thousandth too small", "refresh_body.h",
          "r + rounding, rounding - least[1]", "0.999f * r, rounding - least[1]"),
    Fault("volume: a bound has no room for its rounding", "refresh_body.h",
          "1e-6f * (fabsf(middle.x)", "0 * (fabsf(middle.x)"),
    Fault("volume: what straddles is not around its members", "view_body.h",
          "radiusAbout(bound, &s->block, s->block.r) + ", "0.9f * radiusAbout(bound, &s->block, s->block.r) + "),
    Fault("volume: radii of centres where surfaces are wanted", "view_body.h",
          "Surfaces ? own->block.r", "Surfaces ? own->centres"),
    # ---- What descents keep, types, axes ----
    Fault("kept: a leaf that has made room is still seen", "view_body.h",
          "t->inView[other] = NULL; /* its", "/* its"),
    Fault("kept: a node that has made room is still seen", "view_body.h",
          "if (t->inView[other] == moved) {", "if (t->inView[other] == NULL) {"),
    Fault("kept: the second of two blocks may stand where the first was", "view_body.h",
          "blockOf(t, a);\n  blocks[1] = blockOf(t, b);\n  blocks[0] = blockOf(t, a);",
          "blocks[0] = blockOf(t, a);\n  blocks[1] = blockOf(t, b);"),
    Fault("kept: boxes of another node", "viewboxes_body.h",
          "moved->node != node || moved->stamp", "moved->stamp"),
    Fault("type: that of the last new one", "particletype.c",
          "s->slotType[slot] = s->slotType[table[i] - 1];", "s->slotType[slot] = s->typeCount - 1;"),
    Fault("axis: from particles that are too close together", "tree.h",
          "> LEAST_LINE * dot(point, point)", "> 0"),
    # ---- Margins ----
    Fault("margin: a thousandth of that of float", "volume.h",
          "FLOAT_MARGIN 4e-6", "FLOAT_MARGIN 4e-9"),
    Fault("margin: none of double", "volume.h",
          "DOUBLE_MARGIN 1.2e-12", "DOUBLE_MARGIN 1.2e-19"),
    Fault("margin: none where squares vanish", "volume.h",
          "FLOAT_FLOOR 1e-18f", "FLOAT_FLOOR 0.0f"),
    Fault("margin: reach is left out of a filter", "volume.h",
          "all16(sphere.r + reach)), all16(0)", "all16(sphere.r)), all16(0)"),
    Fault("margin: a view's shift does not count", "view_body.h",
          "t->extent = size + shift;", "t->extent = size;"),
    # ---- Closed windows ----
    Fault("unmoved: what trials have skipped is not summed up", "skipped.c",
          "skipped->excess += trial->slack;",
          "skipped->excess += 0;"),
    Fault("unmoved: a look finds nothing", "skipped.c",
          "skipped->excess = ctSceneExcess(scene, MOST_EXCESS, counts);",
          "skipped->excess = lesser(0, ctSceneExcess(scene, MOST_EXCESS, counts));"),
    Fault("unmoved: nobody looks", "skipped.c",
          "if (isLittle(scene)) {\n    return true;\n  }\n  if (skipped->wait",
          "if (scene->trial->slack > 0) {\n    return true;\n  }\n  if (skipped->wait"),
    Fault("unmoved: a state that was not tested counts as free of clashes", "skipped.c",
          "if (!trial->isFree) {",
          "if (false) {"),
    Fault("unmoved: new limits change nothing", "query.c",
          "  ctClearanceForget(&tree->clearance);\n  ctSkippedForget(tree);",
          "  ctClearanceForget(&tree->clearance);"),
    Fault("unmoved: another state changes nothing", "state.c",
          "  ctSkippedForget(tree);\n",
          ""),
    Fault("unmoved: a body counts as unmoved that is turned", "trial.c",
          "sqrt(turned) * reach + sqrt(shifted)",
          "0 * sqrt(turned) * reach + sqrt(shifted)"),
    Fault("unmoved: what is nearly unmoved counts as such", "trial.c",
          "#define UNMOVED 2e-11",
          "#define UNMOVED 2e-8"),
    Fault("unmoved: leaves that a window moves stay where they are", "leaves_body.h",
          "if (u->pieces[p].body != 0) {\n        return false;",
          "if (u->pieces[p].body != 0) {\n        return true;"),
    Fault("unmoved: renewed leaves are those of before", "chaintree.c",
          "    ctSkippedForget(tree);\n    ctLeavesForget(&tree->leaves);", "    ctSkippedForget(tree);"),
    Fault("unmoved: positions lag ever farther", "leaves.c",
          "leaves->lag += slack;",
          "leaves->lag = slack;"),
    Fault("unmoved: a body of a trial has the number of a wrong one", "trial.c",
          "addPiece(trial, trial->apart[p].slotBegin, bodyOf[trial->apart[p].body]);",
          "addPiece(trial, trial->apart[p].slotBegin,\n"
          "             trial->apart[p].body == trial->motionCount - 1 ? 0 : trial->apart[p].body);"),
    Fault("undo: leaves are out of date after a look", "verdict.c",
          "  if (areLeavesKept) {\n    tree->leaves.time",
          "  if (!areLeavesKept) {\n    tree->leaves.time"),
    # ---- Leaves ----
    Fault("leaves: a twig's turn is not noticed", "leaves_body.h",
          "u->tree->contentTime[node] <= u->leaves->time && leafEnd <= u->firstMoved", "leafEnd <= u->firstMoved"),
    Fault("leaves: what moves as a whole is not noticed", "leaves_body.h",
          "<= u->leaves->time && leafEnd <= u->firstMoved", "<= u->leaves->time"),
    Fault("leaves: empty slots have positions", "leaves_body.h",
          "~occupied & 0xffff; empty", "~occupied & 0xfffe; empty"),
    Fault("leaves: a box is as far as its second slot on one side", "leaves_body.h",
          "sub16(zero, highs[2]), zero, zero}", "sub16(zero, highs[1]), zero, zero}"),
    Fault("leaves: boxes have no room for rounding", "leaves_body.h",
          "BOX_MARGIN 1.2e-7f", "BOX_MARGIN -1.2e-5f"),
    Fault("leaves: a state is not told from the one before", "verdict.c",
          "  tree->changeCount++;", ""),
    Fault("leaves: what a trial shows is of an earlier one", "trial.c",
          "  trial->isShown = false;", ""),
    Fault("leaves: motions are about worldOrigin", "trial.c",
          "motion->m[i][3] + (origin[i] - turned[i])", "motion->m[i][3]"),
    Fault("leaf pairs: of a leaf of many pieces all moves as the first", "leafpairs_body.h",
          "slotBegin <= leaf * TREE_WIDTH + i", "slotBegin <= leaf * TREE_WIDTH"),
    Fault("leaf pairs: what is at rest is where an earlier trial took it", "leafpairs_body.h",
          "leaves->trial[leaf] = leaves->state[leaf];", "(void)leaf;"),
    Fault("leaf pairs: what is at rest is where it was in an earlier state", "leaves_body.h",
          "|= (uint16_t)(1u << k);", "|= 0;"),
    Fault("leaf pairs: gaps in the trial do not count", "leafpairs_body.h",
          "*gaps = min16(*gaps, squaredGaps(after, k, others->after));", "(void)after;"),
    Fault("leaf pairs: some are listed twice", "leafpairs_body.h",
          " & ~earlier);", ");\n      (void)earlier;"),
    Fault("leaf pairs: rows of the second node are left out", "leafpairs_body.h",
          "left = others == 0 ? 0 : second.rows;", "left = 0;"),
    Fault("leaf pairs: a row is dropped that is near only one of the columns", "leafpairs_body.h",
          "left = findNearBoxes(d, b->before, b->after, b->k, &first, left, &gaps);",
          "left = findNearBoxes(d, b->before, b->before, b->k, &first, left, &gaps);"),
    Fault("leaf pairs: a moved box keeps its size", "leafpairs_body.h",
          "mul16(absolute16(r), half[e])", "mul16(all16(e == d), half[e])"),
    Fault("leaf pairs: a leaf of two bodies is of the first", "leafpairs_body.h",
          "common == body ? body : MANY_BODIES", "common == body ? body : common"),
    Fault("listed: particles without a radius are in volumes", "tree.c",
          "slot < tree->slotCount && slotIsModelled(sequence, slot)",
          "slot < tree->slotCount && sequence->slotParticle[slot] != CT_NULL"),
    Fault("listed: particles without a radius are in sweeps", "snapshot.c",
          "slot < layout->slotCount && slotIsModelled(sequence, slot)",
          "slot < layout->slotCount && sequence->slotParticle[slot] != CT_NULL"),
    Fault("listed: least distances leave them out", "sequence.h",
          "return slot != CT_NULL && slotIsModelled(s, slot) ? slot : CT_NULL;", "return slot;"),
    # ---- Traversal ----
    Fault("traversal: what straddles is not looked into", "descent_body.h",
          "return visitSelf(t, visit, level, node);", "return level == 0 || visitSelf(t, visit, level, node);"),
    Fault("traversal: a body is taken for another", "view_body.h",
          "return code == motion ? 0xffff : 0;", "return code >= 0 ? 0xffff : 0;"),
    Fault("traversal: a straddler's members are all of one body", "view_body.h",
          "motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);", "0xffff;"),
    Fault("traversal: the last member of a node is passed over", "descent_body.h",
          "for (unsigned left = near; left != 0;", "for (unsigned left = near & 0x7fff; left != 0;"),
    Fault("traversal: a mover does not meet its own leaf", "movers_body.h",
          "if (!testLeaf(t, visit, movers, leaf, ~(", "if (false && !testLeaf(t, visit, movers, leaf, ~("),
    Fault("traversal: movers that begin in their leaf meet themselves", "movers_body.h",
          "~(areHere ? movers->bits :", "~(areHere ? 0 :"),
    Fault("traversal: nodes with which trials begin stay when their members are widened", "movers_body.h",
          "if (t->firstNodesTime < tree->innerTime || ", "if ("),
    Fault("traversal: nobody is told that members are widened", "refresh_body.h",
          "    tree->innerTime = tree->time;\n    const float x", "    const float x"),
    Fault("traversal: of many nodes with which trials begin the last is not asked", "movers_body.h",
          "listNearBox(t, movers, level + 1, 0, parentCount, visit->reach, nodes);",
          "listNearBox(t, movers, level + 1, 0, parentCount, visit->reach, nodes) - 1;"),
    Fault("traversal: of many leaves near movers the first four are tested", "movers_body.h",
          "for (int i = 0; i < leafCount; i += NODES_AT_ONCE) {",
          "for (int i = 0; i < leafCount && i == 0; i += NODES_AT_ONCE) {"),
    Fault("traversal: movers meet what is before their leaves alone", "movers_body.h",
          "masks[leaf / 64] &= ~((uint64_t)1 << leaf % 64);", "masks[leaf / 64] &= ((uint64_t)1 << leaf % 64) - 1;"),
    Fault("traversal: movers meet themselves where they were, by boxes", "movers_body.h",
          "masks[leaf / 64] &= ~((uint64_t)1 << leaf % 64);", ""),
    Fault("traversal: movers meet themselves where they were, by nodes", "movers_body.h",
          "indices16(mask & ~own,", "indices16(mask,"),
    Fault("traversal: of four nodes with boxes the last is passed over", "movers_body.h",
          "for (int k = NODES_AT_ONCE - 1; k >= 0; k--) {", "for (int k = NODES_AT_ONCE - 2; k >= 0; k--) {"),
    Fault("traversal: leaves that do not exist are near", "traverse.c",
          ".ends[0][k] = INT16_MAX;", ".ends[0][k] = INT16_MIN;"),
    Fault("traversal: ends of boxes are rounded towards the middle of the scene", "movers_body.h",
          "enum { UNITS_AROUND = 2 };", "enum { UNITS_AROUND = 0 };"),
    Fault("traversal: leaves keep their boxes when their slots turn", "movers_body.h",
          "    boxNoted(t);", "    t->boxedCount = tree->notedCount;"),
    Fault("traversal: leaves keep their boxes when they move", "movers_body.h",
          "if (tree->unnotedTime > t->steadyTime) {", "if (t->steadyTime == NEVER) {"),
    Fault("traversal: boxes are dropped when the end of a chain turns", "tree.c",
          "if (end - begin > MOST_LEAVES_NOTED) {", "if (end > begin) {"),
    Fault("traversal: leaves keep their boxes when many move", "tree.c",
          "      tree->unnotedTime = tree->time;\n      return;", "      return;"),
    Fault("traversal: the last leaf of the end of a chain keeps its box", "tree.c",
          "for (int leaf = begin; leaf < end; leaf++) {", "for (int leaf = begin; leaf + 1 < end; leaf++) {"),
    Fault("traversal: positions behind the end of a chain are those from before it turned", "traverse.c",
          "transformPoint(ctTraversalLeafFrame(t, coveringNode(slot)), local, position);",
          "transformPoint(&t->frame[t->entryOf[coveringNode(slot)]], local, position);"),
    Fault("traversal: leaves that turn while nobody looks keep their boxes when they are many", "movers_body.h",
          "if (tree->notedCount - t->boxedCount > NOTED_LEAVES) {",
          "if (tree->notedCount - t->boxedCount > NOTED_LEAVES) {\n    t->boxedCount = tree->notedCount;"),
    Fault("traversal: boxes of leaves leave out radii above", "movers_body.h",
          "storeSignedShorts8(ends, least,",
          "least[3] = -most16(load16(t->world[t->entryOf[leaf]].x));\n  storeSignedShorts8(ends, least,"),
    Fault("traversal: boxes of leaves are compared with centres of movers", "movers_body.h",
          "const float around = reach - movers->box.ends[6];", "const float around = reach;"),
    Fault("traversal: boxes are made where leaves may lose their entries", "movers_body.h",
          "if (t->leafEntryCount < leaves) {", "if (false) {"),
    Fault("traversal: boxes are made without waiting", "movers_body.h",
          "t->testsToBoxes = t->testsABox * t->tree->levelSize[0] + 1;", "t->testsToBoxes = 1;"),
    Fault("traversal: boxes around surfaces serve for centres", "view_body.h",
          "    t->steadyTime = NEVER;\n", ""),
    Fault("traversal: later pieces of movers leave out the next one", "movers_body.h",
          "for (int p = own + 1; p <= last; p++) {", "for (int p = own + 2; p <= last; p++) {"),
    Fault("traversal: the box of movers leaves out radii", "movers_body.h",
          "all16(reach - box->ends[6])", "all16(reach)"),
    Fault("traversal: the box of movers is open on one side", "movers_body.h",
          "least4x16(last, box.ends + 4);", "least4x16(last, box.ends + 4);\n  box.ends[5] = INFINITY;"),
    Fault("traversal: first nodes outlive a change", "movers_body.h",
          "if (t->firstNodesTime < tree->innerTime || !treeStays(tree, t->firstNodesTime)) {",
          "if (t->firstNodesTime == NEVER) {"),
    Fault("exclusion: movers of the next leaf have those of the first", "movers_body.h",
          "e->mask[exclusionMask(e, movers->leaf + 1, leaf)]", "e->mask[exclusionMask(e, movers->leaf, leaf)]"),
    Fault("exclusion: movers that are not first in their leaf have the exclusions of others", "movers_body.h",
          "return rows + memberIndex(movers->begin);", "return rows;"),
    Fault("exclusion: movers near a slot of another leaf have no exclusions", "movers_body.h",
          "if ((t->exclusions->mask[excluded][memberIndex(slot)] >> memberIndex(mover) & 1) == 0 &&", "if ("),
    Fault("balls: a leaf that is walked on in keeps the opening before the change", "refresh_body.h",
          "if (tree->knownChange < endOfLinks) {", "if (false) {"),
    Fault("torsions: a line in a leaf points backwards", "tree.h",
          "subtract(far, near, direction);", "subtract(near, far, direction);"),
    Fault("torsions: the axis of a link in a twig is in the frame of the twig's stem", "tree.c",
          "if (link == head) {", "if (true) {"),
    Fault("torsions: the axis of a twig from another leaf is in the frame of that", "tree.c",
          "coveringNode(sequence->slotBegin[head]) == coveringNode(sequence->slotBegin[link]);", "true;"),
    Fault("torsions: an axis of no length turns", "verdict.c",
          "if (s->axisPlaces[link] == axisIsNoLine) {", "if (false) {"),
    Fault("torsions: places of axes outlive the reference", "sequence.c",
          "if (!ctSequenceCanTurn(s, link, s->reference)) {", "if (s->axisPlaces[link] == axisIsNoLine) {"),
    Fault("traversal: movers do not meet each other", "movers_body.h",
          "if (!testMovers(t, visit, &movers[i], &movers[j])) {", "if (false) {"),
    Fault("traversal: a piece ends a slot late", "trial.c",
          "addPiece(trial, s->slotBegin[end], depth", "addPiece(trial, s->slotBegin[end] + 1, depth"),
    Fault("traversal: an inner motion comes before the outer one", "trial.c",
          "transformCompose(&trial->motions[around], &trial->motions[i + 1])",
          "transformCompose(&trial->motions[i + 1], &trial->motions[around])"),
    Fault("traversal: of pairs of a leaf with itself some are left out", "descent_body.h",
          "mask &= ~alreadyVisited(rows, k);", "mask &= alreadyVisited(rows, k);"),
    Fault("traversal: of pairs of children of two nodes some are taken for those of one", "descent_body.h",
          "const unsigned later = pair->a == pair->b ? near : 0;", "const unsigned later = near;"),
    Fault("traversal: of children that are near others only the last is visited", "descent_body.h",
          "rows |= (unsigned)(mask != 0) << k;", "rows = (unsigned)(mask != 0) << k;"),
    Fault("traversal: a node stays when its parent has moved", "view_body.h",
          "return false; /* mostly:", "return true; /* mostly:"),
    Fault("updates: a walk goes on from the frame of the leaf", "refresh_body.h",
          "columnsOf(&tree->knownInLeaf, &walk.frame);", "(void)leaf;"),
    Fault("updates: a known link outlives its trial", "trial.c",
          "tree->knownLink = CT_NULL;", "(void)tree->knownLink;"),
    Fault("updates: a walk goes on behind the first of several changes", "trial.c",
          "const bool isKept = trial->count == 1 && ", "const bool isKept = "),
    Fault("traversal: kept frames are those of leaves before the last change", "tree.h",
          "return tree->changeTime[last] <= since;", "return true;"),
    Fault("traversal: kept positions outlive a change before them", "tree.h",
          "return treeFirstMoved(tree, since) >= leafEnd;", "return treeFirstMoved(tree, since) >= leafEnd - 2;"),
    # ---- Boxes ----
    Fault("box: it leaves out radii", "box.h",
          "least16(sub16(along, reach))", "least16(along)"),
    Fault("box: it leaves out the boxes within", "box.h",
          "reach = blend16(boxes->thin, reach, reachAlong(boxes, u));", ""),
    Fault("box: it has no room for rounding", "box.h",
          "1.6e-5f * (fabsf(bound->x)", "0 * (fabsf(bound->x)"),
    Fault("box: reach is left out between boxes", "box.h",
          "all16(half + reach);", "all16(half);"),
    Fault("box: reach is left out between box and sphere", "box.h",
          "all16(boxes->half[j][i] + reach)", "all16(boxes->half[j][i])"),
    Fault("box: it outlives a change of a node", "refresh_body.h",
          "tree->hasSum[node] = false;\n  tree->boxIsStale[node] = true;", "tree->hasSum[node] = false;"),
    Fault("box: axes are not turned along", "box.h",
          "store16(to->axis[i][d], dot16(m[0], m[1], m[2], from->axis[i]));",
          "store16(to->axis[i][d], load16(from->axis[i][d]));"),
    # ---- Update ----
    Fault("update: the joint at an interval's end stays", "tree.c",
          "if (end < s->linkCount) {", "if (false) {"),
    Fault("update: a node skips the first child after a change", "refresh_body.h",
          "child = moved ? child + 1 :", "child = moved ? child + 1 + (child == changed[0]) :"),
    Fault("update: the last ball joint of a leaf opens like the first", "refresh_body.h",
          "const int link = begin + i < end ? begin + i : begin;",
          "const int link = begin + i < end - 1 ? begin + i : begin;"),
    Fault("update: what comes after a changed leaf is not told", "refresh_body.h",
          "tree->shortcutTime[leaf] = tree->time;", ""),
    Fault("update: what comes after a changed node is not told", "refresh_body.h",
          "tree->shortcutTime[node] = tree->time;", ""),
    Fault("update: the node over a changed leaf is not told", "refresh_body.h",
          "tree->contentTime[leaf] = tree->time;", ""),
    Fault("update: a leaf within a twig begins where the twig does", "refresh_body.h",
          "beginsHere ? tree->stem[sequenceOpenPath(sequence, head)] : transformIdentity()",
          "tree->stem[sequenceOpenPath(sequence, head)]"),
    Fault("update: the member over a turned twig stays", "tree.c",
          "tree->instructions->widenAbove(tree, leaf);", "(void)leaf;"),
    Fault("update: who has taken over widened bounds keeps them", "tree.c",
          "    noteTightened(tree);\n", "    (void)noteTightened;\n"),
    Fault("update: bounds are widened at the lowest level alone", "refresh_body.h",
          "    child = node;\n", "    return;\n"),
    Fault("update: the bound of a leaf is not widened", "refresh_body.h",
          "bound->r = fmaxf(bound->r, away + own->r[k] + rounding);", "(void)own;"),
    Fault("update: a bound is said to hold what it does not", "refresh_body.h",
          "(away <= room * room)", "(away <= 4 * room * room)"),
    Fault("update: a branch of a twig goes on from the end of another", "refresh_body.h",
          "frames[l == link ? 0 : s->parent[l] - link + 1]", "frames[l - link]"),
    Fault("update: bounds lag for good", "tree.c",
          "if (tree->laggingCount > 0) {", "if (false) {"),
    Fault("update: of what lags the nodes above stay", "tree.c",
          "    refreshAbove(tree, 0, tree->laggingCount);\n", ""),
    Fault("update: behind a twig the sequence goes on from the twig", "sequence.h",
          "walk->stem[--walk->openCount]", "(--walk->openCount, walk->frame)"),
    Fault("update: a turn in a twig ends with the leaf", "tree.c",
          "leaf * TREE_WIDTH < s->slotBegin[done]; leaf++", "leaf == s->slotBegin[link] / TREE_WIDTH; leaf++"),
    Fault("update: a closure is not inverted", "path.c",
          "s->closure[path] = transformInverse(below);", "s->closure[path] = *below;"),
    Fault("update: the last block of a path is left out", "path.c",
          "2 * pair + 1 < n ?", "2 * pair + 2 < n ?"),
    Fault("update: a change is noted late", "tree.c",
          "tree->changedLeaf[tree->changeCount] = firstLeaf;", "tree->changedLeaf[tree->changeCount] = firstLeaf + 2;"),
    Fault("update: a sum outlives a change", "refresh_body.h",
          "tree->hasSum[leaf] = false;", ""),
    Fault("state: new positions keep the dihedrals of the old", "sequence.c",
          "      s->dihedral[link] = NAN;\n", "      ;\n"),
    # ---- Undo ----
    Fault("undo: a verdict leaves the trial applied", "verdict.c",
          "  leaveTrial(tree, areLeavesKept);\n}\n\n/* Searches the whole",
          "  (void)areLeavesKept;\n}\n\n/* Searches the whole"),
    Fault("undo: back is forward", "trial.c",
          "after ? &change->after : &change->before", "&change->after"),
    Fault("undo: a refused proposal replaces the open trial", "verdict.c",
          "if (twice != CT_NULL) {", "if (twice != CT_NULL) {\n    tree->trial.open = false;"),
    # ---- Clearances ----
    Fault("clearance: a commit takes nothing off", "clearance_body.h",
          "lessShorts(before, minShorts(own, loadShorts(c->shift + first)))", "before"),
    Fault("clearance: units are rounded up", "leafrun_body.h",
          "all16(0.999999f / c->unit)", "all16(1.01f / c->unit)"),
    Fault("clearance: a turn does not displace what is off its axis", "leafrun_body.h",
          "add16(add16(centre, turned), margin)", "add16(centre, margin)"),
    Fault("witnesses: one is believed where it does not clash", "witness_body.h",
          "isOver = !function(context,", "isOver = true || !function(context,"),
    Fault("witnesses: those of one body clash", "witness_body.h",
          "if (motionA == motionB) {", "if (motionA < 0) {"),
    Fault("clearance: straddling leaves do not meet themselves", "clearance_body.h",
          "!testStraddlingLeaves(t, &test)", "true"),
    Fault("clearance: columns begin one late", "clearance_body.h",
          "~((one << before) - 1)", "~((one << (before + 1)) - 1)"),
    Fault("clearance: what spheres leave in the trial is kept for the state", "clearance_body.h",
          "maxShorts(loadShorts(least), before)", "maxShorts(loadShorts(least), found)"),
    Fault("clearance: spheres of straddling leaves are believed", "clearance_body.h",
          "isStraddler(t, a) ? 0 : inner", "inner"),
    Fault("clearance: pairs that are unlikely to clash are forgotten", "clearance_body.h",
          "return testLeft(c, t, test, pair, firstTested, false);", "return false;"),
    Fault("clearance: spheres that move are seen where they rest", "clearance_body.h",
          "moveBlock(spheres, pair->back, 0xffff, &moved);", ""),
    Fault("clearance: of a leaf of many only one moves", "leafrun_body.h",
          "p <= many->lastPiece", "p <= many->firstPiece"),
    Fault("clearance: leaves of many do not meet each other", "leafrun_body.h",
          "        c->shift[b->begin] = MOST_CLEARANCE;", "        c->shift[b->begin] = 0;"),
    Fault("clearance: what follows a leaf of many has no leaves", "leafrun_body.h",
          "p = meetsMany ? q : p + 1;", "p = q + 1;"),
    Fault("clearance: bounds of an earlier trial are taken off", "clearance.c",
          "  c->testedCount = 0;\n  c->boundPieces = NULL;", "  c->testedCount = 0;"),
    Fault("clearance: bounds that are not all kept are taken off", "leafrun_body.h",
          "c->boundPairCount <= MOST_BOUND_PAIRS ? pieces : NULL;", "pieces;"),
    Fault("clearance: all pairs of runs have the bounds of the last", "leafrun_body.h",
          "(size_t)(pair < MOST_BOUND_PAIRS ? pair : MOST_BOUND_PAIRS - 1)", "(size_t)(pair - pair)"),
    Fault("clearance: nothing moves in the frame of what moves", "leafrun_body.h",
          "return frame == 0 ?", "return frame >= 0 ?"),
    Fault("clearance: it outlives new limits", "query.c",
          "tree->limits = fresh;\n  ctClearanceForget(&tree->clearance);", "tree->limits = fresh;"),
    Fault("clearance: it outlives a new state", "state.c",
          "ctClearanceForget(&tree->clearance);", ""),
    # ---- Exclusions ----
    Fault("exclusion: of a slot only the last counts", "exclusion.c",
          "(*mask | 1u << memberIndex(b))", "(1u << memberIndex(b))"),
    Fault("exclusion: particles of one leaf have none", "exclusion.c",
          "own == CT_NULL ? exclusions->emptyMask : own;", "exclusions->emptyMask;"),
    Fault("exclusion: it holds one way round", "exclusion.c",
          "pairs[count + 1][0] = b;", "pairs[count + 1][0] = a;"),
    Fault("exclusion: leaves after the first partner are lost in sweeps", "exclusion.h",
          "exclusions->partner[*partner] < leafB", "exclusions->partner[*partner] <= leafB"),
    Fault("exclusion: the search for a partner goes too far", "order.h",
          "values[middle] < value", "values[middle] <= value"),
    # ---- Limits ----
    Fault("limit: the search goes too far", "exclusion.c",
          "limits->keys[low + half - 1] < key", "limits->keys[low + half - 1] <= key"),
    Fault("limit: of two the lesser stays", "exclusion.c",
          "(x->value < y->value) - (x->value > y->value)", "(x->value > y->value) - (x->value < y->value)"),
    Fault("limit: a raised one is within rounding", "query.c",
          "canonical + CT_SIGMA", "canonical"),
    Fault("limit: trials know only tolerances", "verdict.c",
          "return ctLimitsFind(&tree->limits, pair[0], pair[1], tolerance);", "return tolerance;"),
    Fault("limit: within rounding of a float two movers surely clash", "movers_body.h",
          "(double)sqrtf(x * x + y * y + z * z) + visit->margin;",
          "(double)sqrtf(x * x + y * y + z * z) - visit->margin;"),
    # ---- State ----
    Fault("state: an angle grows beyond pi", "sequence.c",
          "return sum - twoPi * ((sum > pi) - (sum < -pi));", "return sum;"),
    Fault("state: many turns are taken with a short pi", "sequence.c",
          "? withoutTurns(turn) : atan2(sin(turn), cos(turn));", "? remainder(turn, twoPi) : remainder(turn, twoPi);"),
    Fault("state: reference bits are not kept", "position.c",
          "if (!isDisplaced(reader, link)) {", "if (s->particleCount < 0) {"),
    Fault("state: reference bits are not kept by modelled particles", "position.c",
          "if (isDisplaced(reader, s->slotLink[slot])) {", "if (s->particleCount > 0) {"),
    Fault("state: an array that is kept misses what came to rest at its reference", "position.c",
          "if (copied->isDisplaced[branch] != isDisplacedNow) {", "if (s->particleCount < 0) {"),
    Fault("state: an array that is kept misses what moved within leaves", "position.c",
          "if (leaf < firstMoved && tree->contentTime[leaf] <= since) {", "if (leaf < firstMoved) {"),
    Fault("state: an array that is kept misses what moved as a whole", "position.c",
          "leaf >= firstMoved || reader->tree", "leaf - 2 >= firstMoved || reader->tree"),
    Fault("state: quaternions are not normalised", "transform.h",
          "const double norm = sqrt(w * w + x * x + y * y + z * z);", "const double norm = 1;"),
    Fault("state: a placement is multiplied from the wrong side", "sequence.c",
          "quaternionMultiply(turn, joint->placement.quaternion, turned.placement.quaternion)",
          "quaternionMultiply(joint->placement.quaternion, turn, turned.placement.quaternion)"),
    Fault("state: a ball joint turns in its parent's frame as in the world", "trial.c",
          "rotateBack(&parent, change->rotation, rotation);", "memcpy(rotation, change->rotation, sizeof rotation);"),
    Fault("state: what a ball joint was before a trial is not kept", "trial.c",
          "rotateBack(&parent, change->rotation, rotation);\n      change->before = ",
          "rotateBack(&parent, change->rotation, rotation);\n      if (i == 0)\n        change->before = "),
    Fault("state: a ball joint turned twice in a trial", "trial.c",
          "      change->isTurnOfBall = false;\n    }\n", "      change->before = change->after;\n    }\n"),
    Fault("state: a ball joint turns about its lowest particle", "layout.c",
          "      joint->origin = d->linkTorsions[u][1];\n", ""),
    Fault("state: verdicts near a limit are not canonical", "verdict.c",
          "if (!ofTwoBodies || clearance >= band) {", "if (!ofTwoBodies || clearance >= 0) {"),
    # ---- Sweeps ----
    Fault("sweep: a particle meets itself", "sweep_body.h",
          "pair.excluded[k] | ((2u << k) - 1)", "pair.excluded[k] | ((1u << k) - 1)"),
    Fault("sweep: doubtful neighbours are sure", "sweep_body.h",
          "larger(task->reach - margin, 0)", "larger(task->reach + margin, 0)"),
    Fault("sweep: near boxes without margin", "sweep_body.h",
          "(float)(task->reach + margin)", "(float)(task->reach - margin)"),
    Fault("sweep: boxes that overlap along an axis are apart", "near_body.h",
          "max16(max16(above, below), all16(0))", "max16(above, below)"),
    Fault("sweep: a node has the box of its first sibling", "sweep_body.h",
          "members, others, memberIndex(node - layout->levelBegin[level]), true", "members, others, 0, true"),
    Fault("sweep: no node is passed over as a whole", "sweep_body.h",
          "if (visit->a == visit->b) {", "if (visit->level > 0) {"),
    Fault("sweep: radii of a node are those of its first", "snapshot_body.h",
          "around->r[k] = most16(load16(members->r));", "around->r[k] = members->r[0];"),
    Fault("sweep: a snapshot outlives a commit", "scene.c",
          "sweep->snapshotTime != scene->staleTree.time", "sweep->snapshotTime == NEVER"),
    # ---- Neighbours ----
    Fault("neighbours: a particle is its own neighbour", "candidates_body.h",
          "behind[TREE_WIDTH] = {0xffff,", "behind[TREE_WIDTH] = {0xfffe,"),
    Fault("neighbours: the first excluded leaf is lost", "candidates_body.h",
          "candidates->leaves[first]);", "candidates->leaves[first]) + 1;"),
    Fault("neighbours: candidates of the leaf before join", "candidates_body.h",
          "storeShorts(candidates->pairs + count, allShorts(0));", ""),
    Fault("neighbours: doubts about those compared ahead stay", "candidates_body.h",
          "settleDoubts(pass, leaf, next);", ";"),
    Fault("neighbours: only so many leaves are looked at", "candidates_body.h",
          "first < leafCount && goesOn", "first < 1 && goesOn"),
    Fault("neighbours: leaves before one are listed again", "candidates_body.h",
          "near &= other == node ? ~0u << k : ~0u;", ""),
    Fault("neighbours: nodes before one are listed again", "candidates_body.h",
          "near &= over > first ? ~0u << (over - first) : ~0u;", ""),
    Fault("neighbours: the particle of the earlier slot is the lower", "candidates_body.h",
          "candidates->rises = sweep->highest[leaf] < lowest;", "candidates->rises = true;"),
    Fault("neighbours: lists are taken to ascend", "order.c",
          "if (pairsAscend(count, firsts, seconds)) {", "if (count > 0) {"),
    # ---- Least distances, probe, energy ----
    Fault("nearest: a particle is its own neighbour", "nearest_body.h",
          "other->members & ~itself(clouds, side, one->node, k, other->node)", "other->members"),
    Fault("nearest: a pair of another set bounds the search", "nearest.c",
          "one->nearest[0] == CT_NULL || !ctSelectionHolds(other, one->nearest[1])", "one->nearest[0] == CT_NULL"),
    Fault("nearest: of pairs equally near the first is taken", "nearest.c",
          "distance < n->distance || (distance == n->distance && isBefore(pair, n->pair))", "distance < n->distance"),
    Fault("nearest: clusters are parted too early", "nearest_body.h",
          "all16(other->r + n->reach)), all16(0))", "all16(0.9f * (other->r + n->reach))), all16(0))"),
    Fault("nearest: what is not modelled is left out", "nearest.c",
          "if (selection->unmodelledCount > 0) {", "if (selection->unmodelledCount > 1) {"),
    Fault("probe: its radius does not count", "traverse_body.h",
          "(float)point[2], (float)radius}", "(float)point[2], 0}"),
    Fault("energy: both forces point one way", "query.c",
          "energy->forces[3 * (size_t)particleB + d] -= force;", "energy->forces[3 * (size_t)particleB + d] += force;"),
    Fault("energy: the tolerance is forgotten", "query.c",
          "const double depth = overlap - pairTolerance(tree, slotA, slotB);", "const double depth = overlap;"),
    # ---- Instruction sets ----
    Fault("portable: the last quarter is compared like the third", "../../simd/simd.h",
          "bits4(a.q[3] > b.q[3]) << 12", "bits4(a.q[2] > b.q[2]) << 12"),
    Fault("avx2: a blend takes the low half twice", "../../simd/simd.h",
          "lanes8(mask >> 8))}", "lanes8(mask))}"),
]
ENERGY_FAULTS = [
    # ---- Borders ----
    Fault("border: negative counts of exclusions pass", "nonbonded.c",
          "if (d->exclusionCount < 0 || d->exclusionCount", "if (d->exclusionCount"),
    Fault("border: a pair set that is not there has an energy", "energy.c",
          "pairSet >= 0 && pairSet < energy->pairs.sets.count", "pairSet >= 0"),
    Fault("border: constants of the stand-in may be anything", "energy.c",
          "if (!isFarPart(constants[i])) {", "if (false) {"),
    Fault("border: a state that was set is taken for that of the trial", "energy.c",
          "energy->commits + 1 != ctGetCommitCount(energy->tree) || ", ""),
    Fault("border: maps may have any size", "termset.c",
          "map->size < 1 || patches > CT_MOST_COUNT / 16", "map->size < 1"),
    # ---- What lags behind closed windows ----
    Fault("lag: values are never computed anew", "energy.c",
          "return lag(energy) <= CT_MOST_LAG ? ctSuccess : ctRefreshEnergy(energy, NULL);",
          "return lag(energy) >= 0 ? ctSuccess : ctRefreshEnergy(energy, NULL);"),
    Fault("lag: values are computed anew from positions that lag", "energy.c",
          "  ctRenew(energy->tree);\n",
          ""),
    # ---- Pairs: formulas ----
    Fault("pairs: the reaction field has another k", "nonbonded.c",
          "(d->dielectric - 1) / (both *", "d->dielectric / (both *"),
    Fault("pairs: the reaction field does not vanish at the cutoff", "nonbonded.c",
          "3 * d->dielectric / (both * d->cutoff)", "2 * d->dielectric / (both * d->cutoff)"),
    Fault("pairs: the switch ends at the wrong distance", "nonbonded.c",
          "p->exact[4] = 1 / (d->cutoff - d->switchingDistance);", "p->exact[4] = 1 / d->cutoff;"),
    Fault("pairs: the switch has another polynomial", "switching16.h",
          "sub16(all16(15), mul16(t, all16(6)))", "sub16(all16(15), mul16(t, all16(5)))"),
    Fault("pairs: the switch is at work before its distance", "switching16.h",
          "mul16(max16(sub16(distance, all16(switchingDistance)), all16(0)),",
          "mul16(sub16(distance, all16(switchingDistance)),"),
    Fault("pairs: sigmas are not halved", "nonbonded.c",
          "(float)(d->sigmas[i] / 2)", "(float)(d->sigmas[i])"),
    Fault("pairs: where floats overflow, exclusions are forgotten", "nonbonded.c",
          "& ~(a->excluded != NULL ? (unsigned)a->excluded[k] : 0)", ""),
    Fault("pairs: rows close to the cutoff are left out", "rowsnear.h",
          "#define ROUNDING_OF_BOXES 1.0001f", "#define ROUNDING_OF_BOXES 0.9f"),
    Fault("pairs: a leaf's box is where its own centre is", "rowsnear.h",
          "all16(b->low[d] + shift[d])", "all16(b->low[d])"),
    Fault("pairs: rows of the second leaf are shifted the wrong way", "kernels_body.h",
          "    from = back;\n", ""),
    Fault("pairs: the last row of a part is left out", "kernels_body.h",
          "        part = add16(part, energy);\n", "        part = n < 3 ? add16(part, energy) : part;\n"),
    Fault("pairs: Lennard-Jones without a cutoff is left out", "kernels_body.h",
          "    sum = addToSum16(sum, tails);", "    ;"),
    # ---- Pairs: exclusions ----
    Fault("masks: the mask is transposed", "nonbonded.c",
          "const uint16_t* excluded = pairMaskOf(&nonbonded->mask, a, b);",
          "const uint16_t* excluded = pairMaskOf(&nonbonded->mask, b, a);"),
    Fault("masks: they are known one way round", "pairmask.c",
          "    exclude(mask, slotOf[pairs[i][1]], slotOf[pairs[i][0]]);\n", ""),
    Fault("masks: each particle meets itself", "pairmask.c",
          "lower <= k; lower++", "lower < k; lower++"),
    Fault("masks: those without a cutoff do not hold for Lennard-Jones", "kernels_body.h",
          "          lennardJones = keep16(~(unsigned)a->excluded[k], lennardJones);\n", ""),
    Fault("masks: those with a cutoff do not hold", "kernels_body.h",
          "          energy = keep16(~(unsigned)a->excluded[k], energy);\n", ""),
    # ---- Pairs: what is kept ----
    Fault("sums: sums of accepted trials are not written", "pairsums.c",
          "      pairs->sums.rows[staged->a].sums[staged->kept] = staged->sum;\n", "      ;\n"),
    Fault("sums: pairs that an accepted trial brings near are forgotten", "pairsums.c",
          "isKept = isKept && ctLeafSumsAdd(&pairs->sums, staged->a, staged->b, staged->sum);", ";"),
    Fault("sums: what a discarded trial had stays", "trialleaves.c",
          "  leaves->trial++;\n", ""),
    Fault("sums: frames outlive an accepted trial", "trialleaves.c",
          "        leaves->frameIsStale[leaf] = true;\n      }\n    }", "        ;\n      }\n    }"),
    Fault("sums: of moved leaves the last keeps its frame", "trialleaves.c",
          "leaf * CT_LEAF_WIDTH < end; leaf++) {\n        leaves->frameIsStale",
          "(leaf + 1) * CT_LEAF_WIDTH < end; leaf++) {\n        leaves->frameIsStale"),
    Fault("sums: frames outlive new positions", "trialleaves.c",
          "  for (int leaf = 0; leaf < leaves->leafCount; leaf++) {\n    leaves->frameIsStale[leaf] = true;\n  }\n",
          "  static bool wasHere;\n  for (int leaf = 0; leaf < leaves->leafCount && !wasHere; leaf++) {\n"
          "    leaves->frameIsStale[leaf] = true;\n  }\n  wasHere = true;\n"),
    Fault("sums: sums outlive new positions", "pairsums.c",
          "  ctLeafSumsClear(&pairs->sums);\n",
          "  if (pairs->trial == 0) {\n    ctLeafSumsClear(&pairs->sums);\n  }\n"),
    Fault("sums: a leaf moves only if its last slot does", "trialleaves.c",
          "while (piece->body == 0 && piece->slotBegin > begin) {",
          "while (false) {"),
    Fault("sums: a sum is found in the next place", "sortedleaves.h",
          "leaves[begin + half - 1] < leaf ?", "leaves[begin + half - 1] <= leaf ?"),
    Fault("sums: of many pairs of leaves the first are forgotten", "pairsums.c",
          "        stageFew(pairs, few, framed, change);\n        few = 0;\n", "        few = 0;\n"),
    Fault("sums: making room loses a sum", "leafsums.c",
          "    if (row->sums[i] != 0) {", "    if (row->sums[i] != 0 && i != 5) {"),
    # ---- Pair expressions ----
    Fault("tape: a result takes a place that is still in use", "tape.c",
          "if (plan->lastUse[need] == i && !isRepeated) {", "if (!isRepeated) {"),
    Fault("tape: roots of columns are not taken", "tape.c",
          "kind->isRoot ? sqrt(number) : number", "number"),
    Fault("tape: factors of columns are forgotten", "tape.c",
          "kind->factor * (kind", "(kind"),
    Fault("tape: columns of both sides are mixed up", "tapesteps_body.h",
          "lookup16(firsts[v] + first, isSwapped ? lanes : rows)", "lookup16(firsts[v] + first, rows)"),
    Fault("tape: what fills the last sixteen counts", "tapekernels_body.h",
          "add16(few, keep16((2u << (inLast - 1)) - 1, value))", "add16(few, ((void)inLast, value))"),
    Fault("tape: a full last sixteen does not count", "tapekernels_body.h",
          "keep16((2u << (inLast - 1)) - 1, value)", "keep16((1u << inLast % CT_LEAF_WIDTH) - 1, value)"),
    Fault("tape: the least of two is the greater", "tapesteps_body.h",
          "EACH_SIXTEEN(chooseBelow16(b, a, b, a));", "EACH_SIXTEEN(chooseBelow16(a, b, b, a));"),
    Fault("tape: what is subtracted from comes first", "tapesteps_body.h",
          "EACH(sub16(c, value));", "EACH(sub16(value, c));"),
    Fault("tape: what a step goes on with is what it began with", "tape.c",
          "node->arguments[node->arguments[0] == first ? 1 : 0], 2);", "begin->arguments[0], 2);"),
    Fault("tape: all leaves of a batch have the columns of its last", "tapekernels_body.h",
          "batch->columns[0][batch->count + v] =", "batch->columns[0][v] ="),
    Fault("tape: energies of a batch go to the first pairs of leaves", "tapekernels_body.h",
          "energies[part->number] =", "energies[i] ="),
    Fault("tape: a batch may be too full for the next leaves", "tapekernels_body.h",
          "batch->count + __builtin_popcount(rows) > MOST_SIXTEENS", "batch->count > MOST_SIXTEENS - 1"),
    Fault("tape: sums in single precision are left out, but for the last", "tapekernels_body.h",
          "      sum = addToSum16(sum, few);\n", ""),
    Fault("tape: the inverse of the distance is rough", "../../simd/elementary.h",
          "add16(all16(0.5f), mul16(all16(0.375f), h))", "all16(0.5f)"),
    Fault("tape: odd powers are those below", "tapegraph.c",
          "multiply(b, x, wholePower(b, x, n - 1))", "wholePower(b, x, n - 1)"),
    Fault("tape: the reciprocal of a distance's power is that of its first factor", "tapegraph.c",
          "return multiply(b, inverseOfFirst, reciprocal(b, second));", "(void)second;\n  return inverseOfFirst;"),
    Fault("tables: a periodic one is not", "pairtable.h",
          "    part -= floor(part);\n", "    ;\n"),
    Fault("tables: numbers are not rounded", "pairtable.h",
          "(size_t)(numbers[d] + 0.5)", "(size_t)numbers[d]"),
    Fault("tables: patches are found by the other number first", "pairtable.h",
          "interval[0] + (size_t)table->sizes[0] * interval[1]", "interval[1] + (size_t)table->sizes[0] * interval[0]"),
    Fault("groups: a pair that both orders give counts twice", "pairgroups.c",
          "times[k][l] += (int)(paired >> l & 1);",
          "times[k][l] += (int)(paired >> l & 1) * (shared.a->members[0] == shared.a->members[1] ? 2 : 1);"),
    Fault("groups: pairs of two groups count once", "pairset.c",
          "found == PAIRS_COUNT_OFTEN ? opened->times : NULL", "NULL"),
    Fault("groups: the first set meets the second in one order alone", "pairgroups.c",
          " | (a->members[1] >> k & 1 ? b->members[0] : 0)", ""),
    Fault("values: of a block with itself each pair counts in one order", "valueenergy.c",
          "      if (a == b) {", "      if (false) {"),
    Fault("values: excluded pairs count", "valueenergy.c",
          "tape->extent == ctOfPairs ? 0 : 1", "1"),
    Fault("values: pairs read the values of an earlier state", "valueenergy.c",
          "  double sum = 0;\n  setColumns(energy, tape);\n", "  double sum = 0;\n"),
    Fault("values: coordinates are those of an earlier state", "valueenergy.c",
          "memcpy(numbersOf(energy, particle + 1) - 3, position,", "memcpy(placed.x, position,"),
    Fault("values: those of a trial are of the state", "valueenergies.c",
          "if (!inTrial) {", "if (true) {"),
    Fault("values: where floats overflow, pairs are not finite", "valueenergy.c",
          "isfinite(ofPair) ? ofPair", "true ? ofPair"),
    Fault("values: where floats overflow, sums are not finite", "tapekernels_body.h",
          "    if (!isfinite(ofRows[k])) {", "    if (false) {"),
    Fault("values: in double there is no cutoff", "valueenergy.c",
          "if (distance < energy->cutoff) {", "if (true) {"),
    Fault("values: blocks near the cutoff are left out", "valueenergy.c",
          "> energy->cutoff * energy->cutoff)", "> 0.7 * energy->cutoff * energy->cutoff)"),
    Fault("values: a row that lacks some pairs is summed as a whole one", "tapekernels_body.h",
          "left >= CT_LEAF_WIDTH && rowOf", "rowOf"),
    Fault("values: roots of products are taken apart where they may not", "tapegraph.c",
          "if (b->mayChange[operation]) {", "if (false) {"),
    Fault("values: they can read those after them", "valuechecks.c",
          "value >= valueCount && value < d->valueCount", "false && value >= valueCount"),
    Fault("pair sets: where floats overflow, the switch is forgotten", "pairset.c",
          "if (!(distance > set->switchingDistance)) {", "if (true) {"),
    Fault("pair sets: exclusions hold without groups alone", "pairset.c",
          "(set->hasGroups ? allowed[k] : ~0u) & ~(unsigned)excluded[k]",
          "(set->hasGroups ? allowed[k] : ~(unsigned)excluded[k])"),
    Fault("pair sets: their near changes are left out", "allpairs.c",
          "*change = pairs->nearChange + ofStandIn;", "*change = pairs->nearChange + ofStandIn - ofSets;"),
    Fault("pair sets: on the way back their near changes are left out", "allpairs.c",
          "  pairs->nearChange = ofSums + ofSets;\n  *change = pairs->nearChange + ofStandIn;",
          "  pairs->nearChange = ofSums;\n  *change = ofSums + ofSets + ofStandIn;"),
    # ---- Parts of a trial ----
    Fault("parts: near is judged by the trial alone", "../../chaintree/src/leafpairs_body.h",
          "*gaps = min16(*gaps, squaredGaps(after, k, others->after));",
          "*gaps = squaredGaps(after, k, others->after);"),
    Fault("parts: near is judged by the state alone", "../../chaintree/src/leafpairs_body.h",
          "    *gaps = min16(*gaps, squaredGaps(after, k, others->after));", "    (void)after;"),
    Fault("parts: the other pairs are computed with the near ones, too", "trialleaves.h",
          "*count = near ? leaves->nearCount :", "*count = near ? leaves->changedCount :"),
    Fault("parts: the other pairs are left out", "trialleaves.h",
          "leaves->changedCount - leaves->nearCount;", "0;"),
    Fault("parts: parts of another trial are taken", "energy.c",
          "if (part == ctTermsPart || energy->trial != trial) {", "if (part == ctTermsPart) {"),
    Fault("parts: a trial is accepted without all parts", "energy.c",
          "energy->computedParts != CT_ENERGY_PARTS || ", ""),
    Fault("parts: a trial is accepted that was not asked about", "energy.c",
          " || energy->trial != ctGetTrialCount(energy->tree)", ""),
    Fault("parts: accepting forgets terms", "energy.c",
          "  ctTermsAccept(energy->terms);\n", ""),
    Fault("parts: a refresh forgets terms", "energy.c",
          "  ctTermsRefresh(energy->terms, leaves);\n", ""),
    # ---- Taking back ----
    Fault("taken back: terms stay", "energy.c",
          "  ctTermsTakeBack(energy->terms);\n", ""),
    Fault("taken back: sums of pairs stay", "pairsums.c",
          "  ctLeafSumsCopy(&pairs->keptSums, &pairs->sums);\n", ""),
    Fault("taken back: particles stay where they were", "allpairs.c",
          "  ctTrialLeavesForget(&pairs->leaves);\n",
          "  pairs->leaves.statePositions = ctGetLeaves(pairs->leaves.tree);\n"),
    Fault("taken back: what was kept of no state is of one", "energy.c",
          "  if (energy->copyIsOfState) {\n", "  {\n"),
    Fault("taken back: what was kept with other constants is of the state", "energy.c",
          "  energy->state = NO_STATE;\n  energy->copyIsOfState = false;", "  energy->state = NO_STATE;"),
    Fault("taken back: leaves of the stand-in stay", "standin.c",
          "  memcpy(standIn->leafSums, standIn->copyOfSums,", "  memmove(standIn->leafSums, standIn->leafSums,"),
    Fault("taken back: records of pairs stay", "neighbors.c",
          "    memcpy(copy->records, original->records, pairs * sizeof *copy->records);\n", ""),
    Fault("taken back: rows keep those that came after", "neighbors.c",
          "    to->count = from->count;\n", ""),
    Fault("taken back: numbers that a dropped trial took are lost", "standin.c",
          "      ctNeighborsRelease(&standIn->copyOfNeighbors, standIn->staged[i].pair);\n", "      ;\n"),
    Fault("whole energy: of two rows, both have the first one's distance", "wholepair_body.h",
          "rows->inverse[i + 1] = sqrt16(mul16(both, rows->squared[i]));",
          "rows->inverse[i + 1] = sqrt16(mul16(both, rows->squared[i + 1]));"),
    Fault("whole energy: rows are apart as soon as some pair is", "wholepair_body.h",
          "if (greater16(least, all16(4 * WHOLE_APART)) == 0xffff) {",
          "if (greater16(least, all16(4 * WHOLE_APART)) != 0) {"),
    Fault("whole energy: rows are far that are near enough for the power of two", "wholepair_body.h",
          "#define WHOLE_FAR 12.0f", "#define WHOLE_FAR 4.0f"),
    Fault("whole energy: rows are apart where the polynomial ends", "wholepair_body.h",
          "#define WHOLE_APART 2.0f", "#define WHOLE_APART 0.5f"),
    Fault("whole energy: a shift without a cutoff is left out", "wholeenergy.c",
          " && model->shift == 0;", ";"),
    Fault("Born sums: remote leaves have the second term twice", "born_body.h",
          "const Float16 third = load16(columnsB->remote[2]);",
          "const Float16 third = load16(columnsB->remote[1]);"),
    Fault("Born sums: leaves with empty slots are summed as full ones", "born_body.h",
          "const bool areFull = (a.occupied & b.occupied) == 0xffff;", "const bool areFull = true;"),
    Fault("Born sums: rows begin with those of the leaves before", "born_body.h",
          "first, first + LEAVES_IN_FLOAT, sums);", "0, first + LEAVES_IN_FLOAT, sums);"),
    # ---- The stand-in ----
    Fault("stand-in: the surface is that of the sphere without the probe", "standin.c",
          "pow(d->radii[i] + d->probeRadius, 2)", "pow(d->radii[i], 2)"),
    Fault("stand-in: near sums of the second leaf are left out", "standin.c",
          "    addAll(stateLeaf(standIn, b)->born, bornOf(record, 1));\n", ""),
    Fault("stand-in: first order of the second leaf is left out", "standin.c",
          "        addAll(stateLeaf(standIn, b)->gradient, gradientOf(record, 1));\n", ""),
    Fault("stand-in: of a leaf with itself, single particles are exchanged", "standin.c",
          "  if (a->leaf == b->leaf || __builtin", "  if (__builtin"),
    Fault("stand-in: what is exchanged had the radii of the trial", "standin.c",
          "  sideA[1].radii = &stateLeaf(standIn, a->leaf)->radii;\n", ""),
    Fault("stand-in: what is exchanged had the value at the cutoff of the trial", "standin.c",
          "  sideB[1].shift = stateShift(standIn, b->leaf);\n", ""),
    Fault("stand-in: masks of exclusions are those of the first leaf", "standin.c",
          ".excluded = pairMaskOf(&standIn->nonbonded.mask, leaf, other)",
          ".excluded = leaf < other ? pairMaskOf(&standIn->nonbonded.mask, leaf, other)\n"
          "                                             : pairMaskOf(&standIn->nonbonded.mask, other, leaf)"),
    Fault("stand-in: near sums are taken for far ones", "allpairs.c",
          "near[i] = far[i] - near[i];", "near[i] = far[i];"),
    Fault("stand-in: constants are renewed from an earlier state", "energy.c",
          "  const ctStatus status = ctRefreshEnergy(energy, counts);\n  if (status != ctSuccess || !hasStandIn",
          "  const ctStatus status = ctSuccess;\n  if (status != ctSuccess || !hasStandIn"),
    Fault("stand-in: renewed constants do not reach the energy", "energy.c",
          "  energy->copyIsOfState = false;\n  return ctRefreshEnergy(energy, counts);",
          "  energy->copyIsOfState = false;\n  return ctSuccess;"),
    Fault("stand-in trials: the way back has the radii of the state", "standintrial.c",
          "      back = record.energy;\n", ""),
    Fault("stand-in trials: numbers of dropped trials are lost", "standintrial.c",
          "      ctNeighborsRelease(&standIn->neighbors, standIn->staged[i].pair);\n", "      ;\n"),
    Fault("stand-in trials: radii that cross change moved pairs alone", "standintrial.c",
          "    if (standIn->trial[leaf].crossing == 0) {\n", "    if (true) {\n"),
    Fault("stand-in trials: the other leaf's radii do not count", "standintrial.c",
          "(crossing(standIn, staged->a) | crossing(standIn, staged->b)) != 0", "crossing(standIn, staged->a) != 0"),
    Fault("stand-in trials: both leaves get the first one's Born sums", "standintrial.c",
          "const float* to = bornOf(after, side);", "const float* to = bornOf(after, 0);"),
    Fault("stand-in trials: moved pairs are exchanged, too", "standintrial.c",
          "if (record->stamp != standIn->leaves->trial && record->hasPairs) {", "if (record->hasPairs) {"),
    Fault("stand-in trials: nobody knows which pairs move", "standintrial.c",
          "    record->stamp = leaves->trial;\n", ""),
    Fault("stand-in trials: pairs that are staged are lost where more need room", "standintrial.c",
          "(void**)&standIn->staged, (size_t)standIn->stagedCount,", "(void**)&standIn->staged, 0,"),
    Fault("stand-in trials: pairs are sought in the row of one of their leaves as if in that of the other",
          "standintrial.c", "moved, changed->a + changed->b - moved", "moved, changed->b"),
    Fault("stand-in trials: pairs that part keep what they had", "standintrial.c",
          "    if (found == CT_NULL && !hasPairs(&rows) && !hasBorn(&rows)) {\n",
          "    if (!hasPairs(&rows) && !hasBorn(&rows)) {\n"),
    Fault("stand-in trials: leaves that part keep their Born sums", "standintrial.c",
          "side < 2 && (before->hasBorn || after->hasBorn)", "side < 2 && after->hasBorn"),
    Fault("stand-in trials: leaves that part keep their derivatives", "standintrial.c",
          "  if (!before->hasPairs && !after->hasPairs) {\n", "  if (!after->hasPairs) {\n"),
    Fault("stand-in trials: accepted pairs have their former energy", "standintrial.c",
          "  copyPairs(after, &neighbors->records[staged->pair]);\n", ""),
    Fault("stand-in trials: accepted pairs have their former Born sums", "standintrial.c",
          "  copyBorn(after, &neighbors->records[staged->pair]);\n", ""),
    Fault("stand-in trials: accepted pairs that do not move have their former energy", "standintrial.c",
          "    copyPairs(&standIn->staged[i].after, recordOf(standIn, &standIn->staged[i]));\n", "    ;\n"),
    Fault("stand-in trials: pairs that part are kept in no row, nor given back", "standintrial.c",
          "    ctNeighborsRelease(neighbors, staged->pair);\n    return true;", "    return true;"),
    Fault("stand-in pairs: salt does not change the slope", "standin_body.h",
          "mul16(charges, sub16(mul16(perDielectric, inverseF), mul16(all16(model->kappa), screening)));",
          "mul16(charges, mul16(perDielectric, inverseF));"),
    Fault("stand-in pairs: nothing is taken from excluded ones", "standin_body.h",
          "sum = sub16(unbound, born);",
          "sum = sub16(unbound, its.isMasked ? keep16(direct, born) : born);"),
    Fault("stand-in pairs: those of two chosen particles count twice", "standin_body.h",
          "rows[1].lanes = ~slotsOfA;", "rows[1].lanes = 0xffff;"),
    Fault("stand-in pairs: of a leaf with itself, each counts twice", "standin_body.h",
          "isSelf ? 0xfffeu << k : rows->lanes", "isSelf ? 0xffffu & ~(1u << k) : rows->lanes"),
    Fault("stand-in radii: the grid neglects without its first order", "standin_body.h",
          "store16(radii->beyond, mul16(all16(STANDIN_GRADIENT), sub16(log, ofGrid)));",
          "store16(radii->beyond, all16(0));"),
    Fault("stand-in radii: salt does not screen single particles", "standin_body.h",
          "mul16(screening, all16(model->perDielectrics[1])));\n  }\n  const Float16 inverse3",
          "all16(model->perDielectrics[1]));\n    (void)screening;\n  }\n  const Float16 inverse3"),
    Fault("stand-in shift: salt is forgotten", "standinshift.c",
          "exp(-d->born->kappa * f)", "1.0"),
    Fault("stand-in shift: products have one sign", "standinshift.c",
          "sign[rank] = value < 0 ? -1.0f : 1.0f;", "sign[rank] = 1.0f;"),
    Fault("stand-in shift: the slope is twice as steep", "standinshift.c",
          "/ (2 * step *", "/ (step *"),
    Fault("stand-in shift: it does not bend within the cutoff", "standinshift.c",
          "    model->fade[i] = (float)((double)fade[i] / pow(squared, i + 2));\n",
          "    model->fade[i] = i == 0 ? (float)((double)fade[i] / pow(squared, i + 2)) : 0;\n"),
    Fault("stand-in shift: what is taken from Born sums is the same at any distance", "standinshift.c",
          "(float)((double)bornFade[1] / (3 * bornSquared * bornSquared * bornSquared));", "0;"),
    Fault("stand-in Born: nothing is taken where particles overlap", "standinborn_body.h",
          "    forRow = sub16(forRow, mul16(load16(columnsB->cubedScaled), taken));\n", ""),
    Fault("stand-in Born: rows without an overlap hide those with one", "standinborn_body.h",
          "    overlapping[count] = i;\n", "    overlapping[count] = count;\n"),
    Fault("stand-in Born: necks end nowhere", "standinborn_body.h",
          "    if (areCut) {\n", "    if (false) {\n"),
    Fault("stand-in: rows near a leaf are those near enough for a Born sum", "standin_body.h",
          "rows->pairs[side] = (uint16_t)~greater16(squared, pairs);",
          "rows->pairs[side] = (uint16_t)~greater16(squared, born);"),
    Fault("stand-in Born: lanes beyond the cutoff count", "standinborn_body.h",
          "keepBelow16(rows.squared[i], cutoff, rows.forLanes[i])", "rows.forLanes[i]"),
    Fault("stand-in Born: a particle is near itself", "standinborn_body.h",
          "squared = blend16(1u << k, squared, all16(FARTHEST * FARTHEST));", ";"),
    Fault("stand-in shift: its slope does not fade", "standin_body.h",
          "mul16(fade, atCutoff(one, all, VALUE_RANK, SLOPE_RANK));", "atCutoff(one, all, VALUE_RANK, SLOPE_RANK);"),
    Fault("stand-in radii: the grid is as wide for any charge", "standin.c",
          "gridWidth * ctStandInGridFactor(d->charges[i])", "gridWidth"),
    Fault("neighbours: numbers that are free stay so when all are forgotten", "neighbors.c",
          "  neighbors->freeCount = 0;\n", ""),
    Fault("neighbours: records are lost where more need room", "neighbors.c",
          "(void**)&neighbors->records, (size_t)neighbors->pairCount,", "(void**)&neighbors->records, 0,"),
    Fault("neighbours: a new pair has the record of a former one", "neighbors.c",
          "  record->hasPairs = record->hasBorn = false;\n", ""),
    # ---- Whole energies ----
    Fault("Born: necks of two types are mixed up", "born.c",
          "const int forOne = type + types * columns->neckType[k];",
          "const int forOne = columns->neckType[k] + types * type;"),
    Fault("Born: necks reach as far as spheres touch", "born.c",
          "greater(2 * radius + d->neckCut, 0)", "greater(2 * radius, 0)"),
    Fault("Born: beta rescales the other way", "born.c",
          "(particle->gamma * p - particle->beta)", "(particle->gamma * p + particle->beta)"),
    Fault("Born: a surface has the fifth power", "born.c",
          "(ratio * ratio * ratio) * (ratio * ratio * ratio);", "(ratio * ratio * ratio) * (ratio * ratio);"),
    Fault("Born: salt does not screen single particles", "born.c",
          "exp(-model->exactKappa * bornRadius)", "1.0"),
    Fault("Born: particles that coincide have a sum that is not finite", "born_body.h",
          "      squared = max16(squared, all16(NEAREST * NEAREST));\n", "      ;\n"),
    Fault("Born: spheres within others are not filled for rows", "born_body.h",
          "forRow = isSame ? forRow : add16(forRow, fillingOf", "forRow = true ? forRow : add16(forRow, fillingOf"),
    Fault("Born: lanes of far rows have the series of remote ones", "born_body.h",
          "? columnsA->remote : columnsA->far;", "? columnsA->far : columnsA->remote;"),
    Fault("Born: logarithms where a small sphere is close are those of near spheres", "born_body.h",
          "if (__builtin_expect(isSteep != 0, 0)) {", "if (false) {"),
    Fault("whole energy: Born sums of the second block go to the first", "born_body.h",
          "double* sumsOfB = sums + CT_LEAF_WIDTH * other;", "double* sumsOfB = sums + CT_LEAF_WIDTH * leaf;"),
    Fault("whole energy: blocks behind the last one with excluded pairs are left out", "wholeenergy.c",
          "if (first < whole->blockCount) {", "if (first < 0) {"),
    Fault("whole energy: of a run with blocks that overflow, the others are left out", "wholeenergy.c",
          "                            ? pair.nonbonded\n", "                            ? 0\n"),
    Fault("whole energy: Born sums are in the order of slots", "wholeenergy.c",
          "sums[whole->particles[place]] = whole->sums[place];", "sums[place] = whole->sums[place];"),
    Fault("whole energy: a radius that is none is taken", "wholeenergy.c",
          "radius > 0 && isfinite(radius) ?", "radius == radius ?"),
    Fault("whole energy: where floats overflow, it is infinite", "wholeenergy.c",
          "if (isfinite(run.nonbonded)) {", "if (true) {"),
    Fault("whole energy: blocks are as far apart as their middles", "blockgap.h",
          "const double below = shift + (double)b->low[d] - (double)a->high[d];", "const double below = shift;"),
    Fault("whole energy: Born pairs end at the other cutoff", "wholeenergy.c",
          "if (gap < model->exactCutoff) {", "if (gap < potential->exact[0]) {"),
    Fault("whole energy: excluded pairs have no Born energy", "wholepair_body.h",
          "energy = keep16(a->frame == b->frame ? 0xfffeu << k : 0xffff, energy);",
          "energy = keep16(~(unsigned)(a->excluded != NULL ? a->excluded[k] : 0), energy);"),
    # ---- Terms ----
    Fault("terms: a list misses a joint", "dependence.c",
          "if (movesSome && leavesSome) {", "if (movesSome && leavesSome && joints->count < 2) {"),
    Fault("terms: joints of the second dihedral of a map are left out", "dependence.c",
          "first < set->particlesPerTerm; first += width", "first < width; first += width"),
    Fault("terms: particles on the far end of an axis turn", "dependence.c",
          "particle == scene->linkTorsions[link][1] || ", ""),
    Fault("terms: a free joint has an axis", "dependence.c",
          "    default:\n      return false;\n  }\n}\n\n/* ---- The joints",
          "    default:\n      return particle == scene->linkTorsions[link][1];\n  }\n}\n\n/* ---- The joints"),
    Fault("terms: a ball joint has an axis", "dependence.c",
          "    case ctBallJoint:\n      return particle == scene->linkTorsions[link][1];\n", "    case ctBallJoint:\n"
          "      return particle == scene->linkTorsions[link][1] || particle == scene->linkTorsions[link][2];\n"),
    Fault("terms: one that two joints change counts twice", "terms.c",
          "        if (terms->stamps[term] == terms->stamp) {\n          continue;\n        }\n", ""),
    Fault("terms: positions of the trial are those of the state", "terms.c",
          "if (view->pieceCount > 0) {\n      moveByBody", "if (false) {\n      moveByBody"),
    Fault("terms: places of the term before are kept", "terms.c",
          "    terms->slots[p] = CT_NULL;", "    ;"),
    Fault("terms: those of one particle stay", "terms.c",
          "    changeSingles(&change);\n", ""),
    Fault("terms: wide ones stay", "terms.c",
          "    changeAcross(&change);\n", ""),
    Fault("terms: wide ones that are anchored stay where they move as one", "terms.c",
          "view->pieces[piece].body != 0 && set->isAnchored", "false"),
    Fault("terms: a discarded trial's are accepted with the next", "terms.c",
          "  Change change = {.evaluation = beginEvaluation(terms, view)};\n  terms->changedCount = 0;\n",
          "  Change change = {.evaluation = beginEvaluation(terms, view)};\n  terms->changedCount %= 3;\n"),
]
FORCE = "openmmapi/src/StericExclusionForce.cpp"
FORCE_XML = "serialization/src/StericExclusionForceProxy.cpp"
BORN_READER = "openmmapi/src/BornReader.cpp"
ENERGY_CHECK = "openmmapi/src/NativeEnergyCheck.cpp"
ENERGY_PLAN = "openmmapi/src/EnergyPlan.cpp"
EXPRESSIONS = "openmmapi/src/ExpressionTranslator.cpp"
FORCE_TRANSLATION = "openmmapi/src/ForceTranslation.cpp"
NORMAL_FORM = "openmmapi/src/NormalForm.cpp"
PAIR_EXPRESSIONS = "openmmapi/src/energies/CustomNonbondedEnergy.cpp"
TABLES = "openmmapi/src/TabulatedFunctions.cpp"
STATE_NUMBER = "openmmapi/src/StateNumber.cpp"
CLOSED_MOVE = "openmmapi/src/moves/ClosedMove.cpp"
DRAWN_MOVE = "openmmapi/src/moves/DrawnMove.cpp"
CLOSED_WINDOWS = "openmmapi/src/moves/ClosedWindows.cpp"
FOREIGN_ENERGY = "openmmapi/src/ForeignEnergy.cpp"
IMPL = "openmmapi/src/StericExclusionForceImpl.cpp"
INTEGRATOR = "openmmapi/src/TorsionMonteCarloIntegrator.cpp"
INTEGRATOR_XML = "serialization/src/TorsionMonteCarloIntegratorProxy.cpp"
KERNELS = "platforms/reference/src/ReferenceChainTreeKernels.cpp"
LIMITS = "openmmapi/src/LimitPolicy.cpp"
KEPT_GEOMETRY = "openmmapi/src/KeptGeometry.cpp"
STATE_SEAL = "openmmapi/src/StateSeal.cpp"
CHECKPOINT_STREAM = "openmmapi/include/openmmchaintree/internal/CheckpointStream.h"
LINKS = "openmmapi/src/LinkStructure.cpp"
LOCAL_GEOMETRY = "platforms/reference/moves/src/local.c"
LOCAL_MOVE = "openmmapi/src/moves/LocalMove.cpp"
MOVES = "openmmapi/src/MoveList.cpp"
FOREIGN_COPIES = "openmmapi/src/ForeignCopies.cpp"
FOREIGN_FORCES = "openmmapi/src/ForeignForces.cpp"
OUTER_SCHEDULE = "openmmapi/src/OuterSchedule.cpp"
OUTER_WATCH = "openmmapi/src/OuterWatch.cpp"
NATIVE_ENERGY = "openmmapi/src/NativeEnergy.cpp"
NATIVE_ENERGY_HEADER = "openmmapi/include/openmmchaintree/internal/NativeEnergy.h"
OUTER_TEST = "openmmapi/src/OuterTest.cpp"
OUTER_TEST_HEADER = "openmmapi/include/openmmchaintree/internal/OuterTest.h"
PIVOT_MOVE = "openmmapi/src/moves/PivotMove.cpp"
RIGID_BODY_MOVE = "openmmapi/src/moves/RigidBodyMove.cpp"
CORES = "openmmapi/src/CoreSpheres.cpp"
SAMPLED_ENERGIES = "openmmapi/src/SampledEnergies.cpp"
SESSION = "openmmapi/src/TrialSession.cpp"
SIZES = "openmmapi/src/SizeAdaptation.cpp"
SNAPSHOT = "openmmapi/src/ContextSnapshot.cpp"
STAGES = "openmmapi/src/EnergyStage.cpp"
TORSION_MOVE = "openmmapi/src/moves/TorsionMove.cpp"
VALUES = "openmmapi/src/ValueTranslation.cpp"
VELOCITIES = "openmmapi/src/VelocityTurner.cpp"
WINDOWS = "openmmapi/src/TorsionWindows.cpp"

API_FAULTS = [
    Fault("random numbers: the last words are twisted with themselves",
          "openmmapi/include/openmmchaintree/internal/MersenneTwister.h", "words[i + SHIFT - SIZE]", "words[i]"),
    Fault("random numbers: what is read begins with the first word",
          "openmmapi/include/openmmchaintree/internal/MersenneTwister.h", "stream >> restored.next;",
          "stream >> restored.next, restored.next *= restored.next > SIZE;"),
    Fault("random numbers: an index is one of a few more",
          "openmmapi/include/openmmchaintree/internal/RandomNumberGenerator.h", "return value % range;",
          "return value % (range + 1);"),
    # ---- Links ----
    Fault("links: virtual sites are tied to nothing", LINKS,
          "graph.tie(i, particles[j]);", "continue;"),
    Fault("links: a particle on an axis closes a ring of its virtual site", LINKS,
          "if (found == particles.end() || parts[particles[j]] == parts[*found])", "if (true)"),
    Fault("links: a virtual site is tied to the first of its particles", LINKS,
          "j < site.getNumParticles()", "j < 1"),
    Fault("links: a virtual site of mass 0 is fixed", LINKS,
          " && !system.isVirtualSite(i))", ")"),
    Fault("links: axes part links one way round", LINKS,
          "cuts.find(minmax(particle, next)) == cuts.end()", "cuts.find(make_pair(particle, next)) == cuts.end()"),
    Fault("links: fixed molecules are free", LINKS,
          "molecules.push_back({root, anchors[root] != -1});", "molecules.push_back({root, false});"),
    Fault("links: a constraint may span a torsion of the second way", LINKS,
          "    joints1.insert(joints1.end(), joints2.begin(), joints2.end());\n", ""),
    Fault("links: the second particle of a ball joint keeps its place", LINKS,
          "(!isBall() && particle == getBond().second)", "particle == getBond().second"),
    Fault("links: a ball joint may change a dihedral", LINKS, "    checkDihedrals();\n", ""),
    Fault("links: a description does not tell about which end a ball joint turns", LINKS,
          "            if (link.ballJoint != -1)\n                bond.second = bond.first;\n", ""),
    Fault("links: ball joints turn about their second particle", KERNELS,
          "getBallJointParticles(link.ballJoint, torsion[1], torsion[2])",
          "getBallJointParticles(link.ballJoint, torsion[2], torsion[1])"),
    Fault("links: a description does not tell what is fixed", LINKS,
          "        description.push_back(molecules[link.molecule].fixed);\n", ""),
    # ---- Velocities ----
    Fault("velocities: trials leave them as they are", SESSION,
          "        force.velocities->begin(context, kernel);\n", ""),
    Fault("velocities: accelerations stay where dynamics has paused", VELOCITIES,
          "    if (hasPaused)\n        turn(push);\n", ""),
    Fault("velocities: momentum goes its way beside a CMMotionRemover", VELOCITIES,
          "    if (keepsMomentum)\n", "    if (false)\n"),
    Fault("velocities: a constraint may have one end on an axis", LINKS,
          "leavesInPlace(particle1) || ", "leavesInPlace(particle1) && "),
    # ---- Definition ----
    Fault("definition: exclusions reach one bond less far", FORCE,
          "distance <= bondCutoff &&", "distance < bondCutoff &&"),
    Fault("definition: exclusions are known one way round", FORCE,
          "known.insert(minmax(exclusion.first, exclusion.second));", "known.insert(exclusion);"),
    Fault("definition: the order of pairs counts", FORCE,
          "return collect(list1) == collect(list2);", "return false;"),
    Fault("definition: torsions may change in a Context", FORCE,
          "torsions == other.torsions &&", ""),
    Fault("definition: a new role is not taken", FORCE,
          "particles[index] = {radius, hydrogenBondRole};", "particles[index].radius = radius;"),
    # ---- Snapshots of Contexts ----
    Fault("snapshot: parameters are not restored", SNAPSHOT,
          "context.setParameter(known->first, known->second);", ";"),
    Fault("snapshot: velocities are not restored", SNAPSHOT,
          "    context.setVelocities(velocities);\n", ""),
    Fault("snapshot: the box is not restored", SNAPSHOT,
          "    context.setPeriodicBoxVectors(box[0], box[1], box[2]);\n", ""),
    Fault("snapshot: the time is not restored", SNAPSHOT,
          "    context.setTime(time);\n", ""),
    Fault("snapshot: the step count is not restored", SNAPSHOT,
          "    context.setStepCount(stepCount);\n", ""),
    Fault("snapshot: positions are always new", SNAPSHOT,
          "return present.size() != positions.size() ||", "return true ||"),
    Fault("snapshot: positions are kept that were never set", SNAPSHOT,
          "if (positionsAreSet)", "if (true)"),
    # ---- Kernels ----
    Fault("kernel: only the first of two can be the donor", KERNELS,
          " || ((role1 & ctAcceptor) && (role2 & ctDonor))", ""),
    Fault("kernel: new parameters forget limits", KERNELS,
          "vector<array<int, 2>> pairs(getNumLimits());", "vector<array<int, 2>> pairs;"),
    Fault("kernel: a scene of new parameters has all particles in one place", KERNELS,
          "        getPositions(positions);\n    Tree", "        ;\n    Tree"),
    Fault("kernel: a selection outlives its scene", KERNELS,
          "    selection2 = KeptSelection();\n", ""),
    Fault("kernel: a selection serves for other particles", KERNELS,
          "!kept.selection || kept.particles != particles", "!kept.selection"),
    Fault("kernel: the arrangement is that of the first scene", KERNELS,
          "    arrangement = std::move(positions);\n",
          "    if (arrangement.empty())\n        arrangement = std::move(positions);\n"),
    Fault("kernel: forces add up", KERNELS,
          "    fill(forces.begin(), forces.end(), Vec3());\n", ""),
    Fault("kernel: molecules turn about the origin", KERNELS,
          "    check(ctGetCentroid(tree.get(), change.link, change.pivot));\n", ""),
    Fault("kernel: soft spheres reach as far as one radius", KERNELS,
          "return 2 * largest - parameters.overlapTolerance;", "return largest;"),
    Fault("kernel: soft spheres had no energy before", KERNELS,
          "excessAfter * excessAfter - excessBefore * excessBefore", "excessAfter * excessAfter"),
    Fault("kernel: soft spheres know nothing of hydrogen bonds", KERNELS,
          "- parameters.getTolerance(particle1, particle2);", "- parameters.overlapTolerance;"),
    # ---- Positions and limits ----
    Fault("positions: only the last particle can be a virtual site", IMPL,
          "hasVirtualSites = hasVirtualSites || system", "hasVirtualSites = system"),
    Fault("positions: trials begin with old virtual sites", IMPL,
          "    computeVirtualSites(context);\n    updatePositions(context);", "    updatePositions(context);"),
    Fault("positions: one that this plugin sets is the user's", IMPL,
          "    FlagGuard guard(settingPositions);\n", ""),
    Fault("positions: those of a checkpoint are the user's", IMPL,
          "        if (haveSameBits(buffer, restored))\n            return;\n", ""),
    Fault("positions: a query does not look at them anew", IMPL,
          "    updateState(context);\n    return engine->getMinimum", "    return engine->getMinimum"),
    Fault("positions: an energy does not look at them anew", IMPL,
          "    adoptPositions(context, positions);\n    bringUpToDate(*engine);\n", "    bringUpToDate(*engine);\n"),
    Fault("positions: a checkpoint agrees on none", IMPL,
          "    agreedPositions = kept.agreedPositions;\n", ""),
    Fault("positions: a probe does not look at them anew", IMPL,
          "    updateState(context);\n    engine->getClashesWith", "    engine->getClashesWith"),
    Fault("positions: changed pairs are those of old ones", IMPL,
          "    updateState(context);\n    requireProposal();\n    engine->getChanged",
          "    requireProposal();\n    engine->getChanged"),
    Fault("positions: tolerated clashes are those of old ones", IMPL,
          "    updateState(context);\n    return engine->getNumLimits", "    return engine->getNumLimits"),
    Fault("parameters: nobody is told of new ones", IMPL,
          "    context.systemChanged();\n", ""),
    Fault("angles: setting them keeps limits", IMPL,
          "    session.end();\n    limits.restart();", "    session.end();"),
    Fault("warnings: each periodic force makes one", IMPL,
          '"stand can clash");\n            return;', '"stand can clash");'),
    Fault("limits: dynamics starts them anew", LIMITS,
          "if (dynamicsIsExpected && mayBeDynamics)", "if (false)"),
    Fault("limits: any Integrator's step may raise them", LIMITS,
          "if (dynamicsIsExpected && mayBeDynamics)", "if (mayBeDynamics)"),
    Fault("limits: silent steps are unknown", LIMITS,
          "(stepBegun != NO_STEP || !stepsAreAnnounced)", "(stepBegun != NO_STEP)"),
    Fault("limits: a step never ends", LIMITS,
          "    if (stepCount != stepBegun)\n        stepBegun = NO_STEP;\n", ""),
    Fault("limits: new ones may not grow", LIMITS,
          "    kernel->clearLimits();\n    isCurrent = false;", "    kernel->clearLimits();"),
    Fault("limits: those of a State may not grow", LIMITS,
          "    kernel->setLimits(pairs, limits);\n    isCurrent = false;", "    kernel->setLimits(pairs, limits);"),
    Fault("limits: old ones stay", LIMITS,
          "    kernel->clearLimits();\n", ""),
    Fault("limits: a checkpoint's are always up to date", LIMITS,
          "    isCurrent = kept.isCurrent;", "    isCurrent = true;"),
    Fault("limits: a checkpoint knows no step", LIMITS,
          "    stepBegun = kept.stepBegun;\n", ""),
    # ---- Trials ----
    Fault("session: it leaves its trial open", SESSION,
          "    if (ownsTrial)\n        reject();\n", ""),
    Fault("session: an exception leaves the Context behind", SESSION,
          "        end();\n    }\n    catch", "    }\n    catch"),
    Fault("session: after an energy the Context stays at the trial", SESSION,
          "    contextIsBehind = true;\n    force.setContext", "    force.setContext"),
    Fault("session: soft trials clash", SESSION,
          "limits == IgnoreLimits || kernel", "kernel"),
    Fault("session: an accepted clash keeps limits", SESSION,
          "    if (limits == ApplyLimits && !force.proposalIsFree)\n        force.limits.restart();\n", ""),
    Fault("session: acceptance starts limits anew", SESSION,
          "    if (limits == ApplyLimits && !force.proposalIsFree)", "    if (limits == ApplyLimits)"),
    Fault("step: forces are told of none", INTEGRATOR,
          "    context->updateContextState();\n", ""),
    Fault("step: soft ones keep limits", INTEGRATOR,
          "    if (mode != Hard)\n        force->getLimitPolicy().restart();\n    else if", "    if"),
    # ---- Without spheres ----
    Fault("cores: attraction takes nothing off repulsion", CORES, " - attraction / distance > energy", " > energy"),
    Fault("cores: like charges attract", CORES, "max(a.positive * b.negative, a.negative * b.positive)",
          "max(a.positive * b.positive, a.negative * b.negative)"),
    Fault("cores: a rare type shrinks the others", CORES,
          "a.particles.size() > b.particles.size()", "a.particles.size() < b.particles.size()"),
    Fault("cores: a charge without Lennard-Jones has none", CORES, "radii[i] = GUARD_RADIUS", "radii[i] = 0"),
    Fault("cores: bonded pairs are refused", CORES, "set.particlesPerTerm == 2", "set.particlesPerTerm == 1"),
    Fault("cores: they reach beyond the cutoff", CORES,
          "min(undiminished, findCoreDistance(types[i], types[i], energy))",
          "findCoreDistance(types[i], types[i], energy)"),
    Fault("cores: other energies of pairs do not count", ENERGY_PLAN,
          "index < 0 || !terms.pairSets.empty() ||", "index < 0 ||"),
    Fault("cores: a start within them refuses trials", SESSION,
          "        this->limits = IgnoreLimits;\n", ""),
    Fault("cores: positions that were set are not looked at", IMPL,
          "trialSpheresWereFree || !trialEngine->hasClash()", "true"),
    Fault("cores: they keep the tolerance of the force", IMPL,
          "            replaced.setOverlapTolerance(0);\n", ""),
    Fault("spheres: the force has an energy where they are off", IMPL,
          "!energyIsSuppressed && !hasSpheresOff(context.getIntegrator())", "!energyIsSuppressed"),
    Fault("spheres: queries are of the state before trials", IMPL,
          "    behind.setPositions(agreedPositions);\n", ""),
    Fault("spheres: a user's trial is lost to the next step", IMPL,
          "    newest = &changed;\n", ""),
    Fault("spheres: a step leaves a user's trial open", SESSION,
          "    if (&kernel != force.engine)\n        force.engine->rejectProposal(); // that of a user\n", ""),
    Fault("spheres: a Force of some particles takes their place", ENERGY_PLAN,
          "if (radius > 0 && held.count(i) == 0)", "if (false)"),
    Fault("spheres: a Force that is not sampled takes their place", ENERGY_PLAN,
          "replacesSpheres[i] && (entries[i].groups & groups) != 0", "replacesSpheres[i]"),
    Fault("step: what moves uphill is accepted too often", STAGES,
          "random.drawUniform() < exp(logRatio)", "random.drawUniform() < 2 * exp(logRatio)"),
    Fault("step: the ratio of proposals does not count", INTEGRATOR,
          "entry.move->computeLogRatio(trials)", "0"),
    # ---- Energies ----
    Fault("pair expressions: they may depend on the order of particles", PAIR_EXPRESSIONS,
          "if (!isSymmetric(force, globals, functions, set))",
          "if (!isSymmetric(force, globals, functions, set) && false)"),
    Fault("pair expressions: copies of tables are not periodic", PAIR_EXPRESSIONS,
          "restorePeriod(original.getTabulatedFunction(i), copy->getTabulatedFunction(i));", ";"),
    Fault("pair expressions: an index may lie outside of its table", EXPRESSIONS,
          "table.table.discrete; i++", "table.table.discrete && i > 9; i++"),
    Fault("tables: copies forget that they are periodic", TABLES,
          "dynamic_cast<Table&>(copy) = *table;", "dynamic_cast<const Table&>(copy);"),
    Fault("states: numbers are short", STATE_NUMBER,
          "digits == numeric_limits<double>::max_digits10", "digits == 6"),
    Fault("tables: splines have no curvature", TABLES,
          "3 * c0, c1 - c0}", "0, 0}"),
    Fault("born: necks are those of the other way round", BORN_READER,
          "born.neckHeights.push_back(height(i, j, {}));", "born.neckHeights.push_back(height(j, i, {}));"),
    Fault("born: coefficients of pairs may be anything", BORN_READER,
          "!isExpected(i, reference) || !isExpected(reference, i)", "i < 0 && !isExpected(reference, i)"),
    Fault("born: spheres are filled in no model", BORN_READER,
          "born.filled = match.getIndex() >= FIRST_FILLED;", "born.filled = false;"),
    Fault("born: it needs no other pairs", FORCE_TRANSLATION,
          "if (terms.nonbonded.empty())", "if (false)"),
    Fault("born: it has to come behind its NonbondedForce", ENERGY_PLAN,
          "if (needsPairs(i) == second &&", "if (second && (needsPairs(i) || true) &&"),
    Fault("normal form: powers have no part in the shape", NORMAL_FORM,
          'entry.shape += "*" + factor.atom->shape + "^" + ::toText(factor.power);',
          'entry.shape += "*" + factor.atom->shape;'),
    Fault("normal form: a choice is a product whatever else it has", NORMAL_FORM,
          " || !::evaluate(children[2], value) || value != 0)", " || !::evaluate(children[2], value))"),
    Fault("energy: all groups count", ENERGY_PLAN,
          "if ((entries[index].groups & groupsOfU) == 0)", "if (entries[index].groups == 0)"),
    Fault("energy: groups are those of the first step", NATIVE_ENERGY,
          " || !(present == choice)) {", ") {"),
    Fault("energy: that of the state is that of the first trial", FOREIGN_ENERGY,
          "    energy = proposedEnergy;\n", ""),
    Fault("energy: the reciprocal space is forgotten", ENERGY_PLAN,
          "if (nonbonded != NULL && hasReciprocalSpace(*nonbonded) && "
          "nonbonded->getReciprocalSpaceForceGroup() >= 0)", "if (nonbonded == NULL && &force == NULL)"),
    Fault("energy: a thermostat has some", ENERGY_PLAN,
          " ||\n                              dynamic_cast<const AndersenThermostat*>(&force) != NULL", ""),
    Fault("energy: the spheres' own joins that of others", IMPL,
          "    FlagGuard guard(energyIsSuppressed);\n", ""),
    # ---- Stages of energy ----
    Fault("stages: the ratio of proposals belongs to none", STAGES,
          "isFirst ? logRatio + stageLogRatio : stageLogRatio", "stageLogRatio"),
    Fault("stages: the ratio of proposals belongs to each", STAGES,
          "isFirst ? logRatio + stageLogRatio : stageLogRatio", "logRatio + stageLogRatio"),
    Fault("stages: one random number decides all", STAGES,
          "const double drawn = random.drawUniform();", "static double drawn;\n        if (isFirst)\n"
          "            drawn = random.drawUniform();"),
    Fault("stages: each decides at a temperature of 0", STAGES,
          "rule == DecideOneByOne && temperature > 0 ?", "rule == DecideOneByOne ?"),
    Fault("stages: what is no number passes", STAGES,
          "if (!(drawn < exp(isFirst ? logRatio + stageLogRatio : stageLogRatio)))",
          "if (drawn >= exp(isFirst ? logRatio + stageLogRatio : stageLogRatio))"),
    Fault("stages: soft spheres have no part", SAMPLED_ENERGIES,
          "    stages->add(make_unique<SoftSphereEnergy>(*native));\n", ""),
    Fault("stages: the last one has no part", SAMPLED_ENERGIES,
          "    stages->add(make_unique<ForeignEnergy>(*native));\n", ""),
    # ---- Native energies ----
    Fault("stages: what makes an earlier one good is left out", STAGES,
          "toLogRatio(change + entry.stage->getCorrection(), temperature)", "toLogRatio(change, temperature)"),
    Fault("stages: the ratio of proposals is a part of one that has no opposite", STAGES,
          "entry.takesPart && isFirst && !entry.stage->isAntisymmetric()", "false"),
    # ---- Outer tests ----
    Fault("outer: tests see what trials have seen, too", NATIVE_ENERGY,
          "        energy -= isMixed ? getInnerEnergy() : hasStandIn() ? held.pairs : 0;",
          "        energy -= 0;"),
    Fault("outer: trials see what is left to tests, too", FOREIGN_ENERGY,
          "    parts = native.getForeignOfTrials();\n",
          "    for (size_t i = parts.size(); i < native.getForeign().getParts().size(); i++)\n"
          "        parts.push_back(i);\n"),
    Fault("outer: a test compares with the start of the step", OUTER_TEST,
          "            start = proposed;\n", ""),
    Fault("outer: a test leads back to the start of the step", OUTER_TEST,
          "            stateIsKept = false;\n", ""),
    Fault("outer: a test asks where the last one left the Context", SESSION,
          "    if (!contextIsBehind)\n        return;\n", "    return;\n"),
    Fault("outer: trials stay", OUTER_TEST,
          "    trials.takeBackState();\n", ""),
    Fault("outer: what is taken back stays in the Context", SESSION,
          "    kernel.takeBackState();\n    ownsTrial = false;\n    contextIsBehind = true;\n",
          "    kernel.takeBackState();\n    ownsTrial = false;\n"),
    Fault("outer: limits stay", KERNELS,
          "    if (pairs != kept.limitedPairs || limits != kept.limits)", "    if (false)"),
    Fault("outer: the energy is computed anew", KERNELS,
          "        energy->takeBack();", "        energy->update(true, counts);"),
    Fault("outer: counts of moves stay", OUTER_TEST,
          "    moves.setStatistics(keptMoveCounts);\n", ""),
    Fault("outer: counts of stages stay", OUTER_TEST,
          "    stages.setAllStatistics(keptStageCounts);\n", ""),
    Fault("outer: minus infinity is an energy", OUTER_TEST,
          "    if (!NativeEnergy::isPossible(proposed.difference.whole))\n        return false;\n", ""),
    Fault("outer: a start without an energy is one", OUTER_TEST,
          "    if (!NativeEnergy::isPossible(start.difference.whole))", "    if (false)"),
    Fault("native: foreign Forces without energy are not named", NATIVE_ENERGY, "    fail(forces);", "    fail({});"),
    Fault("outer: at a temperature of 0 trials do not count", OUTER_TEST,
          "native.getInnerEnergy() + (softSpheres", "(softSpheres"),
    Fault("outer: at a temperature of 0 soft spheres do not count", OUTER_TEST,
          "(softSpheres ? trials.computeSoftEnergy() : 0)", "0"),
    Fault("outer: the last trials of a step are not tested", OUTER_TEST_HEADER,
          "        if (numTrials > 0)\n            endBlock();\n", ""),
    Fault("outer: an exception leaves trials untested", OUTER_TEST,
          "        if (numTrials > 0)\n            takeBack();\n", ""),
    Fault("outer: tests forget what trials have seen of a stand-in", NATIVE_ENERGY,
          "isMixed ? getInnerEnergy() : hasStandIn() ? held.pairs : 0", "isMixed ? getInnerEnergy() : 0"),
    Fault("outer: constants are renewed at each step", NATIVE_ENERGY,
          "    updateStandIn();\n    const vector<double> energies",
          "    renewStandIn();\n    const vector<double> energies"),
    Fault("outer: constants are renewed with each block", OUTER_TEST,
          "    native.keep();\n", "    native.renewStandIn();\n    native.keep();\n"),
    Fault("outer: renewed constants leave the energy of former positions", NATIVE_ENERGY,
          "    whole.isCurrent = values.isCurrent = false;\n    getKernel().getStandIn", "    getKernel().getStandIn"),
    Fault("outer: renewed constants leave computed values of former positions", NATIVE_ENERGY,
          "    whole.isCurrent = values.isCurrent = false;\n    getKernel().getStandIn",
          "    whole.isCurrent = false;\n    getKernel().getStandIn"),
    Fault("outer: the whole energy of what is taken back stays", NATIVE_ENERGY_HEADER,
          "        whole = keptWhole;\n", ""),
    Fault("outer: near pairs are taken to have the same radii both ways", NATIVE_ENERGY,
          "if (changeBack == -nearChange)", "if (true)"),
    Fault("outer: checkpoints forget the counts", INTEGRATOR,
          "    moves->setProgress(progress);\n    *outerStatistics = restoredTests;\n",
          "    moves->setProgress(progress);\n"),
    # ---- Native energies ----
    Fault("native: foreign Forces count those of their groups twice", FOREIGN_ENERGY,
          "native.getForeign().areMixed() ? native.getComputedChange() : 0", "0"),
    Fault("value energies: those of an accepted trial are lost", NATIVE_ENERGY_HEADER,
          "        values.energies.swap(proposedValues);\n", ""),
    Fault("value energies: trials that are not asked about change nothing", NATIVE_ENERGY_HEADER,
          "whole.isCurrent = values.isCurrent = false;", "whole.isCurrent = false;"),
    Fault("value energies: other positions change nothing", NATIVE_ENERGY,
          "        whole.isCurrent = values.isCurrent = false;", "        whole.isCurrent = false;"),
    Fault("value energies: taking back leaves those of the trials", NATIVE_ENERGY_HEADER,
          "        values = keptValues;\n", ""),
    Fault("value energies: tests leave them out", NATIVE_ENERGY,
          "if (!isMixed && valuesAreLeft)", "if (false)"),
    Fault("value energies: trials see what is left to tests, too", NATIVE_ENERGY_HEADER,
          "return valuesCanChange && integrator.getTrialsPerOuterTest() == 0;", "return valuesCanChange;"),
    Fault("value energies: foreign Forces of their group have them, too", NATIVE_ENERGY,
          "    computedChange += change;\n    return change;\n}\n\nvoid NativeEnergy::endTrial",
          "    return change;\n}\n\nvoid NativeEnergy::endTrial"),
    Fault("value energies: without a temperature tests know nothing of them", NATIVE_ENERGY,
          "        ofValues = updateValues();", "        ;"),
    Fault("value energies: nobody compares them with OpenMM", ENERGY_PLAN,
          "    add(terms.valueEnergies);\n", ""),
    Fault("value energies: excluded pairs count", VALUES,
          "computation.type == CustomGBForce::ParticlePair ?", "false ?"),
    Fault("value energies: there are no exclusions", VALUES,
          "        energy.exclusions.push_back(exclusion);\n", ""),
    Fault("value energies: there is no cutoff", VALUES,
          "        energy.cutoff = force.getCutoffDistance();", "        ;"),
    Fault("value energies: of the second particle earlier values are read", VALUES,
          "    translator.skipParameters(values.size() - numValues);\n", ""),
    Fault("value energies: terms do not know the last value", VALUES,
          "add(term, values.size(), energy.terms)", "add(term, values.size() - 1, energy.terms)"),
    Fault("value energies: nobody tries the order of particles", VALUES,
          "        if (term.type != CustomGBForce::SingleParticle && !isSymmetric(term.expression))",
          "        if (false)"),
    Fault("native: foreign Forces know the last stage alone", NATIVE_ENERGY,
          "nearChange = change;\n    computedChange += change;", "nearChange = change;\n    computedChange = change;"),
    Fault("native: the change of a trial is added to that of the next", NATIVE_ENERGY,
          "    numComputed = 0;\n    computedChange = 0;", "    numComputed = 0;"),
    Fault("native: foreign groups are evaluated without the native Forces", FOREIGN_FORCES,
          "(plan.getGroups(EnergyPlan::Foreign) & groups) | native, -1",
          "plan.getGroups(EnergyPlan::Foreign) & groups, -1"),
    Fault("foreign: copies go stale", FOREIGN_FORCES,
          "!copies || haveChanged || copied", "!copies || (haveChanged && false) || copied"),
    Fault("foreign: copies keep their box", FOREIGN_COPIES,
          "    inner->setPeriodicBoxVectors(box[0], box[1], box[2]);\n", ""),
    Fault("foreign: copies keep their parameters", FOREIGN_COPIES,
          "            inner->setParameter(parameter.first, present);\n", "            continue;\n"),
    Fault("foreign: native Forces are evaluated with them", FOREIGN_FORCES,
          "        context.getForceImpls().swap(others);\n    }\n    ~",
          "    }\n    ~"),
    Fault("foreign: parts that have a group in common are evaluated one by one", FOREIGN_FORCES,
          "if ((parts[i].groups & part.groups) != 0) {", "if (false) {"),
    Fault("foreign: what is not left to tests is nobody's", NATIVE_ENERGY,
          "if (isLeftToTests(part) == leftToTests)", "if (isLeftToTests(part) && leftToTests)"),
    Fault("schedule: large changes are left to tests", OUTER_SCHEDULE,
          "            left[i] = 0;\n", ""),
    Fault("schedule: changes that go down are small", OUTER_SCHEDULE,
          " && acceptanceBack > LEAST_ACCEPTANCE", ""),
    Fault("schedule: a spread that was too large stays", OUTER_SCHEDULE,
          "        level--;\n", ""),
    Fault("schedule: a number of trials is measured again", OUTER_SCHEDULE,
          "TRIALS[level] >= longest || level + 1", "longest < 0 || level + 1"),
    Fault("schedule: the change of all does not matter", OUTER_SCHEDULE,
          "    whole.add(change);\n", "    whole.add(0 * change);\n"),
    Fault("outer: chains count as slow by acceptance alone", OUTER_WATCH,
          "kept >= LEAST_ACCEPTANCE && deviation <= LARGEST_DEVIATION", "kept >= LEAST_ACCEPTANCE"),
    Fault("outer: chains count as slow by the spread alone", OUTER_WATCH,
          "kept >= LEAST_ACCEPTANCE && deviation <= LARGEST_DEVIATION", "deviation <= LARGEST_DEVIATION"),
    Fault("outer: tests without a change count for slow chains", OUTER_WATCH,
          "if (change == 0)", "if (false)"),
    Fault("schedule: checkpoints forget it", INTEGRATOR,
          "    native->setStandIn(standIn);\n    native->setSchedule(schedule);\n",
          "    native->setStandIn(standIn);\n"),
    Fault("schedule: States forget it", NATIVE_ENERGY,
          "node.hasProperty(\"schedule\") ?", "false ?"),
    Fault("native: parts without terms are left out", NATIVE_ENERGY,
          "(part == EnergyKernel::BondedPart && !pairsCanChange) ? NUM_PARTS : part + 1", "part + 1"),
    Fault("native: parameters of the Context are read once", NATIVE_ENERGY_HEADER,
          "        parametersWereChanged |= changed == OpenMM::State::Parameters;\n", "        (void)changed;\n"),
    Fault("native: Forces are read once", NATIVE_ENERGY_HEADER,
          "        forcesWereChanged |= changed == OpenMM::State::Energy;", "        //"),
    Fault("native: terms of another integrator are sampled", NATIVE_ENERGY,
          "force.getOwnerOfEnergyTerms() != this", "false"),
    Fault("native: after a checkpoint sums go on", INTEGRATOR,
          "    if (force != NULL) {\n        native->computeAnew();\n", "    if (force != NULL) {\n"),
    Fault("native: after a State sums go on", INTEGRATOR,
          "    native->computeAnew();\n    node.", "    node."),
    Fault("native: U of foreign groups counts native Forces twice", NATIVE_ENERGY,
          "if ((plan.getEntries()[i].groups & foreign.getWholeGroups()) == 0)", "if (i < energies.size())"),
    Fault("native: a present state may have no energy", NATIVE_ENERGY,
          "    checkNumbers(energies);\n", ""),
    Fault("native: OpenMM is never asked", NATIVE_ENERGY,
          "        compareWithOpenMM(trials, energies);", "        trialsToCheck = TRIALS_BETWEEN_CHECKS;"),
    Fault("native: on a lattice nobody asks whether energies are right near it", ENERGY_CHECK,
          "computeAnew(shaken), allowances) != NULL)", "computeAnew(shaken), allowances) != NULL && shaken.empty())"),
    Fault("native: on a lattice energies are of a structure that was edited", IMPL,
          "createKernel(context, *original)", "createKernel(context, owner)"),
    Fault("native: on a lattice any energy will do", ENERGY_CHECK, "KEPT = 4", "KEPT = 40"),
    Fault("native: on a lattice no energy is right", ENERGY_CHECK, "KEPT = 4", "KEPT = 0"),
    Fault("native: new positions leave energies as they were", "platforms/reference/energy/src/energy.c",
          "energy->state == ctGetChangeCount(energy->tree);", "energy->state != NO_STATE;"),
    Fault("native: it takes part in what setNativeEnergies refuses", ENERGY_PLAN,
          "if (!allowNative)", "if (false)"),
    # ---- Moves ----
    Fault("move: of several torsions the later are drawn with replacement", TORSION_MOVE,
          "        if (isDrawn[choice])\n            choice = last;\n", ""),
    Fault("move: what was drawn once is drawn no more", TORSION_MOVE,
          "        isDrawn[drawnChoices[i]] = false;\n", ""),
    Fault("move: torsions turn one way", TORSION_MOVE,
          "random.drawSymmetric(getScale() * maxAngle)", "random.drawUniform() * maxAngle"),
    Fault("pivot move: all rotations are drawn by a uniform angle", "openmmapi/include/openmmchaintree/internal/"
          "RandomNumberGenerator.h", "if (limit >= M_PI)", "if (false)"),
    Fault("pivot move: others than those listed turn", PIVOT_MOVE,
          "choices[random.drawIndex(choices.size())]", "random.drawIndex(choices.size())"),
    Fault("local move: there is no ratio", LOCAL_MOVE,
          "    return ctComputeLocalLogDensity(", "    return 0;\n    return ctComputeLocalLogDensity("),
    Fault("local move: the ratio is turned over", LOCAL_MOVE,
          "(&stepsBack, changes.data()) - ctComputeLocalLogDensity(&steps, changes.data())",
          "(&steps, changes.data()) - ctComputeLocalLogDensity(&stepsBack, changes.data())"),
    Fault("local move: the ratio lacks the determinant", LOCAL_GEOMETRY,
          "return logarithm - 0.5 * squares;", "return 0 * logarithm - 0.5 * squares;"),
    Fault("local move: the ratio lacks the exponential", LOCAL_GEOMETRY,
          "return logarithm - 0.5 * squares;", "return logarithm - 0 * squares;"),
    Fault("local move: windows have no end particle off the axis", LOCAL_MOVE,
          "particles.push_back(structure.getTorsionParticles(torsions.back())[3]);",
          "particles.push_back(structure.getTorsionParticles(torsions.back())[2]);"),
    Fault("local move: the step back has another size", LOCAL_MOVE,
          "ctFindLocalSteps(&after, getScale() * sigma", "ctFindLocalSteps(&after, sigma"),
    Fault("sizes: they adapt away from what is wished", SIZES,
          "exp(gain * excess)", "exp(-gain * excess)"),
    Fault("sizes: steps become ever less", SIZES,
          "max(LEAST_GAIN, 1 / sqrt((double)numBlocks))", "1 / (double)numBlocks"),
    Fault("sizes: a checkpoint forgets what the next depend on", MOVES,
          "        entries[i].adaptation.setState(progress.adaptations[i]);\n", ""),
    Fault("sizes: a State forgets what the next depend on", MOVES,
          "progress.adaptations.push_back(state);", "progress.adaptations.push_back({});"),
    Fault("sizes: XML forgets scales", MOVES,
          "if (entry.move->getScale() != 1)\n            move.", "if (false)\n            move."),
    Fault("sizes: counts go on when adaptation ends", INTEGRATOR,
          "    moves->restartAdaptation();\n    resetStatistics();", "    moves->restartAdaptation();"),
    Fault("sizes: they adapt without being asked to", INTEGRATOR,
          "        if (adaptMoveSizes)\n", ""),
    Fault("windows: shorter ones are missing where chains end", WINDOWS,
          "if (!hasNext[windows[i].back()])", "if (false)"),
    Fault("windows: side chains are backbones", WINDOWS,
          "length[link] + 1 >= LEAST_BRANCH", "length[link] + 1 >= 1"),
    Fault("drawn move: no ratio", DRAWN_MOVE,
          "    return log(evaluateFormer() / ", "    return 0 * log(evaluateFormer() / "),
    Fault("drawn move: the ratio is turned over", DRAWN_MOVE,
          "    return log(evaluateFormer() / ", "    return -log(evaluateFormer() / "),
    Fault("drawn move: the density of former values is that of older ones", DRAWN_MOVE,
          "        density.value = ctGetDensity(",
          "        if (density.value == 0)\n            density.value = ctGetDensity("),
    Fault("drawn move: values are those of the first set", DRAWN_MOVE,
          "former[i] = trials.getTorsionAngle(set[i]);", "former[i] = trials.getTorsionAngle(torsions[0][i]);"),
    Fault("drawn move: the density is that of the first set", DRAWN_MOVE,
          "evaluateFormer() / ctGetDensity(setDensities[drawnSet]", "evaluateFormer() / ctGetDensity(setDensities[0]"),
    Fault("drawn move: checkpoints know nothing of floors", DRAWN_MOVE,
          "{(double)density.getNumTorsions(), density.getFloor()}", "{(double)density.getNumTorsions(), 0.0}"),
    Fault("drawn move: XML has one density for all", DRAWN_MOVE,
          'set.setIntProperty("density", numbers[i])', 'set.setIntProperty("density", numbers[0])'),
    Fault("move: molecules that have come to be fixed are drawn", RIGID_BODY_MOVE,
          "    choices.clear();\n", ""),
    Fault("move: molecules move within a cube", RIGID_BODY_MOVE,
          "random.drawPointInBall(getScale() * maxTranslation)",
          "Vec3(random.drawSymmetric(maxTranslation), random.drawSymmetric(maxTranslation), "
          "random.drawSymmetric(maxTranslation))"),
    Fault("closed move: no Jacobian", CLOSED_MOVE,
          "ctComputeLogJacobian(&window) - ctComputeLogJacobian(&turned)", "0"),
    Fault("closed move: the ratio is turned over", CLOSED_MOVE,
          "ctComputeLogJacobian(&window) - ctComputeLogJacobian(&turned)",
          "ctComputeLogJacobian(&turned) - ctComputeLogJacobian(&window)"),
    Fault("closed move: any way back will do", CLOSED_MOVE,
          "return undo(window, angles, pivotTurns);", "return undo(window, angles, pivotTurns) || true;"),
    Fault("closed move: the weights of solutions are left out", CLOSED_MOVE,
          "isHop ? ratio + logWeights - logWeightsBack : ratio", "ratio"),
    Fault("closed move: all solutions are drawn alike", CLOSED_MOVE,
          "left -= computeWeight(solutions[drawn])", "left -= sum / count"),
    Fault("closed move: weights are those of turns from elsewhere", CLOSED_MOVE,
          "angles[window.pivots[i]] = solutions[drawn][i];", "angles[window.pivots[i]] = solutions[0][i];"),
    Fault("closed windows: the last torsion is left out of choices", CLOSED_WINDOWS,
          "k < end; k++", "k < end - 1; k++"),
    Fault("closed windows: neighbours need share no particle", CLOSED_WINDOWS,
          "window.axes[i].first == window.axes[i - 1].second", "window.axes[i].first != -1"),
    Fault("closed windows: what those of eight leave out stays", CLOSED_WINDOWS,
          "return !isTurned[step.torsion];", "return windows.empty() && !isTurned[step.torsion];"),
    Fault("closed windows: rows are cut at the wrong end", CLOSED_WINDOWS,
          "steps(row.end() - size, row.end());", "steps(row.begin(), row.begin() + size);"),
    Fault("closure: windows know nothing of it", CLOSED_WINDOWS,
          "!keepsClosures(structure, steps)", "(!keepsClosures(structure, steps) && false)"),
    Fault("closure: a window's tail is a piece of its own", CLOSED_WINDOWS,
          "if (between != 0 && between != row.size())", "if (between != 0)"),
    Fault("closure: windows of rings repeat those of chains", CLOSED_WINDOWS,
          "(isRing && isOnWayToRoot(structure, steps))", "false"),
    Fault("closure: windows towards the root turn the other way", "openmmapi/src/TorsionWindows.cpp",
          "if (step.isRootward)", "if (false)"),
    Fault("closure: a window of a ring ends where that is tied", CLOSED_WINDOWS,
          "first < ring.size(); first++", "first < 1; first++"),
    Fault("closure: moves of all torsions turn those of rings", TORSION_MOVE,
          "if (structure.getLinkClosure(structure.getTorsionLinks()[torsion]) == -1)", "if (true)"),
    Fault("closure: a ring has one side", LINKS,
          "        way1.insert(way1.end(), way2.begin(), way2.end());\n", ""),
    Fault("closure: a ring reaches to the root", LINKS,
          "while (!way1.empty() && !way2.empty() && way1.back() == way2.back())", "while (false)"),
    Fault("closure: it excludes no neighbours", FORCE,
          'tie(closure[1], closure[2], "a closure");', "(void)closure;"),
    Fault("closure: another structure without it", LINKS,
          "    sort(bonds.begin(), bonds.end());\n", "    bonds.clear();\n"),
    Fault("move: weights are not taken off", MOVES,
          "        position -= entries[i].weight;\n", ""),
    Fault("move: a new one keeps the weight", MOVES,
          "entries[index] = {std::move(move), weight, 0, 0, 0, 0, {}};",
          "entries[index] = {std::move(move), entries[index].weight, 0, 0, 0, 0, {}};"),
    # ---- What is kept ----
    Fault("checkpoint: the random numbers are not restored", INTEGRATOR,
          "    *random = restored;\n    moves->setProgress", "    moves->setProgress"),
    Fault("checkpoint: counts of refused trials are not restored", MOVES,
          "        entries[i].rejectedByEnergy = statistics[NUM_COUNTS * i + 2];\n", ""),
    Fault("checkpoint: a refused one keeps limits", INTEGRATOR,
          "already.\n\n        force->getLimitPolicy().restart();\n", "already.\n\n"),
    Fault("checkpoint: any moves will do", MOVES,
          "        checkSame(i, description, describe(entries[i]));\n", ""),
    Fault("checkpoint: velocities set since are lost", INTEGRATOR,
          "        kept->context.updateVelocities(*owner);", "        ;"),
    Fault("saved state: it is believed elsewhere", INTEGRATOR,
          "if (fingerprintOf(positions) == written)", "if (true)"),
    Fault("saved state: counts of outer tests of other moves are taken", INTEGRATOR,
          "version > 2 && movesAreTheSame", "version > 2 || movesAreTheSame"),
    Fault("saved state: the random numbers are not restored", INTEGRATOR,
          "    *random = restored;\n    if (movesAreTheSame)", "    if (movesAreTheSame)"),
    Fault("checkpoint: nobody looks at its checksum", CHECKPOINT_STREAM,
          "if (hashBytes(bytes.data(), bytes.size()) != hash)", "if (false)"),
    Fault("checkpoint: nobody looks at OpenMM's part", INTEGRATOR,
          "        if (isCovered)\n            checkReadBefore", "        if (false)\n            checkReadBefore"),
    Fault("checkpoint: links may be torn", KEPT_GEOMETRY,
          "            fail(i, \"is not where its link has it\");", "            ;"),
    Fault("saved state: nobody looks at its seal", INTEGRATOR,
          "    if (version > 3)\n        checkSeal(node);", "    ;"),
    Fault("saved state: a coordinate may differ", STATE_SEAL,
          "    if (!sums.findLoneChange(present, written, index, former))", "    if (true)"),
    Fault("saved state: a refused one has replaced statistics", INTEGRATOR,
          "        restoredTests.read(node.getChildNode",
          "        moves->setProgress(progress), restoredTests.read(node.getChildNode"),
    Fault("context: that it was deleted is taken for a refused reinitialize()", INTEGRATOR,
          "contextHasEnded = true;", "contextHasEnded = false;"),
    Fault("saved state: that of another structure loses its limits", INTEGRATOR,
          "    else\n        force->setLimits(*context, pairs, limits);\n", ""),
    # ---- Serialization ----
    Fault("xml: roles are lost", FORCE_XML,
          '.setIntProperty("hydrogenBondRole", role)', '.setIntProperty("hydrogenBondRole", 0)'),
    Fault("xml: the force group is lost", FORCE_XML,
          '    force->setForceGroup(node.getIntProperty("forceGroup"));\n', ""),
    Fault("xml: the integration force groups are lost", INTEGRATOR_XML,
          '    integrator->setIntegrationForceGroups(node.getIntProperty("integrationForceGroups"));\n', ""),
    Fault("xml: the first version has a steric mode", INTEGRATOR_XML,
          "    if (version > 1)\n", ""),
]
# fmt: on

# fmt: off
GEOMETRY_FAULTS = [
    Fault("velocities: they turn back", "velocities.c",
          "multiplyByTranspose(after[i], before[i], after[i]);", "multiplyByTranspose(before[i], after[i], after[i]);"),
    Fault("velocities: momentum is kept as if the heaviest body stayed", "velocities.c",
          "multiplyByTranspose(meanTurn, pivotal, matrix);", "memcpy(matrix, meanTurn, sizeof matrix);"),
    Fault("velocities: the least rotation shortens them", "velocities.c",
          "2 * alongFrom * unitTo", "alongFrom * unitTo"),
    Fault("border: pivots may lie anywhere", "triangle.c",
          "w->pivots[k] < least || w->pivots[k] >= w->count || ", ""),
    Fault("border: a uniform number that is none draws from anywhere", "density.c",
          "scaled > 0 ? (int)scaled : 0", "(int)scaled"),
    Fault("density: aliases are not asked", "density.c",
          "? i : table->alias[i]", "? i : i"),
    Fault("density: the first torsion's bins run fastest", "density.c",
          "for (int k = density->torsionCount - 1; k >= 0; k--) {\n    const int count",
          "for (int k = 0; k < density->torsionCount; k++) {\n    const int count"),
    Fault("density: tables are evaluated without their floor", "density.c",
          "(1 - floor) * (values[i] / sum) + floor / count", "values[i] / sum"),
    Fault("density: rotamers are evaluated without their floor", "density.c",
          "const double base = density->floor / TWO_PI;", "const double base = 0 * density->floor;"),
    Fault("density: of sixteen rotamers eight are left out", "density.c",
          "for (int half = BATCH / 2; half > 0; half /= 2) {", "for (int half = BATCH / 4; half > 0; half /= 2) {"),
    Fault("density: a bell is a tenth too wide", "density.c",
          "bells->reach[i] = reach;", "bells->reach[i] = 1.1 * reach;"),
    Fault("density: a bell is a sum of three numbers", "density.c",
          "(first + u[1] + u[2] + u[3] - 2)", "(first + u[1] + u[2] + 0.5 - 2)"),
    Fault("density: bells end at the end of the circle", "density.c",
          "spline(distance(angle, mean[i]) * scale[i])", "spline(fabs(angle - mean[i]) * scale[i])"),
    Fault("density: wide bells are not wrapped", "density.c",
          "for (int turn = -bells->images; turn <= bells->images; turn++)", "for (int turn = 0; turn <= 0; turn++)"),
    Fault("density: weights of rotamers are not normalized", "density.c",
          "density->weight[i] = weights[i] / sum;", "density->weight[i] = weights[i];"),
    # ---- Closures of windows ----
    Fault("Jacobian: its two products are added", "closure.c",
          "log(fabs(after - before))", "log(fabs(after + before))"),
    Fault("Jacobian: all pairs of pivots meet at right angles", "closure.c",
          "w->axes[w->pivots[2 * k + 1]], normals[k]);",
          "w->axes[w->pivots[2 * k + 1]], normals[k]);\n    scale(normals[k], 1 / sqrt(dot(normals[k], normals[k])));"),
    Fault("closure: one in a hundred is lost", "closure.c",
          "const int found = findSways(&triangle, sways);",
          "int found = findSways(&triangle, sways);\n"
          "  found -= found > 0 && (long long)(1e9 * fabs(sways[0].s[0])) % 100 == 0;"),
    Fault("turned window: an axis is turned by its own torsion", "closure.c",
          "    if (i > 0) {\n      turnPoint", "    turnFirst(&behind, &turn);\n    if (i > 0) {\n      turnPoint"),
    Fault("triangle: drivers before the pivots are forgotten", "triangle.c",
          "turnDrivers(w, angles, origin, 0, w->pivots[0], &turning) || isTurned", "isTurned"),
    Fault("triangle: drivers behind the pivots are forgotten", "triangle.c",
          "to == 0 ? w->count : w->pivots[2 * to]", "to == 0 ? first : w->pivots[2 * to]"),
    Fault("triangle: axes that are parallel may be pivots", "triangle.c",
          "if (!(dot(across, across) > PARALLEL * PARALLEL)) {", "if (0) {"),
    Fault("Newton: it ends a step too early", "triangle.c",
          "#define LAST_STEP 1e-16", "#define LAST_STEP 1e-6"),
    Fault("Newton: what it has not closed is closed", "triangle.c",
          "      return true;\n    }\n  }\n  return false;\n}\n\n/* A direction",
          "      return true;\n    }\n  }\n  return true;\n}\n\n/* A direction"),
    Fault("turns: the second is seen from the first axis", "triangle.c",
          "angleAbout(after.second, before.first, after.first)", "angleAbout(before.first, before.first, after.first)"),
    Fault("resultant: a factor is a hundredth too small", "resultant.c",
          "addProduct(9, -4, both, ss, r->f);", "addProduct(9, -3.96, both, ss, r->f);"),
    Fault("search: half of the circle is left out", "search.c",
          "    searchHalfCircle(&search, -1);\n", ""),
    Fault("search: arcs with two roots are taken for empty", "search.c",
          "if (changes == 0 ||", "if (changes % 2 == 0 ||"),
    Fault("search: rounding may hide roots", "search.c",
          "piece < 3; piece++", "piece < 1; piece++"),
    Fault("search: a closure may be found twice", "search.c",
          "while (n < search->count && !isSame(&search->sways[n], &sway))", "while (n < search->count)"),
    Fault("arc: it ends where y or z is real in part", "arc.c",
          "    if (b[i] >= 0) {\n      return false;", "    if (b[i] < 0) {\n      return true;"),
    Fault("arc: its right half begins too far to the right", "arc.c",
          "  arc->from = middle;", "  arc->from = middle + 0.01;"),
]
# fmt: on

# fmt: off
COORDINATOR = "replicas/coordinator.py"
LADDER = "replicas/ladder.py"
SCHEDULE = "replicas/schedule.py"
SEGMENT = "replicas/segment.py"
RUN = "command/replicarun.py"
RANKING = "command/clashranking.py"

PYTHON_FAULTS = [
    # ---- Replicas ----
    Fault("exchange: the exponent has the other sign", LADDER,
          "return (1 / temperature1 - 1 / temperature2)", "return (1 / temperature2 - 1 / temperature1)"),
    Fault("exchange: the exponent is half as large", LADDER,
          "return (1 / temperature1 - 1 / temperature2)", "return 0.5 * (1 / temperature1 - 1 / temperature2)"),
    Fault("exchange: all rounds draw the same random numbers", LADDER,
          "default_rng((self._seed, _EXCHANGES, round))", "default_rng((self._seed, _EXCHANGES))"),
    Fault("exchange: after all rounds the same pairs are tried", LADDER,
          "(index + round) % 2", "index % 2"),
    Fault("exchange: replicas keep their temperatures", COORDINATOR,
          "temperatureOf[hot] = lower + 1, lower", "temperatureOf[hot] = lower, lower + 1"),
    Fault("exchange: energies are taken for each other's", COORDINATOR,
          "self._exchanges.decide(round, lower, coldEnergy, hotEnergy)",
          "self._exchanges.decide(round, lower, hotEnergy, coldEnergy)"),
    Fault("exchange: replicas that come in another order change places", COORDINATOR,
          "            pair.sort(key=lambda entry: temperatureOf[entry[0]])\n", ""),
    Fault("exchange: half a round trip counts", COORDINATOR,
          "state.roundTrips[replica] += state.wasHotLast[replica] is True",
          "state.roundTrips[replica] += state.wasHotLast[replica] is not None"),
    Fault("seeds: two replicas share one", LADDER,
          "return list(seeds)\n", "return [*list(seeds)[:1], *list(seeds)[:-1]]\n"),
    Fault("seeds: replicas have that of the Model", SEGMENT,
          "        self._integrator.setRandomNumberSeed(seed)\n", ""),
    Fault("segment: a replica keeps its first temperature", SEGMENT,
          "        self._integrator.setTemperature(segment.temperature * unit.kelvin)\n",
          "        if segment.round == 0:\n"
          "            self._integrator.setTemperature(segment.temperature * unit.kelvin)\n"),
    Fault("segment: a replica that was elsewhere meanwhile stays where it is", SEGMENT,
          "if segment.checkpoint != self._checkpoint:",
          "if segment.checkpoint != self._checkpoint and self._checkpoint is None:"),
    Fault("segment: it begins at the start", SEGMENT,
          "            self._context.loadCheckpoint(segment.checkpoint)\n", "            pass\n"),
    Fault("segment: counts of former ones count again", SEGMENT,
          "self._counts() - counts,", "self._counts(),"),
    Fault("segment: the energy is that of its first frame", SEGMENT,
          "energy = self._energy()  # before", "energy = frames[0].energy if frames else self._energy()  # before"),
    Fault("segment: a frame is kept before its trials", SEGMENT,
          "            start = perf_counter()\n",
          "            start = perf_counter()\n"
          "            if stop.keepsFrame:\n"
          "                frames.append(KeptFrame(self._positions(), self._energy()))\n"
          "            stop = Stop(stop.trials, False)\n"),
    Fault("schedule: the last frame of a shorter interval is lost", SCHEDULE,
          "return self.frames if trials == self.trials else trials // self.interval", "return trials // self.interval"),
    Fault("schedule: the last round is as long as the others", SCHEDULE,
          "min(round * self.trialsPerRound, self.trials)", "round * self.trialsPerRound"),
    # ---- What a run writes, and goes on from ----
    Fault("resume: the last round is done and counted once more", RUN,
          'self.state.restore(saved.header["state"], checkpoints)\n',
          'self.state.restore(saved.header["state"], checkpoints)\n'
          "        self.state.round = max(0, self.state.round - 1)\n"),
    Fault("resume: all replicas go on from the first one's checkpoint", RUN,
          "saved.checkpoints.get(replica) for replica", "saved.checkpoints.get(0) for replica"),
    Fault("resume: an index that was changed is taken for ours", "command/replicafiles.py",
          '"index", checksum=self._checksum)', '"index")'),
    Fault("resume: the checksum of an index is that of its last rows", "command/replicafiles.py",
          "zlib.crc32(data, self._checksum)", "zlib.crc32(data)"),
    Fault("resume: what no checkpoint counts stays", "command/growingfile.py",
          "growing._file.truncate(size)\n                growing._file.seek(size)",
          "growing._file.seek(0, os.SEEK_END)"),
    Fault("resume: temperatures are those of the start", COORDINATOR,
          "if name != \"checkpoints\"}", "if name not in (\"checkpoints\", \"temperatureOf\")}"),
    Fault("resume: a run of another structure is taken up", RUN,
          'if saved.header["model"] != self._model.key:', "if False:"),
    Fault("saved run: it is written before what it counts", RUN,
          "                        self._sync()\n                        self._save()\n",
          "                        self._save()\n                        self._sync()\n"),
    Fault("saved run: it is written over the former one", "replicas/checkpointfile.py",
          "temporary = path.with_name(temporaryName or nameTemporary())", "temporary = path"),
    Fault("saved run: replicas may have changed places", "replicas/checkpointfile.py",
          'if sha256(checkpoint).hexdigest() != header["digests"][name]:', "if False:"),
    Fault("saved run: a part stays where there is no room", "replicas/checkpointfile.py",
          "        temporary.unlink(missing_ok=True)\n", ""),
    Fault("reports: any file of that name is the run's", RUN,
          'return sha256(file.read()).hexdigest() in self.header["reports"]', "return True"),
    Fault("reports: the saved run learns of them too late", RUN,
          "            self._run.noteReport(content)\n", ""),
    Fault("files: two runs write them", "command/outputfiles.py",
          "fcntl.LOCK_EX | fcntl.LOCK_NB", "fcntl.LOCK_SH | fcntl.LOCK_NB"),
    Fault("files: what another run has made is removed", "command/outputfiles.py",
          "if self._made is not None and _identity(os.stat(self._path)) == self._made:", "if True:"),
    Fault("files: emptied before it is known who writes them", "command/outputfiles.py",
          'io.FileIO(self._path, "r+", opener=_openOrMake)', 'io.FileIO(self._path, "w")'),
    Fault("more trials: frames come farther apart", "command/sample.py",
          "saved.framesOf(options.trials)", 'saved.settings["frames"]'),
    Fault("more trials: a last round that was shorter is one of the others", RUN,
          "begins[0] != begins[1],", "False,"),
    Fault("more trials: a last frame that came early is one of the others", RUN,
          "frames[0] != frames[1],", "False,"),
    Fault("files: each replica has a trajectory of a temperature", "command/replicafiles.py",
          "temperature if self._byTemperature else replica", "replica"),
    Fault("files: the index has replicas in the order in which they come", "command/replicafiles.py",
          "rows[replica] for replica in sorted(rows)", "rows[replica] for replica in rows"),
    Fault("files: the hottest is told to be the coldest", COORDINATOR,
          "self._addFrame(frame, result.replica, temperature, kept)",
          "self._addFrame(frame, result.replica, len(self._plan.temperatures) - 1 - temperature, kept)"),
    # ---- OpenMM's sampler ----
    Fault("sampler: replicas share their random numbers", "replicaexchange.py",
          "integrator.setRandomNumberSeed(seed)", "integrator.setRandomNumberSeed(1)"),
    Fault("sampler: replicas keep their state", "replicaexchange.py",
          "        replica.sampler.applyState(state)\n", ""),
    Fault("sampler: tolerated clashes have an energy", "replicaexchange.py",
          "if _differInTemperature(self._states):\n            energy = self._ours.getPotentialEnergy(self.context)",
          "if _differInTemperature(self._states):\n"
          "            energy = self.context.getState(energy=True).getPotentialEnergy()._value"),
    Fault("sampler: a State that was loaded is passed over", "replicaexchange.py",
          "if conformation is not self._conformation:", "if conformation is None:"),
    # ---- Clashes in chunks ----
    Fault("chunks: the last one is lost", "clashchunks.py",
          "range(0, max(1, count), length)", "range(0, max(1, count - length), length)"),
    Fault("chunks: the latest that was asked for comes first", "clashchunks.py",
          "asked.popleft()", "asked.pop()"),
    Fault("chunks: frames are numbered anew in each", "clashchunks.py",
          "chunk.counts.tolist(), strict=True), begin)", "chunk.counts.tolist(), strict=True), 0)"),
    Fault("chunks: what follows a damaged frame counts", "clashchunks.py",
          "if chunk.damage is not None:", "if False:"),
    Fault("chunks: frames that were made whole are told again and again", "clashchunks.py",
          "    search.madeWhole.clear()\n", ""),
    Fault("chunks: another file is not noticed", "clashchunks.py",
          "if found != size:", "if False:"),
    Fault("ranking: each clash is in a frame of its own", RANKING,
          "(keys[1:] != keys[:-1]) | (frames[1:] != frames[:-1])", "1"),
    Fault("ranking: what comes after the last whole batch is lost", RANKING,
          '        self._countWaiting()\n        ranked = self._pairs.rank()', '        ranked = self._pairs.rank()'),
    Fault("ranking: of equal overlaps the last one's frame is told", RANKING,
          "np.searchsorted(group[holders], np.arange(len(begins)))",
          'np.searchsorted(group[holders], np.arange(len(begins)), side="right") - 1'),
    Fault("ranking: a residue that clashes with itself counts twice", RANKING,
          "counts[:, 1] = residues[:, 0] != residues[:, 1]", "counts[:, 1] = True"),
    # ---- Clusters ----
    Fault("cluster: a Client that cannot connect is waited for", "cluster.py",
          '            client.status = "closed"\n', ""),
    Fault("cluster: workers of another version are taken", "cluster.py",
          "if theirs != ours:\n                    raise ClusterError",
          "if False:\n                    raise ClusterError"),
]
# fmt: on


LAYERS = (
    (ENGINE, ENGINE_FAULTS),
    (ENERGY, ENERGY_FAULTS),
    (GEOMETRY, GEOMETRY_FAULTS),
    (API, API_FAULTS),
    (PYTHON, PYTHON_FAULTS),
)
FAULTS = [(layer, fault) for layer, faults in LAYERS for fault in faults]


def run(command, **arguments):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **arguments)


class Copy:
    """A copy of the repository, built without Python, optimizing little."""

    def __init__(self, folder: pathlib.Path, all: bool):
        self.all = all
        self.source = folder / "source"
        self.build = folder / "build"
        self.source.mkdir(parents=True, exist_ok=True)
        tracked = run(["git", "ls-files"], cwd=REPOSITORY, check=True).stdout.splitlines()
        for name in tracked:
            self.write(name, (REPOSITORY / name).read_bytes())
        for path in self.source.rglob("*"):
            if path.is_file() and str(path.relative_to(self.source)) not in tracked:
                path.unlink()

    def write(self, name: str, content: bytes) -> None:
        """Leaves files that are as they should be their time, for the build."""
        path = self.source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != content:
            path.write_bytes(content)


class Tests:
    """The tests of a layer, on a copy."""

    def __init__(self, copy: Copy, layer: Layer):
        self.copy = copy
        self.layer = layer
        self.build = copy.build / layer.label
        options = {
            "Python_EXECUTABLE": sys.executable,
            "CHAINTREE_ENGINE_ONLY": "OFF" if layer is API else "ON",
            "CHAINTREE_BUILD_PYTHON": "OFF",
            "CHAINTREE_BUILD_BENCHMARKS": "OFF",
            "CHAINTREE_SANITIZE": "",
            "CMAKE_C_FLAGS_RELEASE": "-O1",
            "CMAKE_CXX_FLAGS_RELEASE": "-O1",
        }
        command = ["cmake", "-S", copy.source, "-B", self.build, "-G", "Ninja"]
        configured = run(command + [f"-D{name}={value}" for name, value in options.items()])
        if configured.returncode != 0:
            sys.exit(configured.stdout)
        listed = run(["ctest", "--test-dir", self.build, "-L", layer.label, "-E", layer.never, "-N"]).stdout
        self.names = re.findall(r"Test +#\d+: (\S+)", listed)

    def make(self) -> str:
        """Returns what the compiler said if it refused."""
        made = run(["cmake", "--build", self.build])
        return "" if made.returncode == 0 else made.stdout

    def failing(self, pattern: str, without: str) -> list[str]:
        command = ["ctest", "--test-dir", self.build, "-R", pattern, "-E", without]
        ran = run(command + ([] if self.copy.all else ["--stop-on-failure"]))
        if "No tests were found" in ran.stdout:
            sys.exit(f"no test matches {pattern}")
        return re.findall(r"^\t *\d+ - (\S+)", ran.stdout, re.MULTILINE)

    def catchers(self) -> list[str]:
        found = self.failing("^(" + "|".join(self.names) + ")$", self.layer.slow)
        for name in self.names:
            if not found and re.match(self.layer.slow, name):
                found = self.failing(f"^{name}$", "^$")
        return found


class PythonTests:
    """The tests of what is in Python, on a copy of the package that is imported here, with the copy's own modules."""

    def __init__(self, copy: Copy, layer: Layer):
        self.copy = copy
        self.layer = layer
        self.tests = copy.source / "python" / "tests"
        self.package = copy.build / layer.label
        found = importlib.util.find_spec("openmmchaintree")
        if found is None or found.origin is None:
            sys.exit("openmmchaintree cannot be imported, whose compiled part these tests need: set PYTHONPATH")
        built = pathlib.Path(found.origin).parent
        for folder in built.parent.glob("openmmchaintree*"):
            shutil.copytree(folder, self.package / folder.name, dirs_exist_ok=True)
        names = [path.stem for path in self.tests.glob("test_*.py")]
        # Of replicas first, which most faults are of.
        names = sorted((name for name in names if not re.match(layer.never, name)), reverse=True)
        self.names = sorted(names, key=self.isSlow)

    def isSlow(self, name: str) -> bool:
        return re.match(self.layer.slow, name) is not None

    def make(self) -> str:
        """Returns what Python said if it refused."""
        for path in (self.copy.source / self.layer.folder).rglob("*.py"):
            text = path.read_text()
            try:
                compile(text, str(path), "exec")
            except SyntaxError as error:
                return str(error)
            (self.package / "openmmchaintree" / path.relative_to(self.copy.source / self.layer.folder)).write_text(text)
        return ""

    def failing(self, names: list[str]) -> list[str]:
        files = [self.tests / f"{name}.py" for name in names]
        stop = [] if self.copy.all else ["-x"]
        try:
            ran = run(
                [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *stop, *files],
                cwd=self.copy.build,  # not where the package is, since some tests start Python with another one
                env={**os.environ, "PYTHONPATH": str(self.package), "PYTHONDONTWRITEBYTECODE": "1"},
                timeout=1800,
            )
        except subprocess.TimeoutExpired:
            return ["a test that hangs"]
        failed = re.findall(r"^(?:FAILED|ERROR) .*?(test_\w+\.py\S*)", ran.stdout, re.MULTILINE)
        return failed if failed or ran.returncode == 0 else [f"exit status {ran.returncode}"]

    def catchers(self) -> list[str]:
        quick = [name for name in self.names if not self.isSlow(name)]
        found = self.failing(quick)
        for name in self.names[len(quick) :]:
            found = found or self.failing([name])
        return found


def whyNotPlanted(layer: Layer, fault: Fault) -> str:
    """Returns why a fault cannot be planted, or an empty text."""
    path = REPOSITORY / layer.folder / fault.file
    if not path.exists():
        return f"there is no {fault.file}"
    count = path.read_text().count(fault.old)
    return "" if count == 1 else f"its text is in {fault.file} {count} times"


def plant(tests: Tests | PythonTests, fault: Fault) -> str:
    """Returns what came of it, or an empty text if nobody noticed."""
    reason = whyNotPlanted(tests.layer, fault)
    if reason:
        return f"PLANT IT ANEW: {reason}"
    name = f"{tests.layer.folder}/{fault.file}"
    sound = (REPOSITORY / name).read_text()
    tests.copy.write(name, sound.replace(fault.old, fault.new).encode())
    try:
        refusal = tests.make()
        if refusal:
            return "PLANT IT ANEW: it does not compile\n" + refusal
        return ", ".join(tests.catchers())
    finally:
        tests.copy.write(name, sound.encode())


def plantAll(copy: Copy, chosen: list[tuple[Layer, Fault]]) -> int:
    """Returns how many nobody noticed, or could not be planted."""
    made: dict[Layer, Tests | PythonTests] = {}
    for layer in dict.fromkeys(layer for layer, _ in chosen):
        made[layer] = (PythonTests if layer is PYTHON else Tests)(copy, layer)
        failed = made[layer].make() or ", ".join(made[layer].catchers())
        if failed:
            sys.exit(f"without any fault: {failed}")
    bad = 0
    for number, (layer, fault) in enumerate(chosen, 1):
        start = time.monotonic()
        result = plant(made[layer], fault)
        bad += result == "" or result.startswith("PLANT")
        seconds = time.monotonic() - start
        print(f"{number:3} {fault.name}\n    {result or 'NOBODY NOTICED'} ({seconds:.0f} s)", flush=True)
    print(f"{len(chosen) - bad} of {len(chosen)} faults were caught")
    return bad


def check(chosen: list[tuple[Layer, Fault]]) -> int:
    """Returns how many faults cannot be planted."""
    reasons = [(fault.name, whyNotPlanted(layer, fault)) for layer, fault in chosen]
    bad = [f"{name}: {reason}" for name, reason in reasons if reason]
    print(*bad, f"{len(chosen) - len(bad)} of {len(chosen)} faults can be planted", sep="\n")
    return len(bad)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults whose name begins so; all if none is given")
    parser.add_argument("--list", action="store_true", help="only name the faults")
    parser.add_argument("--check", action="store_true", help="only look whether each text is in its file once")
    parser.add_argument("--all", action="store_true", help="name all quick tests that notice, not only the first")
    parser.add_argument("--folder", type=pathlib.Path, help="where the copy goes, and stays")
    arguments = parser.parse_args()
    names = tuple(arguments.names) or ("",)
    chosen = [(layer, fault) for layer, fault in FAULTS if fault.name.startswith(names)]
    if arguments.list:
        print(*(fault.name for _, fault in chosen), sep="\n")
        return 0
    if arguments.check:
        return check(chosen) > 0
    for tool in ("cmake", "ninja", "git"):
        if shutil.which(tool) is None:
            sys.exit(f"{tool} was not found")
    os.environ.pop("CHAINTREE_SIMD", None)
    os.environ.pop("CHAINTREE_TRIALS", None)
    with tempfile.TemporaryDirectory() as temporary:
        return plantAll(Copy(arguments.folder or pathlib.Path(temporary), arguments.all), chosen) > 0


if __name__ == "__main__":
    sys.exit(main())
