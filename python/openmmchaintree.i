/* SWIG's interface of the C++ classes. It reads their headers unchanged; in Python they differ as follows:
 *
 * - Numbers may carry OpenMM units. The typemaps below convert them by the name of the parameter, and refuse units of
 *   another dimension.
 * - Parameters marked [out] are results. Vectors become NumPy arrays, with one copy of memory.
 * - The interpreter is free for other threads while a method works on a Context, one at a time on each; as in OpenMM, it
 *   is not while one reads or writes a Force, an Integrator or a density. C++ exceptions become OpenMMException.
 */
%module(package="openmmchaintree") openmmchaintree

// OpenMM's own headers, in which Python keywords, nested classes and typemaps that only it needs occur.
#pragma SWIG nowarn=314,325,453

%import(module="openmm") "swig/OpenMMSwigHeaders.i"
%include "std_string.i"

%{
#include "OpenMM.h"
#include "OpenMMAmoeba.h"
#include "OpenMMDrude.h"
#include "openmm/RPMDIntegrator.h"
#include "openmm/RPMDMonteCarloBarostat.h"
#include "openmmchaintree/internal/Interpreter.h"
#include "openmmchaintree/internal/Warnings.h"
#include "openmmchaintree/LoopGrowth.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionDensity.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>
%}

/* Annotations use names of openmmchaintree.pyi, and are for the stub alone. */
%pythonbegin %{
from __future__ import annotations
%}

%pythoncode %{
import copy
from typing import Literal, NamedTuple

import numpy
import openmm

from .units import inUnit


class TraversalStatistics(NamedTuple):
    """The operations that the queries and trials of a Context took."""

    queries: int
    volumeTests: int
    particleTests: int
    nodesUpdated: int


class MoveStatistics(NamedTuple):
    """The numbers of trials of a move, by their outcomes."""

    attempted: int
    clashed: int
    rejectedByEnergy: int
    accepted: int


class StageStatistics(NamedTuple):
    """The number of trials for which a part of the energy was computed, and the number that it rejected."""

    stage: str
    computed: int
    refused: int


class OuterStatistics(NamedTuple):
    """The numbers of outer tests, of accepted ones, and of undone trials; the differences (kJ/mol)."""

    attempted: int
    accepted: int
    trialsTakenBack: int
    meanDifference: float
    standardDeviation: float


class PlannedEnergy(NamedTuple):
    """How a Force is evaluated: "constant", "native", "foreign" or "not sampled"; how often, and why."""

    force: int
    name: str
    kind: Literal["not sampled", "constant", "native", "foreign"]
    reason: str


class EnergyPlan(list[PlannedEnergy]):
    """How the energy of each Force is evaluated: a list of PlannedEnergy that prints as a table."""

    def __str__(self):
        width = max([len(entry.name) for entry in self], default=0)
        return "\n".join(
            f"{entry.force:>3}  {entry.name:<{width}}  {entry.kind:<11}  {entry.reason}".rstrip() for entry in self
        )


class GrownLoop(NamedTuple):
    """A grown loop: positions of all particles (nm); logarithms of its weight and of the density of its torsions."""

    positions: _Floats
    logWeight: float
    logDensity: float


class MinimumDistance(NamedTuple):
    """The distance (nm) of the two particles of two sets that are nearest to each other."""

    distance: float
    particle1: int
    particle2: int
%}

/* Methods with default values take keywords, too; the others do so without help. */
%define %keywords(METHOD)
%feature("compactdefaultargs") METHOD;
%feature("kwargs") METHOD;
%enddef

%define %move(NAME)
%keywords(ChainTreePlugin::TorsionMonteCarloIntegrator::add ## NAME)
%keywords(ChainTreePlugin::TorsionMonteCarloIntegrator::set ## NAME ## Parameters)
%enddef

%keywords(ChainTreePlugin::StericExclusionForce::addParticle)
%keywords(ChainTreePlugin::StericExclusionForce::setParticleParameters)
%move(TorsionMove)
%move(RigidBodyMove)
%move(ClosedMove)
%move(LocalMove)
%move(PivotMove)
%move(CrankshaftMove)
%move(VolumeMove)
%move(GroupMove)
%move(AtomMove)

%header %{
static void raiseOpenMMException(const char* message) {
    PyObject* openmm = PyImport_ImportModule("openmm");
    PyObject* type = openmm == NULL ? NULL : PyObject_GetAttrString(openmm, "OpenMMException");
    if (type != NULL)
        PyErr_SetString(type, message);
    Py_XDECREF(type);
    Py_XDECREF(openmm);
}
%}

/* ---- Warnings ---- */

%header %{
/* Issues a warning of the C++ library as a Python warning, which names the caller of OpenMM's constructor of a Context.
 * A filter may turn it into an error. */
static void warnInPython(const std::string& message) {
    if (!Py_IsInitialized())
        return;
    PyGILState_STATE state = PyGILState_Ensure();
    bool isError = PyErr_WarnEx(PyExc_UserWarning, message.c_str(), 2) != 0;
    if (isError)
        PyErr_Clear();
    PyGILState_Release(state);
    if (isError)
        throw OpenMM::OpenMMException(message);
}
%}

/* ---- Signals and threads ---- */

%header %{
#ifndef _WIN32
#include <fcntl.h>
#include <unistd.h>
#endif

/* The exception that a handler of signals has raised, kept until the interrupted call has returned. */
static PyObject *raisedType = NULL, *raisedValue = NULL, *raisedTraceback = NULL;

static int raiseAgain(void*) {
    PyErr_Restore(raisedType, raisedValue, raisedTraceback);
    raisedType = raisedValue = raisedTraceback = NULL;
    return PyErr_Occurred() == NULL ? 0 : -1;
}

/* Steps run without Python's lock, and taking the lock only to look for signals could take longer than the trials in
 * between. So while a step runs in the main thread, Python writes the number of each signal to a pipe. This class reads
 * the pipe and passes the numbers on to the file that would have received them. Between steps, Python handles signals. */
class PythonSignals : public ChainTreePlugin::Interpreter {
public:
    bool mayWait() {
        return PyGILState_Check() == 0;
    }
#ifdef _WIN32
    bool beginWatch() {
        return false;
    }
    void endWatch() {
    }
    bool hasSignal() {
        return false;
    }
#else
    bool beginWatch() {
        int others;
        if (PyThread_get_thread_ident() != mainThread || !openPipe() || !sendTo(ends[1], others))
            return false;
        former.push_back(others);
        return true;
    }
    void endWatch() {
        int own;
        hasSignal();
        sendTo(former.back(), own);
        former.pop_back();
    }
    bool hasSignal() {
        char numbers[64];
        const ssize_t count = read(ends[0], numbers, sizeof(numbers));
        if (count <= 0)
            return false;
        const int others = former.back();
        if (others != -1 && others != ends[1] && write(others, numbers, count) < 0)
            return true; // that file is full, so its reader knows of signals already
        return true;
    }
#endif
    bool handleSignals() {
        PyGILState_STATE state = PyGILState_Ensure();
        const bool goesOn = PyErr_CheckSignals() == 0;
        if (!goesOn) {
            Py_CLEAR(raisedType);
            Py_CLEAR(raisedValue);
            Py_CLEAR(raisedTraceback);
            PyErr_Fetch(&raisedType, &raisedValue, &raisedTraceback);
            Py_AddPendingCall(raiseAgain, NULL);
        }
        PyGILState_Release(state);
        return goesOn;
    }
    /* Find out which thread is the main one. */
    void findMainThread() {
        PyObject* threading = PyImport_ImportModule("threading");
        PyObject* thread = threading == NULL ? NULL : PyObject_CallMethod(threading, "main_thread", NULL);
        PyObject* ident = thread == NULL ? NULL : PyObject_GetAttrString(thread, "ident");
        if (ident != NULL)
            mainThread = PyLong_AsUnsignedLong(ident);
        Py_XDECREF(ident);
        Py_XDECREF(thread);
        Py_XDECREF(threading);
        PyErr_Clear();
    }

private:
#ifndef _WIN32
    /* A forked process needs its own pipe. */
    bool openPipe() {
        if (owner == getpid())
            return true;
        if (pipe(ends) != 0)
            return false;
        for (int end : ends) {
            fcntl(end, F_SETFL, O_NONBLOCK);
            fcntl(end, F_SETFD, FD_CLOEXEC);
        }
        owner = getpid();
        return true;
    }
    /* Let Python write the numbers of signals to a file. */
    static bool sendTo(int file, int& others) {
        PyGILState_STATE state = PyGILState_Ensure();
        PyObject* module = PyImport_ImportModule("signal");
        PyObject* found = module == NULL ? NULL : PyObject_CallMethod(module, "set_wakeup_fd", "i", file);
        if (found != NULL)
            others = PyLong_AsLong(found);
        Py_XDECREF(found);
        Py_XDECREF(module);
        const bool isSet = PyErr_Occurred() == NULL;
        PyErr_Clear();
        PyGILState_Release(state);
        return isSet;
    }
    int ends[2] = {-1, -1};
    pid_t owner = -1;
#endif
    unsigned long mainThread = 0;
    /* The files that received signals before each running step: handlers may call step(), too. */
    std::vector<int> former;
};

static PythonSignals pythonSignals;
%}

%init %{
    ChainTreePlugin::setWarningHandler(warnInPython);
    pythonSignals.findMainThread();
    ChainTreePlugin::Interpreter::set(&pythonSignals);
%}

%exception {
    try {
        $action
    }
    catch (const std::exception& exception) {
        raiseOpenMMException(exception.what());
        SWIG_fail;
    }
}

/* A method that works on a Context, or may wait for one that does. */
%define %freesPython(METHOD)
%exception METHOD {
    PyThreadState* state = PyEval_SaveThread();
    try {
        $action
        PyEval_RestoreThread(state);
    }
    catch (const std::exception& exception) {
        PyEval_RestoreThread(state);
        raiseOpenMMException(exception.what());
        SWIG_fail;
    }
}
%enddef

%define %forceFreesPython(NAME)
%freesPython(ChainTreePlugin::StericExclusionForce::NAME)
%enddef
%formacro(%forceFreesPython,
          updateParametersInContext, hasClash, getClashes, getNeighborPairs, getMinimumDistance, getClashesWith,
          proposeTorsions, proposeBallRotations, proposeRigidMotion, getProposedPositions,
          getChangedNeighborPairs, acceptProposal, rejectProposal, restartLimits, getTorsionAngles,
          setTorsionAngles, getNumToleratedClashes, getTraversalStatistics, resetTraversalStatistics)

%define %integratorFreesPython(NAME)
%freesPython(ChainTreePlugin::TorsionMonteCarloIntegrator::NAME)
%enddef
%formacro(%integratorFreesPython,
          getTorsionAngles, setTorsionAngles, getNumToleratedClashes, getEnergyPlan, getPotentialEnergy,
          renewStandIns, getStageStatistics, getOuterStatistics, getMoveStatistics, resetMoveStatistics,
          checkVelocities, getStericModeInContext)

/* ---- From Python ---- */

%fragment("FromPython", "header") {
/* Each of these returns false, with a Python exception set, if the object has a wrong type or value. */

/* Gives a new reference to the object without its unit. */
static PyObject* removeUnit(PyObject* object, const char* unit, const char* name) {
    PyObject* module = PyImport_ImportModule("openmmchaintree.units");
    if (module == NULL)
        return NULL;
    PyObject* result = PyObject_CallMethod(module, "inUnit", "Oss", object, unit, name);
    Py_DECREF(module);
    return result;
}

static bool toDouble(PyObject* object, const char* unit, const char* name, double& value) {
    PyObject* number = PyFloat_CheckExact(object) ? Py_NewRef(object) : removeUnit(object, unit, name);
    if (number == NULL)
        return false;
    value = PyFloat_AsDouble(number);
    Py_DECREF(number);
    if (PyErr_Occurred() == NULL)
        return true;
    PyErr_Format(PyExc_TypeError, "%s must be a number, not %s", name, Py_TYPE(object)->tp_name);
    return false;
}

/* Gives a new float, or Quantity if the unit is not "1". */
static PyObject* addUnit(double value, const char* unit) {
    if (std::strcmp(unit, "1") == 0)
        return PyFloat_FromDouble(value);
    PyObject* module = PyImport_ImportModule("openmmchaintree.units");
    PyObject* result = module == NULL ? NULL : PyObject_CallMethod(module, "withUnit", "ds", value, unit);
    Py_XDECREF(module);
    return result;
}

static bool toInt(PyObject* object, const char* name, int& value) {
    PyObject* number = PyNumber_Index(object);
    if (number == NULL) {
        PyErr_Format(PyExc_TypeError, "%s must be an integer, not %s", name, Py_TYPE(object)->tp_name);
        return false;
    }
    long result = PyLong_AsLong(number);
    Py_DECREF(number);
    if (PyErr_Occurred() != NULL || result != (int) result) {
        PyErr_Clear();
        PyErr_Format(PyExc_ValueError, "%s is out of the range of integers", name);
        return false;
    }
    value = (int) result;
    return true;
}

/* Converts each item of a sequence by a function that returns false on failure. The items are held in a tuple, since
 * converting an item may run Python code, which could change a list. */
template <class Convert>
static bool forEach(PyObject* object, const char* what, const char* name, Convert convert) {
    PyObject* tuple = PySequence_Tuple(object);
    if (tuple == NULL && PyErr_ExceptionMatches(PyExc_TypeError))
        PyErr_Format(PyExc_TypeError, "%s must be a %s, not %s", name, what, Py_TYPE(object)->tp_name);
    bool ok = tuple != NULL;
    for (Py_ssize_t i = 0; ok && i < PyTuple_GET_SIZE(tuple); i++)
        ok = convert(PyTuple_GET_ITEM(tuple, i));
    Py_XDECREF(tuple);
    return ok;
}

template <class Convert>
static bool forEachWithoutUnit(PyObject* object, const char* unit, const char* name, Convert convert) {
    PyObject* numbers = removeUnit(object, unit, name);
    const bool ok = numbers != NULL && forEach(numbers, "sequence", name, convert);
    Py_XDECREF(numbers);
    return ok;
}

static bool toDoubles(PyObject* object, const char* unit, const char* name, std::vector<double>& values) {
    return forEachWithoutUnit(object, unit, name, [&](PyObject* item) {
        values.emplace_back();
        return toDouble(item, unit, name, values.back());
    });
}

static bool toInts(PyObject* object, const char* name, std::vector<int>& values) {
    return forEach(object, "sequence", name, [&](PyObject* item) {
        values.emplace_back();
        return toInt(item, name, values.back());
    });
}

static bool toVec3(PyObject* object, const char* unit, const char* name, OpenMM::Vec3& value) {
    std::vector<double> values;
    if (!toDoubles(object, unit, name, values))
        return false;
    if (values.size() != 3) {
        PyErr_Format(PyExc_ValueError, "%s must have 3 components, not %zu", name, values.size());
        return false;
    }
    value = OpenMM::Vec3(values[0], values[1], values[2]);
    return true;
}

static bool toVec3s(PyObject* object, const char* unit, const char* name, std::vector<OpenMM::Vec3>& values) {
    return forEachWithoutUnit(object, unit, name, [&](PyObject* item) {
        values.emplace_back();
        return toVec3(item, unit, name, values.back());
    });
}
}

%define %unit(UNIT, NAME)
%typemap(in, fragment="FromPython") double NAME {
    if (!toDouble($input, UNIT, "NAME", $1))
        SWIG_fail;
}
%typemap(in, fragment="FromPython") const std::vector<double>& NAME (std::vector<double> values) {
    if (!toDoubles($input, UNIT, "NAME", values))
        SWIG_fail;
    $1 = &values;
}
%typemap(in, fragment="FromPython") const OpenMM::Vec3& NAME (OpenMM::Vec3 value) {
    if (!toVec3($input, UNIT, "NAME", value))
        SWIG_fail;
    $1 = &value;
}
%typemap(in, fragment="FromPython") const std::vector<OpenMM::Vec3>& NAME (std::vector<OpenMM::Vec3> values) {
    if (!toVec3s($input, UNIT, "NAME", values))
        SWIG_fail;
    $1 = &values;
}
%typemap(doctype) double NAME "float or Quantity"
%typemap(doctype) const std::vector<OpenMM::Vec3>& NAME "sequence of shape (n, 3), or Quantity"
%typemap(doctype) const std::vector<double>& NAME "sequence of float, or Quantity"
%typemap(doctype) const OpenMM::Vec3& NAME "sequence of 3 floats, or Quantity"
%enddef

%unit("nm", radius)
%unit("nm", tolerance)
%unit("nm", allowance)
%unit("nm", cutoff)
%unit("nm", position)
%unit("nm", positions)
%unit("nm", translation)
%unit("rad", changes)
%unit("rad", angles)
%unit("rad", rotation)
%unit("rad", rotations)
%unit("K", temperature)
%unit("kJ/mol/nm^2", k)
%unit("nm", bornCutoff)
%unit("nm", pairCutoff)
%unit("1", floor)
%unit("1", scales)
%unit("1", values)
%unit("1", weights)
%unit("rad", means)
%unit("rad", widths)

%typemap(in, fragment="FromPython") int {
    if (!toInt($input, "$1_name", $1))
        SWIG_fail;
}
%typemap(in, fragment="FromPython") const std::vector<int>& (std::vector<int> values) {
    if (!toInts($input, "$1_name", values))
        SWIG_fail;
    $1 = &values;
}
%typemap(doctype) const std::vector<int>& "sequence of int"
%typemap(in, fragment="FromPython") ChainTreePlugin::StericExclusionForce::HydrogenBondRole {
    int role;
    if (!toInt($input, "$1_name", role))
        SWIG_fail;
    if (role < 0 || role > ChainTreePlugin::StericExclusionForce::DonorAndAcceptor) {
        PyErr_SetString(PyExc_ValueError,
                        "$1_name must be NoHydrogenBond, Donor, Acceptor or DonorAndAcceptor of StericExclusionForce");
        SWIG_fail;
    }
    $1 = (ChainTreePlugin::StericExclusionForce::HydrogenBondRole) role;
}

/* ---- To Python ---- */

%fragment("ToNumPy", "header") {
/* A NumPy array of shape (count), or (count, columns) if columns is not 0, that owns a copy of the values. */
static PyObject* toNumPy(const void* values, size_t count, int columns, size_t itemSize, const char* dtype) {
    size_t items = count * (columns == 0 ? 1 : columns);
    PyObject* bytes = PyByteArray_FromStringAndSize(NULL, items * itemSize);
    if (bytes == NULL)
        return NULL;
    if (items > 0)
        std::memcpy(PyByteArray_AsString(bytes), values, items * itemSize);
    PyObject* numpy = PyImport_ImportModule("numpy");
    PyObject* array = numpy == NULL ? NULL : PyObject_CallMethod(numpy, "frombuffer", "Os", bytes, dtype);
    if (array != NULL && columns != 0) {
        PyObject* table = PyObject_CallMethod(array, "reshape", "ni", (Py_ssize_t) count, columns);
        Py_DECREF(array);
        array = table;
    }
    Py_XDECREF(numpy);
    Py_DECREF(bytes);
    return array;
}
}

%define %outputArray(TYPE, COLUMNS, ITEM, DTYPE, SHAPE, NAME)
%typemap(in, numinputs=0) TYPE& NAME (TYPE values) {
    $1 = &values;
}
%typemap(argout, fragment="ToNumPy") TYPE& NAME {
    PyObject* array = toNumPy($1->data(), $1->size(), COLUMNS, sizeof(ITEM), "DTYPE");
    if (array == NULL)
        SWIG_fail;
    $result = SWIG_AppendOutput($result, array);
}
/* Constant references are arguments, not results. */
%typemap(argout) const TYPE& NAME ""
%typemap(doctype) TYPE& NAME "numpy.ndarray of DTYPE, shape SHAPE"
%enddef

%outputArray(%arg(std::vector<std::pair<int, int> >), 2, int, int32, %arg((n, 2)), pairs)
%outputArray(std::vector<int>, 0, int, int32, (n), particles)
%outputArray(std::vector<double>, 0, double, float64, (n), overlaps)
%outputArray(std::vector<double>, 0, double, float64, (n), distances)
%outputArray(std::vector<double>, 0, double, float64, (n), before)
%outputArray(std::vector<double>, 0, double, float64, (n), after)
%outputArray(std::vector<double>, 0, double, float64, (n), angles)
%outputArray(std::vector<int>, 0, int, int32, (n), numBins)
%outputArray(std::vector<double>, 0, double, float64, (n), values)
%outputArray(std::vector<double>, 0, double, float64, (n), scales)
%outputArray(std::vector<double>, 0, double, float64, (n), weights)
%outputArray(std::vector<double>, 0, double, float64, (n), means)
%outputArray(std::vector<double>, 0, double, float64, (n), widths)
%outputArray(std::vector<OpenMM::Vec3>, 3, double, float64, %arg((n, 3)), positions)

%typemap(in, numinputs=0) double& (double value), int& (int value), long long& (long long value), bool& (bool value) {
    $1 = &value;
}
%typemap(in, numinputs=0) ChainTreePlugin::StericExclusionForce::HydrogenBondRole& (ChainTreePlugin::StericExclusionForce::HydrogenBondRole value) {
    $1 = &value;
}
%typemap(argout) double& {
    $result = SWIG_AppendOutput($result, PyFloat_FromDouble(*$1));
}
%typemap(argout) int&, long long&, ChainTreePlugin::StericExclusionForce::HydrogenBondRole& {
    $result = SWIG_AppendOutput($result, PyLong_FromLongLong(*$1));
}

%typemap(argout) bool& {
    $result = SWIG_AppendOutput($result, PyBool_FromLong(*$1));
}

%fragment("ToList", "header") {
/* A list of what a function makes of each value. */
template <class Value, class Convert>
static PyObject* toList(const std::vector<Value>& values, Convert convert) {
    PyObject* list = PyList_New(0);
    for (const Value& value : values) {
        PyObject* item = list == NULL ? NULL : convert(value);
        if (item == NULL || PyList_Append(list, item) != 0)
            Py_CLEAR(list);
        Py_XDECREF(item);
    }
    return list;
}
}

/* Lists of tuples, of which %pythonappend makes named ones. */
%define %outputTuples(TYPE, FORMAT, VALUES, PYTHON)
%typemap(out, fragment="ToList") std::vector<TYPE> {
    const std::vector<TYPE>& entries = $1;
    $result = toList(entries, [](const TYPE& entry) { return Py_BuildValue(FORMAT, VALUES); });
    if ($result == NULL)
        SWIG_fail;
}
%typemap(doctype) std::vector<TYPE> PYTHON
%enddef

%header %{
static const char* const ENERGY_KINDS[] = {"not sampled", "constant", "native", "foreign"};
%}

%outputTuples(ChainTreePlugin::TorsionMonteCarloIntegrator::PlannedEnergy, "(isss)",
              %arg(entry.force, entry.name.c_str(), ENERGY_KINDS[entry.kind], entry.reason.c_str()), "EnergyPlan")
%outputTuples(ChainTreePlugin::TorsionMonteCarloIntegrator::StageStatistics, "(sLL)",
              %arg(entry.stage.c_str(), entry.computed, entry.refused), "list of StageStatistics")

/* ---- Results and methods in Python ---- */

/* What Python makes of SWIG's result `val`. */
%define %returns(METHOD, VALUE)
%pythonappend METHOD %{
    val = VALUE
%}
%enddef

/* Parameters come back as OpenMM's own classes give them: as Quantities. */
%returns(ChainTreePlugin::StericExclusionForce::getOverlapTolerance, %arg(openmm.unit.Quantity(val, openmm.unit.nanometer)))
%returns(ChainTreePlugin::StericExclusionForce::getHydrogenBondAllowance, %arg(openmm.unit.Quantity(val, openmm.unit.nanometer)))
%returns(ChainTreePlugin::StericExclusionForce::getForceConstant, %arg(openmm.unit.Quantity(val, openmm.unit.kilojoule_per_mole / openmm.unit.nanometer**2)))
%returns(ChainTreePlugin::StericExclusionForce::getParticleParameters, %arg([openmm.unit.Quantity(val[0], openmm.unit.nanometer), val[1]]))
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getTemperature, %arg(openmm.unit.Quantity(val, openmm.unit.kelvin)))
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getStandInCutoffs, %arg(tuple(openmm.unit.Quantity(cutoff, openmm.unit.nanometer) for cutoff in val)))

/* Lists of different things would all be Any to a type checker. */
%returns(ChainTreePlugin::StericExclusionForce::getClashes, tuple(val))
%returns(ChainTreePlugin::StericExclusionForce::getNeighborPairs, tuple(val))
%returns(ChainTreePlugin::StericExclusionForce::getClashesWith, tuple(val))
%returns(ChainTreePlugin::StericExclusionForce::getChangedNeighborPairs, tuple(val))
%returns(ChainTreePlugin::StericExclusionForce::getMinimumDistance, MinimumDistance(*val))
%returns(ChainTreePlugin::StericExclusionForce::getTraversalStatistics, TraversalStatistics(*val))
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getMoveStatistics, MoveStatistics(*val))
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getOuterStatistics, OuterStatistics(*val))
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getStageStatistics, [StageStatistics(*counts) for counts in val])
%returns(ChainTreePlugin::TorsionMonteCarloIntegrator::getEnergyPlan, EnergyPlan(PlannedEnergy(*entry) for entry in val))

/* Integrator's own wrapper of step() handles threads and exceptions; the class is not abstract without it. */
%ignore ChainTreePlugin::TorsionMonteCarloIntegrator::step;
%feature("notabstract") ChainTreePlugin::TorsionMonteCarloIntegrator;

%extend ChainTreePlugin::TorsionMonteCarloIntegrator {
%pythoncode %{
    def computeSystemTemperature(self) -> Quantity:
        """Get the temperature of the heat bath, a Quantity in K, which is the sampled temperature.

        StateDataReporter shows it in place of a kinetic temperature.
        """
        return self.getTemperature()

    def __repr__(self):
        moves = [self.getMoveDescription(index) for index in range(min(self.getNumMoves(), 4))]
        if self.getNumMoves() > len(moves):
            moves.append("...")
        count = "1 move" if self.getNumMoves() == 1 else f"{self.getNumMoves()} moves"
        kelvin = self.getTemperature().value_in_unit(openmm.unit.kelvin)
        spheres = {self.Automatic: "", self.Off: "no spheres, ", self.Hard: "hard spheres, ", self.Soft: "soft spheres, "}
        return (
            f"<TorsionMonteCarloIntegrator: {kelvin:g} K, {self.getTrialsPerStep():,} trials a step, "
            f"{spheres[self.getStericMode()]}{count}{': ' if moves else ''}{', '.join(moves)}>"
        )
%}
}

%extend ChainTreePlugin::StericExclusionForce {
%pythoncode %{
    def __repr__(self):
        tolerance = self.getOverlapTolerance().value_in_unit(openmm.unit.nanometer)
        ballJoints = f"{self.getNumBallJoints():,} ball joints, " if self.getNumBallJoints() > 0 else ""
        periodic = ", periodic" if self.usesPeriodicBoundaryConditions() else ""
        return (
            f"<StericExclusionForce: {self.getNumParticles():,} particles, {self.getNumBonds():,} bonds, "
            f"{self.getNumTorsions():,} torsions, {ballJoints}{self.getNumExclusions():,} exclusions, "
            f"overlapTolerance {tolerance:g} nm{periodic}>"
        )
%}
}

/* A Force or Integrator that comes from a System, a CompoundIntegrator or XmlSerializer has lost its class, and OpenMM's
 * own ways of copying and pickling would lose it too. */
%define %ownClass(CLASS, BASE)
%extend ChainTreePlugin::CLASS {
    /**
     * Get whether an object is a CLASS, whatever its Python class.
     */
    static bool isinstance(OpenMM::BASE& object) {
        return dynamic_cast<ChainTreePlugin::CLASS*>(&object) != NULL;
    }
    static ChainTreePlugin::CLASS& _cast(OpenMM::BASE& object) {
        ChainTreePlugin::CLASS* result = dynamic_cast<ChainTreePlugin::CLASS*>(&object);
        if (result == NULL)
            throw OpenMM::OpenMMException("cast: the object is not a CLASS");
        return *result;
    }
%pythoncode %{
    @staticmethod
    def cast(object: openmm.BASE) -> CLASS:
        """Give an object back the class that it is.

        Parameters
        ----------
        object : openmm.BASE
            a CLASS that came as a bare BASE: what a System, a CompoundIntegrator or XmlSerializer returns has
            its class already, but not what C++ returns elsewhere

        Returns
        -------
        CLASS
            the same object
        """
        if not isinstance(object, CLASS):
            this = CLASS._cast(object).this
            if object.this.own():
                object.this.disown()
                this.acquire()
            object.this = this
            object.__class__ = CLASS
        return object

    def __getstate__(self):
        attributes = {name: value for name, value in self.__dict__.items() if name != "this"}
        return openmm.XmlSerializer.serialize(self), attributes

    def __setstate__(self, state):
        xml, attributes = state
        self.this = CLASS.cast(openmm.XmlSerializer.deserialize(xml)).this
        self.__dict__.update(attributes)

    def __copy__(self):
        duplicate = self.__class__.__new__(self.__class__)
        duplicate.__setstate__(self.__getstate__())
        return duplicate

    def __deepcopy__(self, memo):
        xml, attributes = self.__getstate__()
        duplicate = memo[id(self)] = self.__class__.__new__(self.__class__)
        duplicate.__setstate__((xml, copy.deepcopy(attributes, memo)))
        return duplicate
%}
}
%enddef

%ownClass(StericExclusionForce, Force)
%ownClass(TorsionMonteCarloIntegrator, Integrator)

#define OPENMM_EXPORT_CHAINTREE
%include "openmmchaintree/StericExclusionForce.h"

/* ---- Densities, and moves that draw from them ---- */

/* Tables come with their shape, and a mean and a width for each torsion of a rotamer come in rows. */
%feature("compactdefaultargs") ChainTreePlugin::TorsionDensity::fromTable;
%rename(_fromTable) ChainTreePlugin::TorsionDensity::fromTable;
%rename(_fromRotamers) ChainTreePlugin::TorsionDensity::fromRotamers;
%rename(_getTable) ChainTreePlugin::TorsionDensity::getTable;
%rename(_getRotamers) ChainTreePlugin::TorsionDensity::getRotamers;
%rename(_isSame) ChainTreePlugin::TorsionDensity::operator==;

%extend ChainTreePlugin::TorsionDensity {
%pythoncode %{
    __hash__ = None

    @staticmethod
    def fromTable(values: npt.ArrayLike, floor: float = 0.0) -> TorsionDensity:
        """Create a density that is constant in each bin of a grid, which cuts the circle of each torsion into bins of
        equal width. The first bin of each begins at -pi.

        Parameters
        ----------
        values : array
            a number for each bin, proportional to the density in it, with one dimension per torsion. The numbers must
            be above 0, or at least 0 with a floor.
        floor : float
            the share of draws that are uniform, from 0 to 1

        Returns
        -------
        TorsionDensity
        """
        values = numpy.asarray(values, dtype=numpy.float64)
        return TorsionDensity._fromTable(values.shape, values.ravel(), floor)

    @staticmethod
    def fromRotamers(
        weights: _Vector, means: npt.ArrayLike | Quantity, widths: npt.ArrayLike | Quantity, floor: float
    ) -> TorsionDensity:
        """Create a density that is a sum of rotamers. Each of them is drawn as often as its weight says, and then each
        of its torsions from a bell about its mean: a cubic B-spline, wrapped around the circle, which differs from a
        normal density of the same standard deviation by 4% of its height at most, and ends after 3.46 deviations.

        Parameters
        ----------
        weights : array of shape (rotamers)
            how often each rotamer is drawn, relative to the others
        means : array of shape (rotamers, torsions) or Quantity
            the mean of each torsion in each rotamer, from -pi to pi, in radians
        widths : array of shape (rotamers, torsions) or Quantity
            the standard deviations, above 0 and at most pi, in radians
        floor : float
            the share of draws of each torsion that are uniform whatever the rotamer, above 0 and at most 1

        Returns
        -------
        TorsionDensity
        """
        arrays = [
            numpy.asarray(inUnit(values, "rad", name), dtype=numpy.float64)
            for values, name in ((means, "means"), (widths, "widths"))
        ]
        if any(values.ndim != 2 or len(values) != len(weights) for values in arrays):
            raise ValueError(f"means and widths must have a row for each of {len(weights)} rotamers")
        return TorsionDensity._fromRotamers(weights, *(values.ravel() for values in arrays), floor)

    def getTable(self) -> _Floats:
        """Get the values that fromTable() was given. It is an error if this is a sum of rotamers.

        Returns
        -------
        numpy.ndarray of float64
            a number for each bin, with one dimension per torsion
        """
        numBins, values = self._getTable()
        return values.reshape(numBins)

    def getRotamers(self) -> tuple[_Floats, _Floats, _Floats]:
        """Get what fromRotamers() was given. It is an error if this is a table.

        Returns
        -------
        weights, means, widths : numpy.ndarray of float64
            of the shapes (rotamers), (rotamers, torsions) and (rotamers, torsions); angles in radians
        """
        weights, means, widths = self._getRotamers()
        return weights, means.reshape(len(weights), -1), widths.reshape(len(weights), -1)

    def __eq__(self, other):
        return self._isSame(other) if isinstance(other, TorsionDensity) else NotImplemented

    def __reduce__(self):
        if self.isTable():
            return TorsionDensity.fromTable, (self.getTable(), self.getFloor())
        return TorsionDensity.fromRotamers, (*self.getRotamers(), self.getFloor())

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self

    def __repr__(self):
        if self.isTable():
            kind = " x ".join(str(count) for count in self.getTable().shape) + " bins"
        else:
            kind = f"{len(self.getRotamers()[0])} rotamers of {self.getNumTorsions()} torsions"
        return f"<TorsionDensity: {kind}, floor {self.getFloor():g}>"
%}
}

%include "openmmchaintree/TorsionDensity.h"

%fragment("DrawnSets", "header", fragment="FromPython") {
/* Sets of torsions; a number alone is a set of one. */
static bool toSets(PyObject* object, const char* name, std::vector<std::vector<int> >& sets) {
    return forEach(object, "sequence", name, [&](PyObject* item) {
        sets.emplace_back();
        if (PySequence_Check(item))
            return toInts(item, name, sets.back());
        sets.back().resize(1);
        return toInt(item, name, sets.back()[0]);
    });
}

static bool addDensity(PyObject* object, std::vector<ChainTreePlugin::TorsionDensity>& densities) {
    void* density;
    if (!SWIG_IsOK(SWIG_ConvertPtr(object, &density, $descriptor(ChainTreePlugin::TorsionDensity*), SWIG_POINTER_NO_NULL)))
        return false;
    densities.push_back(*(ChainTreePlugin::TorsionDensity*) density);
    return true;
}

/* A density, or a sequence of densities. */
static bool toDensities(PyObject* object, const char* name, std::vector<ChainTreePlugin::TorsionDensity>& densities) {
    const char* const what = "TorsionDensity or a sequence of them";
    return addDensity(object, densities) || forEach(object, what, name, [&](PyObject* item) {
        if (addDensity(item, densities))
            return true;
        PyErr_Format(PyExc_TypeError, "%s must be a %s, not of %s", name, what, Py_TYPE(item)->tp_name);
        return false;
    });
}
}

%typemap(in, fragment="DrawnSets") const std::vector<std::vector<int> >& torsions (std::vector<std::vector<int> > sets) {
    if (!toSets($input, "$1_name", sets))
        SWIG_fail;
    $1 = &sets;
}
%typemap(in, fragment="DrawnSets") const std::vector<ChainTreePlugin::TorsionDensity>& densities (std::vector<ChainTreePlugin::TorsionDensity> values) {
    if (!toDensities($input, "density", values))
        SWIG_fail;
    $1 = &values;
}
%typemap(in, numinputs=0) std::vector<std::vector<int> >& torsions (std::vector<std::vector<int> > sets) {
    $1 = &sets;
}
%typemap(in, numinputs=0) std::vector<ChainTreePlugin::TorsionDensity>& densities (std::vector<ChainTreePlugin::TorsionDensity> values) {
    $1 = &values;
}
%typemap(argout) const std::vector<std::vector<int> >& torsions, const std::vector<ChainTreePlugin::TorsionDensity>& densities ""
%typemap(argout, fragment="ToList") std::vector<std::vector<int> >& torsions {
    PyObject* list = toList(*$1, [](const std::vector<int>& set) {
        PyObject* indices = toList(set, [](int index) { return PyLong_FromLong(index); });
        PyObject* tuple = indices == NULL ? NULL : PyList_AsTuple(indices);
        Py_XDECREF(indices);
        return tuple;
    });
    if (list == NULL)
        SWIG_fail;
    $result = SWIG_AppendOutput($result, list);
}
%typemap(argout, fragment="ToList") std::vector<ChainTreePlugin::TorsionDensity>& densities {
    PyObject* list = toList(*$1, [](const ChainTreePlugin::TorsionDensity& density) {
        return SWIG_NewPointerObj(new ChainTreePlugin::TorsionDensity(density),
                                  $descriptor(ChainTreePlugin::TorsionDensity*), SWIG_POINTER_OWN);
    });
    if (list == NULL)
        SWIG_fail;
    $result = SWIG_AppendOutput($result, list);
}

/* ---- Loops ---- */

%freesPython(ChainTreePlugin::LoopGrowth::grow)
%returns(ChainTreePlugin::LoopGrowth::grow, GrownLoop(*val))
%include "openmmchaintree/LoopGrowth.h"

%rename(_addDrawnMove) ChainTreePlugin::TorsionMonteCarloIntegrator::addDrawnMove;
%rename(_setDrawnMoveParameters) ChainTreePlugin::TorsionMonteCarloIntegrator::setDrawnMoveParameters;

%pythoncode %{
def _setsAndDensities(torsions, density):
    """Return the sets and densities of a drawn move. If the density is None, the sets have to come with it."""
    if density is None:
        if not hasattr(torsions, "density"):
            raise TypeError(
                "without a density torsions must be what rotamerDensities() or ramachandranDensities() returned"
            )
        return torsions.torsions, torsions.density
    return getattr(torsions, "torsions", torsions), density
%}

%extend ChainTreePlugin::TorsionMonteCarloIntegrator {
%pythoncode %{
    def addDrawnMove(
        self,
        weight: float,
        torsions: DrawnTorsions | Sequence[int | Sequence[int]],
        density: TorsionDensity | Sequence[TorsionDensity] | None = None,
    ) -> int:
        """Add a move that draws new values of torsions from a density, independent of the old ones. A trial chooses one
        of some sets of torsions with equal probability, such as all torsions of a side chain or phi and psi of a
        residue. With p the density of the set, q its present values and q' the drawn ones, it is accepted with
        min(1, exp(-(U' - U)/kT) p(q)/p(q')), so that the sampled distribution does not depend on the density.

        A good density is close to the sampled one. For side chains and backbones of proteins, write

            integrator.addDrawnMove(1, rotamerDensities(topology, force))
            integrator.addDrawnMove(1, ramachandranDensities(topology, force))

        The values of the torsions are those of their four particles. If three of these are collinear, the torsion has
        no value, and a trial that would draw it is an error.

        Parameters
        ----------
        weight : float
            how often this move is drawn, relative to the weights of the others, at least 0
        torsions : DrawnTorsions, or sequence of int or of sequences of int
            the sets, each of different torsions of the StericExclusionForce, by their indices; a number alone is a set
            of one. Different sets can have torsions in common.
        density : TorsionDensity, or sequence of TorsionDensity, optional
            the density of each set, for its torsions in their order; or one density for all. Default: those of
            DrawnTorsions, from tables by residue.

        Returns
        -------
        int
            the index of the move that was added
        """
        return self._addDrawnMove(weight, *_setsAndDensities(torsions, density))

    def setDrawnMoveParameters(
        self,
        move: int,
        weight: float,
        torsions: DrawnTorsions | Sequence[int | Sequence[int]],
        density: TorsionDensity | Sequence[TorsionDensity] | None = None,
    ) -> None:
        """Set the parameters of a move that was added by addDrawnMove(). It is an error if the move is of another kind.
        The next trial follows them. The counts of the move restart from 0.

        Parameters
        ----------
        move : int
            the index of the move
        weight : float
            how often this move is drawn, relative to the weights of the others, at least 0
        torsions : DrawnTorsions, or sequence of int or of sequences of int
            the sets of torsions
        density : TorsionDensity, or sequence of TorsionDensity, optional
            the density of each set, or one density for all. Default: those of DrawnTorsions.
        """
        self._setDrawnMoveParameters(move, weight, *_setsAndDensities(torsions, density))
%}
}

/* ---- Moves: units as MoveKind declares them, and lists of choices ---- */

%{
#include "openmmchaintree/internal/MonteCarloMove.h"
%}

%typemap(in, fragment="FromPython") double {
    if (!toDouble($input, ChainTreePlugin::MoveKind::findUnit("$symname", "$1_name").c_str(), "$1_name", $1))
        SWIG_fail;
}
%typemap(doctype) double "float or Quantity"
%typemap(doctype) double&, double weight, double hop, double scale, double width, double getPotentialEnergy "float"
%typemap(argout, fragment="FromPython") double& {
    $result = SWIG_AppendOutput($result, addUnit(*$1, ChainTreePlugin::MoveKind::findUnit("$symname", "$1_name").c_str()));
}

/* In C++ an empty vector means all; in Python an empty list is usually the result of a search that found nothing. */
%typemap(in, fragment="FromPython") const std::vector<int>& (std::vector<int> values) {
    if ($input != Py_None) {
        if (!toInts($input, "$1_name", values))
            SWIG_fail;
        if (values.empty()) {
            raiseOpenMMException("TorsionMonteCarloIntegrator: $1_name is empty, so that the move could move nothing; "
                                 "None means all of them");
            SWIG_fail;
        }
    }
    $1 = &values;
}
%typemap(doctype) const std::vector<int>& "sequence of int, or None"
%typemap(in, numinputs=0) std::vector<int>& (std::vector<int> values), std::vector<int>& particles (std::vector<int> values) {
    $1 = &values;
}
%typemap(argout, fragment="ToNumPy") std::vector<int>&, std::vector<int>& particles {
    PyObject* indices = $1->empty() ? Py_NewRef(Py_None) : toNumPy($1->data(), $1->size(), 0, sizeof(int), "int32");
    if (indices == NULL)
        SWIG_fail;
    $result = SWIG_AppendOutput($result, indices);
}
%typemap(argout) const std::vector<int>&, const std::vector<int>& particles ""
%typemap(doctype) std::vector<int>& "numpy.ndarray of int32, shape (n)"

%extend ChainTreePlugin::TorsionMonteCarloIntegrator {
    /* Get a line for each parameter of each kind of move, with tabs between its parts. */
    static std::string _listMoveParameters() {
        std::string lines;
        for (const ChainTreePlugin::MoveKind* kind : ChainTreePlugin::MoveKind::getAll())
            for (const ChainTreePlugin::MoveParameter& one : kind->parameters)
                lines += kind->element + "\t" + one.name + "\t" + one.text + "\t" + one.unit + "\t" + one.getRange() + "\n";
        return lines;
    }
}

%include "openmmchaintree/TorsionMonteCarloIntegrator.h"
