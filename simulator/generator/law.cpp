#include "simulator/generator/law.hpp"

#include <stdexcept>

namespace battery_sof_simulator {

const std::vector<LawForm>& lawForms() {
  static const std::vector<LawForm> all = [] {
    std::vector<LawForm> forms = chemistryLaws();
    for (const LawForm& form : circuitLaws()) forms.push_back(form);
    return forms;
  }();
  return all;
}

const LawForm& lawNamed(const std::string& mechanism, const std::string& id) {
  for (const LawForm& form : lawForms())
    if (form.mechanism == mechanism && form.id == id) return form;
  throw std::invalid_argument("no law is \"" + mechanism + " " + id +
                              "\"; --list names what there is");
}

}  // namespace battery_sof_simulator
