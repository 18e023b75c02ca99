#pragma once

#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"

/// The parts of the diagnosis page, as HTML; a part that has nothing to say is empty.
namespace battery_sof {

/// @return what the page's times count from [s]: 0, or the first sample of a clock that counts from
/// 1970.
double clockOrigin(const Series& series);

std::string plotsSection(const Recording& recording, const Diagnosis& diagnosis, bool zoomable);
/// Who controls the voltage and who the current: one bar with the shares, and the reasons. Not a
/// section: it goes below the plots.
std::string sourceHtml(const Diagnosis& diagnosis);
std::string whereSection(const Diagnosis& diagnosis, double clock_origin);
std::string evidenceSection(const Diagnosis& diagnosis);
std::string effectsSection(const Diagnosis& diagnosis);
std::string comparisonSection(const Diagnosis& diagnosis);
std::string detectionLimitsSection(const Diagnosis& diagnosis);
std::string unexplainedSection(const Diagnosis& diagnosis);
/// A discrepancy model as charts over time and current, the nearest equation, and the numbers.
/// @param diagnosis with something estimated.
std::string discrepancyHtml(const Diagnosis& diagnosis);
std::string nextSection(const Diagnosis& diagnosis);
std::string readingSection();

/// @return <section id><h2>title</h2>body</section>; empty when the body is.
std::string section(const std::string& id, const std::string& title, const std::string& body);

}  // namespace battery_sof
