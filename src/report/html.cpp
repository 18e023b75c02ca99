#include "html.hpp"

namespace battery_sof {

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default: safe += c;
    }
  }
  return safe;
}

std::string element(const std::string& name, const std::string& content, const std::string& attributes) {
  return "<" + name + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + name + ">";
}

Cell numberCell(const std::string& text) { return {escaped(text), "class=\"number\""}; }

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<Cell>>& rows,
                  const std::string& attributes) {
  std::string titles, body;
  for (const std::string& title : head) titles += element("th", title, "scope=\"col\"");
  for (const auto& row : rows) {
    std::string cells;
    for (std::size_t k = 0; k < row.size(); ++k)
      cells += k == 0 ? element("th", row[k].html, "scope=\"row\" " + row[k].attributes)
                      : element("td", row[k].html, row[k].attributes);
    body += element("tr", cells) + "\n";
  }
  return element("div",
                 element("table", element("thead", element("tr", titles)) + "\n" + element("tbody", body), attributes),
                 "class=\"scroll\" tabindex=\"0\"") + "\n";
}

}  // namespace battery_sof
