#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace battery_sof_simulator {

/// The program `draw_scenario --kind K [--mechanism M] [--id ID] --seed N --out REC.csv --label
/// LABEL.json`.
///
/// Draws a scenario with known truth (docs/validation.md) and writes its recording (.csv or .bag)
/// and its label, each whole or not at all. The same options give the same bytes.
///
/// `draw_scenario --into REC.csv --mechanism M --id ID --strength S --out OUT.csv` puts a law into
/// a recording that was measured (injected()); there is no label. `--cause ID=S` in place of the law
/// puts in the difference that a cause makes of a porous block (withDifference()).
/// @param arguments without the program's name.  @param out, err standard output and error.
/// @return 0 done, 1 no draw could be used or equations have no solution, 2 wrong usage or input.
int runDrawScenario(const std::vector<std::string>& arguments, std::ostream& out,
                    std::ostream& err);

}  // namespace battery_sof_simulator
