#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

// Texts that every page holds, embedded when the package is built (cmake/embed_page_assets.cmake).
extern const char kPageCss[];  ///< src/report/page/page.css
extern const char kPageJs[];   ///< src/report/page/page.js
// The plot library of Debian's package libjs-dygraphs; empty where it was not installed at build
// time.
extern const char kDygraphsJs[];
extern const char kDygraphsCss[];
extern const char kDygraphsNotice[];  ///< its licence, which goes wherever it goes

// ---------------------------------------------------------------------------------------------
// HTML

/// @return text that stands for itself between tags and inside quoted attributes.
std::string escaped(const std::string& text);

/// @return <name class attributes>content</name>; content and attributes are HTML already.
/// @param name with its classes as a style sheet names them: "p" or "p.note".
std::string element(const std::string& name, const std::string& content,
                    const std::string& attributes = "");

/// A drawing below what it shows and the key to its lines; HTML already. @param name "figure.chart".
std::string figure(const std::string& name, const std::string& what, const std::string& legend,
                   const std::string& drawing);

/// What a line of a drawing is. @param style of a stroke like it.
std::string keyEntry(const std::string& name, const std::string& style);

/// What is folded away below a summary.
std::string details(const std::string& summary, const std::string& content);

inline constexpr char kNumber[] = "class=\"number\"";

/// A cell of a table; its content is HTML already.
struct Cell {
  std::string html;
  std::string attributes = "";
};

/// @return the text with a minus sign for every hyphen that stands before a number.
std::string withMinusSigns(std::string text);

/// A number's cell, aligned right.
Cell numberCell(const std::string& text);

/// A table that scrolls sideways by itself when the page is narrow; the first cell of a row is its
/// heading.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<Cell>>& rows,
                  const std::string& attributes = "");

// ---------------------------------------------------------------------------------------------
// The parts of the diagnosis page, as HTML; a part that has nothing to say is empty.

/// @return what the page's times count from [s]: 0, or the first sample of a clock that counts from
/// 1970.
double clockOrigin(const Series& series);

std::string plotsSection(const Recording& recording, const Diagnosis& diagnosis, bool zoomable);
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

/// @return the result that a page shows as JSON inside it, for a program that has the page alone;
/// an element that shows and runs nothing, of id "result".
std::string dataHtml(const nlohmann::json& result);

/// @return a whole document. @param title plain text. @param body, scripts HTML; scripts behind the
/// body, with what they need of style.
std::string pageOf(const std::string& title, const std::string& body,
                   const std::string& scripts = "", const std::string& style = "");

/// @return <section id><h2>title</h2>body</section>; empty when the body is.
std::string section(const std::string& id, const std::string& title, const std::string& body);

}  // namespace battery_sof
