#pragma once

#include "estimation/fitted_model.hpp"
#include "yaml_reader.hpp"

/// The parts of MODEL.yaml, read into a model one by one: each number is held against what it can
/// be.
namespace battery_sof {

/// Effects, parameters, state, covariance and errors. @throws ModelFileError.
void readEquations(const Reader& root, FittedModel& model);

/// What the window gave in addition to the equations: baseline predictors, source, past events,
/// regressions. After readEquations().
void readLessons(const Reader& root, FittedModel& model);

/// Runs the model for a second of discharge and of charge. @throws ModelFileError when voltage or
/// interval come out as no numbers.
void requireRuns(const Reader& root, const FittedModel& model);

}  // namespace battery_sof
