#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace battery_sof_reference {

/**
 * @brief The program `draw_out_of_model --kind K --seed N --out REC.csv --label LABEL.json`.
 *
 * Draws a case whose physics has a form of its own, or none (docs/validation.md), and writes its
 * recording and its label, each whole or not at all. --mechanism, --form, --drive, --duration S and
 * --rate HZ hold what the seed would choose; --scale X is times the strength found; --list prints
 * kinds, mechanisms and forms, one "kind mechanism form" a line. The same options give the same
 * bytes.
 *
 * `draw_out_of_model --beside REC.csv --mechanism F --form X --strength S --out OUT.csv` puts a law
 * into a recording that was measured (besideRecording()); there is no label.
 *
 * @param arguments without the program's name.  @param out, err standard output and error.
 * @return 0 done, 1 no draw could be used, 2 wrong usage or input. Never throws.
 */
int runDrawOutOfModel(const std::vector<std::string>& arguments, std::ostream& out,
                      std::ostream& err);

}  // namespace battery_sof_reference
