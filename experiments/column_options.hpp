#pragma once

#include <CLI/CLI.hpp>

#include "battery_sof/csv.hpp"

namespace battery_sof {

/// Options for the columns of a CSV recording and the sign of its current, named as those of `sof`.
inline void addColumnOptions(CLI::App& app, CsvColumns& columns) {
  app.add_option("--time-column", columns.time);
  app.add_option("--current-column", columns.current);
  app.add_option("--voltage-column", columns.voltage);
  app.add_flag("--discharge-positive", columns.discharge_positive);
}

}  // namespace battery_sof
