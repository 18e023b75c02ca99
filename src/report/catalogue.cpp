#include "report/results.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "descriptions.hpp"
#include "model/mechanism.hpp"

#include "util/text.hpp"

namespace battery_sof {
namespace {

std::string number(double value) { return format("%.4g", value); }

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text + "  ";
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// "1" is the unit of numbers without one.
std::string withUnit(const std::string& value, const std::string& unit) {
  return unit == "1" ? value : value + " " + unit;
}

/// What a fit does with a parameter, in words.
std::vector<std::string> rolesOf(const ParameterInfo& info) {
  std::vector<std::string> roles = {info.held ? "held" : "free"};
  if (info.logarithmic) roles.push_back("searched as a logarithm");
  if (info.linear) roles.push_back("linear");
  if (info.vanishes_at) roles.push_back("no effect at " + number(*info.vanishes_at));
  if (info.prior_std)
    roles.push_back(info.logarithmic
                        ? "known to a factor of " + number(std::exp(*info.prior_std))
                        : "known to +- " + withUnit(number(*info.prior_std), info.unit));
  return roles;
}

std::string beginningOf(const StateInfo& info) {
  if (info.begins_as_u_c2) return "begins at u_c2";
  const std::string rest = withUnit(number(info.rest), info.unit);
  if (!info.initial_std) return "begins at rest, " + rest;
  return "estimated where a recording begins, " + rest + " +- " +
         withUnit(number(*info.initial_std), info.unit) + " inside " + number(info.lower) + " to " +
         withUnit(number(info.upper), info.unit);
}

/// States that are alike but for their number, as one.
std::vector<std::pair<std::string, StateInfo>> namedStates(const EffectInfo& effect) {
  std::vector<std::pair<std::string, StateInfo>> named;
  for (const StateInfo& state : effect.states)
    if (!state.begins_as_u_c2) named.emplace_back(state.name, state);
  const auto part = std::find_if(effect.states.begin(), effect.states.end(),
                                 [](const StateInfo& state) { return state.begins_as_u_c2; });
  if (part != effect.states.end())
    named.emplace_back(part->name + " to " + effect.states.back().name, *part);
  return named;
}

nlohmann::json mechanismsJson() {
  nlohmann::json list = nlohmann::json::array();
  for (const Mechanism mechanism : kAllMechanisms)
    list.push_back({{"id", mechanismId(mechanism)},
                    {"sentence", mechanismSentence(mechanism)},
                    {"members", namesOf(mechanism)}});
  return list;
}

std::string code(const std::string& text) { return "`" + text + "`"; }

std::string codes(const std::vector<std::string>& names) {
  std::vector<std::string> marked;
  for (const std::string& name : names) marked.push_back(code(name));
  return join(marked);
}

/// Sections of docs/physics.md as links of a page in the same folder.
std::string linked(const std::string& source) {
  static const std::string docs = "docs/", page = "physics.md#";
  std::string text;
  std::size_t done = 0;
  for (std::size_t found; (found = source.find(docs + page, done)) != std::string::npos;) {
    const std::size_t name = found + docs.size() + page.size();
    const std::size_t end = std::min(
        source.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_", name), source.size());
    text += source.substr(done, found - done);
    const std::string section = source.substr(name, end - name);
    text += section.empty() ? docs + page : "[" + section + "](" + page + section + ")";
    done = end;
  }
  return text + source.substr(done);
}

std::string effectMarkdown(const EffectInfo& effect) {
  std::string text = "### " + effect.code + " " + code(effect.id) + ": " + effect.title + "\n\n";
  for (const std::string& line : linesOf(effect.equations)) text += "    " + line + "\n";
  text += "\n| parameter | symbol | unit | magnitude | bounds | in a fit | source |\n";
  text += "|---|---|---|---|---|---|---|\n";
  for (const ParameterInfo& info : effect.parameters)
    text += "| " + code(info.name) + " | " + info.symbol + " | " + info.unit + " | " +
            number(info.magnitude) + " | " + number(info.lower) + " to " + number(info.upper) +
            " | " + join(rolesOf(info)) + " | " + linked(info.source) + " |\n";
  text += "\n";
  for (const auto& [name, state] : namedStates(effect))
    text += "- State " + code(name) + " [" + state.unit + "] " + beginningOf(state) + ".\n";
  if (!effect.needs.empty()) text += "- Needs " + codes(effect.needs) + ".\n";
  if (!effect.is_nonlinear.empty())
    text += "- With it the voltage is no longer linear in " + codes(effect.is_nonlinear) + ".\n";
  text += "- Often confused with " + codes(effect.look_alikes) + ".\n";
  return text + "- Distinguished by: " + effect.distinguished_by + ".\n\n";
}

}  // namespace

DESCRIBED(ParameterInfo, MEMBERS("", name, symbol, unit, magnitude, lower, upper, source, held),
          MEMBERS("", logarithmic, linear, prior_std, vanishes_at))

DESCRIBED(StateInfo, MEMBERS("", name, unit, rest, initial_std, begins_as_u_c2))

DESCRIBED(EffectInfo, MEMBERS("", id, code, title, parameters, states, look_alikes, needs),
          MEMBERS("", is_nonlinear), visit("mechanism", mechanismId(mechanismOf(of.id))),
          visit("equations", linesOf(of.equations)), visit("tells_apart", of.distinguished_by))

std::vector<EffectInfo> effectsByTier() {
  std::vector<EffectInfo> effects = effectCatalogue();
  const auto rank = [](const EffectInfo& effect) {
    return std::pair(std::string("SPI").find(effect.tier()), std::stoi(effect.code.substr(1)));
  };
  std::stable_sort(effects.begin(), effects.end(),
                   [&](const EffectInfo& a, const EffectInfo& b) { return rank(a) < rank(b); });
  return effects;
}

std::string catalogueText(const std::vector<EffectInfo>& effects) {
  std::size_t width = 2, mechanism_width = 6;
  for (const EffectInfo& effect : effects) width = std::max(width, effect.id.size());
  for (const Mechanism mechanism : kAllMechanisms)
    mechanism_width = std::max(mechanism_width, mechanismId(mechanism).size());
  std::string text =
      padded("id", width) + padded("code", 4) + padded("mechanism", mechanism_width) + "title\n";
  for (const EffectInfo& effect : effects)
    text += padded(effect.id, width) + padded(effect.code, 4) +
            padded(mechanismId(mechanismOf(effect.id)), mechanism_width) + effect.title + "\n";
  return text;
}

std::string effectText(const EffectInfo& effect) {
  std::string text = effect.id + " (" + effect.code + "): " + effect.title + "\n\nmechanism\n    " +
                     mechanismId(mechanismOf(effect.id)) + ": " +
                     mechanismSentence(mechanismOf(effect.id)) + "\n\nequations\n";
  for (const std::string& line : linesOf(effect.equations)) text += "    " + line + "\n";
  text += "\nparameters\n";
  std::size_t width = 0;
  for (const ParameterInfo& info : effect.parameters) width = std::max(width, info.name.size());
  for (const ParameterInfo& info : effect.parameters) {
    text += "    " + padded(info.name, width) + padded(info.symbol, 9) +
            padded(withUnit(number(info.magnitude), info.unit), 14) + "inside " +
            number(info.lower) + " to " + number(info.upper) + "\n";
    text += "    " + padded("", width) + join(rolesOf(info)) + " (" + info.source + ")\n";
  }
  if (!effect.states.empty()) text += "\nstates\n";
  for (const auto& [name, state] : namedStates(effect))
    text += "    " + name + " [" + state.unit + "], " + beginningOf(state) + "\n";
  text += "\nconfused with  " + join(effect.look_alikes) + "\n";
  text += "distinguish by " + effect.distinguished_by + "\n";
  if (!effect.needs.empty()) text += "needs          " + join(effect.needs) + "\n";
  if (!effect.is_nonlinear.empty()) text += "nonlinear in   " + join(effect.is_nonlinear) + "\n";
  return text;
}

nlohmann::json catalogueJson(const std::vector<EffectInfo>& effects) {
  return {{"schema", "battery_sof/effects/1"},
          {"effects", jsonOf(effects)},
          {"mechanisms", mechanismsJson()}};
}

std::string catalogueMarkdown(const std::vector<EffectInfo>& effects) {
  std::string text = "| id | code | mechanism | title |\n|---|---|---|---|\n";
  for (const EffectInfo& effect : effects)
    text += "| " + code(effect.id) + " | " + effect.code + " | " +
            code(mechanismId(mechanismOf(effect.id))) + " | " + effect.title + " |\n";
  text += "\n";
  for (const EffectInfo& effect : effects) text += effectMarkdown(effect);
  return text;
}

}  // namespace battery_sof
