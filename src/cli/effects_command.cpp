#include "command.hpp"
#include "report/catalogue.hpp"

namespace battery_sof {
namespace {

struct EffectsArguments {
  std::string id;
  bool markdown = false;
  std::string json;
};

int runEffects(const CommandLine& line, const EffectsArguments& arguments) {
  const bool all = arguments.id.empty();
  const std::vector<EffectInfo> effects =
      all ? effectsByTier() : std::vector<EffectInfo>{effectInfo(arguments.id)};
  std::string text = all ? catalogueText(effects) : effectText(effects.front());
  if (arguments.markdown) text = catalogueMarkdown(effects);
  emit(line, text, catalogueJson(effects), arguments.json);
  return kExitDone;
}

}  // namespace

void addEffectsCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command = app.add_subcommand(
      "effects", "the physics that sof identify --effects can add: all of it, or one in full");
  auto arguments = std::make_shared<EffectsArguments>();
  command->add_option("ID", arguments->id, "an effect; without it a table of all");
  command->add_flag("--markdown", arguments->markdown, "print as docs/effects.md holds it");
  addJsonOption(*command, arguments->json);
  whenChosen(*command, line, arguments, runEffects);
}

}  // namespace battery_sof
