#pragma once

// The package's messages, services and actions. ROS puts them into the core's namespace: the message
// IdentifiedModel is the core's FittedModel on the wire. A Diagnosis and a StopTimeAnswer are both:
// the messages go by the names DiagnosisMessage and StopTimeMessage here.
#define Diagnosis DiagnosisMessage
#define StopTimeAnswer StopTimeMessage
#include <battery_sof/DiagnoseAction.h>
#include <battery_sof/Diagnosis.h>
#include <battery_sof/SofStatus.h>
#undef Diagnosis
#undef StopTimeAnswer
#include <battery_sof/IdentifiedModel.h>
#include <battery_sof/IdentifyAction.h>
#include <battery_sof/PredictChargeAcceptance.h>
#include <battery_sof/PredictCranking.h>
#include <battery_sof/PredictMap.h>
#include <battery_sof/PredictStopTime.h>
#include <battery_sof/SetStandingQuery.h>
#include <battery_sof/SimulateProfile.h>
