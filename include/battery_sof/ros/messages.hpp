#pragma once

/**
 * The package's messages and services beside the core's headers.
 *
 * ROS puts message types into a namespace of the package's name, which is the core's namespace too,
 * and both have an IdentifiedModel. Here, and wherever this header is included, the message is
 * IdentifiedModelMessage. A file that includes <battery_sof/IdentifiedModel.h> itself must not
 * include core headers.
 */
#define IdentifiedModel IdentifiedModelMessage
#include <battery_sof/IdentifiedModel.h>
#include <battery_sof/Identify.h>
#undef IdentifiedModel
#include <battery_sof/PredictCranking.h>
#include <battery_sof/SimulateProfile.h>
#include <battery_sof/SofStatus.h>
