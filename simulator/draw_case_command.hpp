#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace battery_sof_reference {

/**
 * @brief The program `draw_case --family F [--id ID] --seed N --out REC.csv --label LABEL.json`.
 *
 * Draws a case for a diagnosis, with --duration S (1200, of absent 2400) and --rate HZ (100), and
 * writes its recording (.csv or .bag) and its label, each whole or not at all; --scale X[,Y] is
 * times the strength of what is added, --quiet leaves noise and quantisation out; --list prints
 * families and ids, one "family id" a line. The same options give the same bytes.
 *
 * @param arguments without the program's name.  @param out, err standard output and error.
 * @return 0 done, 1 the battery's equations have no solution on this drive, 2 wrong usage or input.
 * Never throws.
 */
int runDrawCase(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace battery_sof_reference
