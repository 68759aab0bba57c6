"""Do the tests notice? Puts one fault after another into a copy of the engine and runs the engine's tests on it.

    python tests/planted_faults.py [--list] [NAME ...]

A fault is a small edit of the engine's source, such as one could make by mistake. It is caught if a test fails, hangs
or crashes. Faults that nobody catches, or whose text is no longer in the source, make the exit status 1. The copy lies
in a temporary folder, or in that which --folder names, where a later run finds what is built. Takes about half a
minute a fault; see CONTRIBUTING.md.
"""

import argparse
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
SOURCES = "platforms/reference/chaintree/src"

# Asked one by one if the others, which take little time, have not caught a fault.
SLOW = "TestCommitCost|TestSizes|TestCrowds|TestScales|TestRandomPrograms"
# The oracle's test knows nothing of the engine; trajectories may be wrong as long as they are the same; and random
# programs run without a setting take longest.
NEVER = ("TestOracle", "TestTrajectories", "TestRandomPrograms")


@dataclass(frozen=True)
class Fault:
    name: str  # what is wrong, and the subject before the colon
    file: str
    old: str  # text that is in the file once
    new: str


# fmt: off
FAULTS = [
    # ---- Volumes ----
    Fault("volume: a sphere around members leaves out their radii", "volume.h",
          "centre.y, centre.z)), load16(radii)));", "centre.y, centre.z)), all16(0)));"),
    Fault("volume: a bound is a thousandth too small", "refresh_body.h",
          "r + rounding, radiusAbout", "0.999f * r, radiusAbout"),
    Fault("volume: a bound has no room for its rounding", "refresh_body.h",
          "1e-6f * (fabsf(middle.x)", "0 * (fabsf(middle.x)"),
    Fault("volume: what straddles is not around its members", "view_body.h",
          "radiusAbout(bound, &s->block, s->block.r) + ", "0.9f * radiusAbout(bound, &s->block, s->block.r) + "),
    Fault("volume: radii of centres where surfaces are wanted", "view_body.h",
          "Surfaces ? own->block.r", "Surfaces ? own->centres"),
    # ---- What descents keep, types, axes ----
    Fault("kept: a leaf that has made room is still seen", "view_body.h",
          "t->inView[other] = NULL; /* positions", "/* positions"),
    Fault("kept: a node that has made room is still seen", "view_body.h",
          "if (t->inView[other] == moved) {", "if (t->inView[other] == NULL) {"),
    Fault("kept: the second of two blocks may stand where the first was", "view_body.h",
          "blockOf(t, a);\n  blocks[1] = blockOf(t, b);\n  blocks[0] = blockOf(t, a);",
          "blocks[0] = blockOf(t, a);\n  blocks[1] = blockOf(t, b);"),
    Fault("kept: boxes of another node", "viewboxes_body.h",
          "moved->node != node || moved->stamp", "moved->stamp"),
    Fault("type: that of the last new one", "particletype.c",
          "s->slotType[slot] = s->slotType[table[i] - 1];", "s->slotType[slot] = s->typeCount - 1;"),
    Fault("axis: from particles that are too close together", "tree.c",
          "> LEAST_LINE * dot(point, point)", "> 0"),
    # ---- Margins ----
    Fault("margin: a thousandth of that of float", "volume.h",
          "FLOAT_MARGIN 4e-6", "FLOAT_MARGIN 4e-9"),
    Fault("margin: none of double", "volume.h",
          "DOUBLE_MARGIN 4e-13", "DOUBLE_MARGIN 4e-20"),
    Fault("margin: none where squares vanish", "volume.h",
          "FLOAT_FLOOR 1e-18f", "FLOAT_FLOOR 0.0f"),
    Fault("margin: reach is left out of a filter", "volume.h",
          "all16(sphere.r + reach)), all16(0)", "all16(sphere.r)), all16(0)"),
    Fault("margin: a view's shift does not count", "view_body.h",
          "t->extent = size + shift;", "t->extent = size;"),
    # ---- Traversal ----
    Fault("traversal: what straddles is not looked into", "descent_body.h",
          "t->stack[(*depth)++] = (NodePair){below, i, i};", ""),
    Fault("traversal: a body is taken for another", "view_body.h",
          "return code == motion ? 0xffff : 0;", "return code >= 0 ? 0xffff : 0;"),
    Fault("traversal: a straddler's members are all of one body", "view_body.h",
          "motion < 0 ? 0 : equal16(straddlerOf(t, code)->motion, motion);", "0xffff;"),
    Fault("traversal: the last member of a node is passed over", "descent_body.h",
          "for (unsigned left = near; left != 0;", "for (unsigned left = near & 0x7fff; left != 0;"),
    Fault("traversal: a mover does not meet its own leaf", "movers_body.h",
          "if (!testLeaf(t, visit, movers, leaf, slotBits(begin, end, leaf * TREE_WIDTH))) {", "if (false) {"),
    Fault("traversal: movers do not meet each other", "movers_body.h",
          "if (!testMovers(t, visit, &movers[i], &movers[j])) {", "if (false) {"),
    Fault("traversal: a piece ends a slot late", "trial.c",
          "addPiece(trial, s->slotBegin[end], depth", "addPiece(trial, s->slotBegin[end] + 1, depth"),
    Fault("traversal: an inner motion comes before the outer one", "trial.c",
          "transformCompose(&trial->motions[around], &change->motion)",
          "transformCompose(&change->motion, &trial->motions[around])"),
    Fault("traversal: of pairs of a leaf with itself some are left out", "descent_body.h",
          "mask &= ~alreadyVisited(rows, k);", "mask &= alreadyVisited(rows, k);"),
    Fault("traversal: kept positions outlive a change before them", "tree.h",
          "return treeFirstMoved(tree, since) >= leafEnd;", "return treeFirstMoved(tree, since) >= leafEnd - 2;"),
    # ---- Boxes ----
    Fault("box: it leaves out radii", "box.h",
          "least16(sub16(along, reach))", "least16(along)"),
    Fault("box: it leaves out the boxes within", "box.h",
          "reach = blend16(boxes->thin, reach, reachAlong(boxes, u));", ""),
    Fault("box: it has no room for rounding", "box.h",
          "4e-6f * (fabsf(bound->x)", "0 * (fabsf(bound->x)"),
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
    Fault("update: what comes after a changed leaf is not told", "refresh_body.h",
          "tree->shortcutTime[leaf] = tree->time;", ""),
    Fault("update: what comes after a changed node is not told", "refresh_body.h",
          "tree->shortcutTime[node] = tree->time;", ""),
    Fault("update: the node over a changed leaf is not told", "refresh_body.h",
          "tree->contentTime[leaf] = tree->time;", ""),
    Fault("update: a leaf within a twig begins where the twig does", "refresh_body.h",
          "beginsHere ? tree->stem[twig] : transformIdentity()", "tree->stem[twig]"),
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
    # ---- Undo ----
    Fault("undo: a verdict leaves the trial applied", "verdict.c",
          "  applyTrial(tree, false);\n}\n\n/* Looks for a clash", "}\n\n/* Looks for a clash"),
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
          "add16(add16(centre, turned), room)", "add16(centre, room)"),
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
    Fault("clearance: it outlives new limits", "query.c",
          "tree->limits = fresh;\n  ctClearanceForget(&tree->clearance);", "tree->limits = fresh;"),
    Fault("clearance: it outlives a new state", "state.c",
          "ctClearanceForget(&tree->clearance);", ""),
    # ---- Exclusions ----
    Fault("exclusion: of a slot only the last counts", "exclusion.c",
          "(*mask | 1u << b % TREE_WIDTH)", "(1u << b % TREE_WIDTH)"),
    Fault("exclusion: it holds one way round", "exclusion.c",
          "pairs[count + 1][0] = b;", "pairs[count + 1][0] = a;"),
    Fault("exclusion: leaves after the first partner are lost in sweeps", "exclusion.h",
          "exclusions->partner[*partner] < leafB", "exclusions->partner[*partner] <= leafB"),
    Fault("exclusion: the search for a partner goes too far", "order.h",
          "values[middle] < value", "values[middle] <= value"),
    # ---- Limits ----
    Fault("limit: the search goes too far", "exclusion.c",
          "limits->keys[middle] < key", "limits->keys[middle] <= key"),
    Fault("limit: of two the lesser stays", "exclusion.c",
          "(x->value < y->value) - (x->value > y->value)", "(x->value > y->value) - (x->value < y->value)"),
    Fault("limit: a raised one is within rounding", "query.c",
          "canonical + CT_SIGMA", "canonical"),
    Fault("limit: trials know only tolerances", "verdict.c",
          "limit = ctLimitsFind(&tree->limits, pair[0], pair[1], limit);", ""),
    # ---- State ----
    Fault("state: an angle grows beyond pi", "sequence.c",
          "return sum - twoPi * ((sum > pi) - (sum < -pi));", "return sum;"),
    Fault("state: many turns are taken with a short pi", "sequence.c",
          "fabs(turn) > twoPi ? atan2(sin(turn), cos(turn)) : turn", "remainder(turn, twoPi)"),
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
          "quaternionMultiply(turn, joint->placement.quaternion, moved.placement.quaternion)",
          "quaternionMultiply(joint->placement.quaternion, turn, moved.placement.quaternion)"),
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
          "members, others, (node - layout->levelBegin[level]) % TREE_WIDTH, true", "members, others, 0, true"),
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
    Fault("portable: the last quarter is compared like the third", "simd.h",
          "bits4(a.q[3] > b.q[3]) << 12", "bits4(a.q[2] > b.q[2]) << 12"),
    Fault("avx2: a blend takes the low half twice", "simd.h",
          "lanes8(mask >> 8))}", "lanes8(mask))}"),
]
# fmt: on


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
        options = {
            "Python_EXECUTABLE": sys.executable,
            "CHAINTREE_BUILD_PYTHON": "OFF",
            "CHAINTREE_BUILD_BENCHMARKS": "OFF",
            "CHAINTREE_SANITIZE": "",
            "CMAKE_C_FLAGS_RELEASE": "-O1",
        }
        command = ["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja"]
        configured = run(command + [f"-D{name}={value}" for name, value in options.items()])
        if configured.returncode != 0:
            sys.exit(configured.stdout)
        listed = run(["ctest", "--test-dir", self.build, "-L", "engine", "-N"]).stdout
        self.tests = [name for name in re.findall(r"Test +#\d+: (\S+)", listed) if name not in NEVER]
        self.targets = sorted({name.split("_")[0] for name in self.tests})

    def write(self, name: str, content: bytes) -> None:
        """Leaves files that are as they should be their time, for the build."""
        path = self.source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != content:
            path.write_bytes(content)

    def make(self) -> str:
        """Returns what the compiler said if it refused."""
        made = run(["cmake", "--build", self.build, "--target", *self.targets])
        return "" if made.returncode == 0 else made.stdout

    def failing(self, pattern: str, without: str) -> list[str]:
        command = ["ctest", "--test-dir", self.build, "-R", pattern, "-E", without]
        ran = run(command + ([] if self.all else ["--stop-on-failure"]))
        if "No tests were found" in ran.stdout:
            sys.exit(f"no test matches {pattern}")
        return re.findall(r"^\t *\d+ - (\S+)", ran.stdout, re.MULTILINE)

    def catchers(self) -> list[str]:
        found = self.failing("^(" + "|".join(self.tests) + ")$", SLOW)
        for name in self.tests:
            if not found and any(name.startswith(slow) for slow in SLOW.split("|")):
                found = self.failing(f"^{name}$", "^$")
        return found


def plant(copy: Copy, fault: Fault) -> str:
    """Returns what came of it, or an empty text if nobody noticed."""
    name = f"{SOURCES}/{fault.file}"
    sound = (REPOSITORY / name).read_text()
    count = sound.count(fault.old)
    if count != 1:
        return f"PLANT IT ANEW: its text is in {fault.file} {count} times"
    copy.write(name, sound.replace(fault.old, fault.new).encode())
    try:
        refusal = copy.make()
        if refusal:
            return "PLANT IT ANEW: it does not compile\n" + refusal
        return ", ".join(copy.catchers())
    finally:
        copy.write(name, sound.encode())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="faults whose name begins so; all if none is given")
    parser.add_argument("--list", action="store_true", help="only name the faults")
    parser.add_argument("--all", action="store_true", help="name all quick tests that notice, not only the first")
    parser.add_argument("--folder", type=pathlib.Path, help="where the copy goes, and stays")
    arguments = parser.parse_args()
    chosen = [fault for fault in FAULTS if not arguments.names or fault.name.startswith(tuple(arguments.names))]
    if arguments.list:
        print(*(fault.name for fault in chosen), sep="\n")
        return 0
    for tool in ("cmake", "ninja", "git"):
        if shutil.which(tool) is None:
            sys.exit(f"{tool} was not found")
    os.environ.pop("CHAINTREE_SIMD", None)
    os.environ.pop("CHAINTREE_TRIALS", None)
    with tempfile.TemporaryDirectory() as temporary:
        copy = Copy(arguments.folder or pathlib.Path(temporary), arguments.all)
        failed = copy.make() or ", ".join(copy.catchers())
        if failed:
            sys.exit(f"without any fault: {failed}")
        bad = 0
        for number, fault in enumerate(chosen, 1):
            start = time.monotonic()
            result = plant(copy, fault)
            bad += result == "" or result.startswith("PLANT")
            seconds = time.monotonic() - start
            print(f"{number:3} {fault.name}\n    {result or 'NOBODY NOTICED'} ({seconds:.0f} s)", flush=True)
    print(f"{len(chosen) - bad} of {len(chosen)} faults were caught")
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
