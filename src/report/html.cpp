#include "html.hpp"

namespace battery_sof {
namespace {

constexpr char kNumber[] = "class=\"number\"";

/// Titles stand as the cells below them do.
std::string titleCell(const std::string& title, const std::vector<std::vector<Cell>>& rows,
                      std::size_t column) {
  const bool is_number = !rows.empty() && column < rows[0].size() &&
                         rows[0][column].attributes.find("\"number") != std::string::npos;
  return element("th", title, std::string("scope=\"col\" ") + (is_number ? kNumber : ""));
}

}  // namespace

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

std::string element(const std::string& name, const std::string& content,
                    const std::string& attributes) {
  return "<" + name + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + name +
         ">";
}

std::string withMinusSigns(std::string text) {
  for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 1)) {
    const bool leads = at == 0 || text[at - 1] == ' ';
    const bool is_sign =
        leads && at + 1 < text.size() && text[at + 1] >= '0' && text[at + 1] <= '9';
    if (is_sign) text.replace(at, 1, "\xe2\x88\x92");
  }
  return text;
}

Cell numberCell(const std::string& text) { return {escaped(withMinusSigns(text)), kNumber}; }

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<Cell>>& rows,
                  const std::string& attributes) {
  std::string titles, body;
  for (std::size_t k = 0; k < head.size(); ++k) titles += titleCell(head[k], rows, k);
  for (const auto& row : rows) {
    std::string cells;
    for (std::size_t k = 0; k < row.size(); ++k)
      cells += k == 0 ? element("th", row[k].html, "scope=\"row\" " + row[k].attributes)
                      : element("td", row[k].html, row[k].attributes);
    body += element("tr", cells) + "\n";
  }
  return element("div",
                 element("table",
                         element("thead", element("tr", titles)) + "\n" + element("tbody", body),
                         attributes),
                 "class=\"scroll\" tabindex=\"0\"") +
         "\n";
}

}  // namespace battery_sof
