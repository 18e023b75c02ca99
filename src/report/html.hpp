#pragma once

#include <string>
#include <vector>

namespace battery_sof {

/// @return text that represents itself between tags and inside quoted attributes.
std::string escaped(const std::string& text);

/// @return <name attributes>content</name>; content and attributes are HTML already.
std::string element(const std::string& name, const std::string& content,
                    const std::string& attributes = "");

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

}  // namespace battery_sof
