#include "ros/node_options.hpp"

#include <functional>
#include <map>

#include "recording/series_blocks.hpp"
#include "report/model_yaml.hpp"
#include "report/priors_yaml.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

using Value = XmlRpc::XmlRpcValue;
using Faults = std::vector<std::string>;

constexpr double kMinBoost = 1.0;  // [V]

std::string typeName(const Value& value) {
  switch (value.getType()) {
    case Value::TypeBoolean: return "a boolean";
    case Value::TypeInt: return "an integer";
    case Value::TypeDouble: return "a number";
    case Value::TypeString: return "a string";
    case Value::TypeArray: return "a list";
    case Value::TypeStruct: return "a map";
    default: return "of another type";
  }
}

std::string shown(double value) { return format("%g", value); }

/// Parameters of 0.2, and what became of them.
const std::map<std::string, std::string> kOld = {
    {"blocks", "series_blocks since 0.3"},
    {"adopt_diagnosis", "use_diagnosis since 0.3"},
    {"min_suitability", "min_window_quality since 0.3"},
    {"crank_weight_current_a", "~crank_current_a since 0.3, one value for all of a crank"},
    {"model_max_age_s", "gone since 0.3: intervals say how old a model is"}};

/// The keys of one map of parameters, each with what takes its value.
class Schema {
 public:
  using Reader = std::function<void(Value&, const std::string& name, Faults&)>;

  void number(const std::string& key, double lower, double upper,
              const std::function<void(double)>& store) {
    readers_[key] = [=](Value& value, const std::string& name, Faults& faults) {
      const bool integer = value.getType() == Value::TypeInt;
      if (!integer && value.getType() != Value::TypeDouble)
        return faults.push_back(name + " is " + typeName(value) + ", expected a number");
      const double number = integer ? static_cast<int&>(value) : static_cast<double&>(value);
      if (number >= lower && number <= upper) return store(number);
      faults.push_back(name + " is " + shown(number) + ", expected " + shown(lower) + " to " +
                       shown(upper));
    };
  }
  void number(const std::string& key, double lower, double upper, double& target) {
    number(key, lower, upper, [&target](double value) { target = value; });
  }

  void flag(const std::string& key, bool& target) {
    readers_[key] = [&target](Value& value, const std::string& name, Faults& faults) {
      if (value.getType() != Value::TypeBoolean)
        return faults.push_back(name + " is " + typeName(value) + ", expected true or false");
      target = static_cast<bool&>(value);
    };
  }

  /// @param store returns what is wrong with a text; empty when it takes it.
  void text(const std::string& key, const std::function<std::string(const std::string&)>& store) {
    readers_[key] = [=](Value& value, const std::string& name, Faults& faults) {
      if (value.getType() != Value::TypeString)
        return faults.push_back(name + " is " + typeName(value) + ", expected a string");
      const std::string fault = store(static_cast<std::string&>(value));
      if (!fault.empty()) faults.push_back(name + " " + fault);
    };
  }
  void text(const std::string& key, std::string& target) {
    text(key, [&target](const std::string& text) { return target = text, std::string(); });
  }

  void map(const std::string& key, const Schema& schema) {
    readers_[key] = [=](Value& value, const std::string& name, Faults& faults) {
      schema.read(value, name + "/", faults);
    };
  }

  void read(Value& values, const std::string& prefix, Faults& faults) const {
    if (!values.valid()) return;
    if (values.getType() != Value::TypeStruct)
      return faults.push_back(prefix + " is " + typeName(values) + ", expected a map");
    for (auto& [key, value] : values) {
      const auto reader = readers_.find(key);
      const auto old = kOld.find(key);
      if (reader != readers_.end())
        reader->second(value, prefix + key, faults);
      else
        faults.push_back(prefix + key + " is " +
                         (old != kOld.end() ? old->second : "unknown; known are " + known()));
    }
  }

 private:
  std::string known() const {
    std::vector<std::string> keys;
    for (const auto& entry : readers_) keys.push_back(entry.first);
    return join(keys);
  }

  std::map<std::string, Reader> readers_;
};

Schema standingQuerySchema(StandingQueries& standing) {
  CrankingQuery& query = standing.cranking;
  ChargeAcceptanceQuery& charge = standing.charge;
  Schema schema;
  schema.number("i_load_a", -500.0, 0.0, query.i_load);
  schema.number("t_stop_s", 0.0, 86400.0, query.t_stop);
  schema.number("i_cranking_a", -2000.0, -1.0, query.i_cranking);
  schema.number("t_cranking_s", 0.01, 60.0, query.t_cranking);
  schema.number("u_required_v", 0.0, 100.0,
                [&query](double value) { query.u_required = askedFor(value); });
  schema.number("u_boost_v", 0.0, 100.0, [&standing](double value) {
    standing.u_boost_is_given = askedFor(value).has_value();
    if (standing.u_boost_is_given) standing.charge.u_boost = value;
  });
  schema.number("t_sof2_s", 0.1, 3600.0, charge.t_sof2);
  schema.number("i_limit_a", 1.0, 5000.0, charge.i_limit);
  return schema;
}

Schema fitSchema(IdentifyOptions& fit) {
  Schema schema;
  schema.text("start", [&fit](const std::string& start) -> std::string {
    if (start != "robust" && start != "paper")
      return "is '" + start + "', expected robust or paper";
    fit.start = start == "paper" ? FitStart::kPaper : FitStart::kRobust;
    return {};
  });
  schema.number("crank_weight", 1.0, 1000.0, fit.crank_weight);
  schema.number("max_iterations", 1.0, 1000.0,
                [&fit](double value) { fit.max_iterations = static_cast<int>(value); });
  return schema;
}

/// What actionlib reads below an action's name: the server does, the node has nothing to take.
Schema actionlibSchema() {
  Schema schema;
  for (const char* key : {"status_list_timeout", "status_frequency", "actionlib_status_frequency",
                          "actionlib_server_pub_queue_size", "actionlib_server_sub_queue_size"})
    schema.number(key, 0.0, 1e6, [](double) {});
  return schema;
}

Schema schemaOf(NodeOptions& options) {
  SessionOptions& session = options.session;
  Schema schema;
  schema.number("buffer_s", 60.0, 14400.0, session.buffer);
  schema.number("window_s", 0.0, 14400.0, [&session](double value) {
    if (value > 0.0) session.window_length = value;
  });
  schema.number("min_window_quality", 0.0, 1.0, session.min_window_quality);
  schema.number("identify_period_s", 10.0, 86400.0, session.identify_period);
  schema.number("retry_period_s", 10.0, 86400.0, session.retry_period);
  schema.number("capacity_ah", 1.0, 1000.0,
                [&options](double value) { options.session.capacity = value; });
  schema.text("battery_name", options.battery_name);
  schema.number("series_blocks", kMinSeriesBlocks, kMaxSeriesBlocks, session.series_blocks);
  schema.number("crank_current_a", -2000.0, -1.0, [&session](double value) {
    session.events.crank_current = session.identify.crank_current = value;
  });
  schema.map("standing_query", standingQuerySchema(options.standing));
  schema.map("fit", fitSchema(session.identify));
  schema.number("diagnostic_period", 0.0, 86400.0, options.diagnostic_period);
  // actionlib searches for it upwards
  schema.number("actionlib_status_frequency", 0.0, 1e6, [](double) {});
  schema.map("identify", actionlibSchema());
  schema.map("diagnose", actionlibSchema());
  schema.number("diagnose_period_s", 0.0, 86400.0, options.diagnose_period);
  schema.number("change_period_s", 0.0, 86400.0, options.change_period);
  schema.flag("use_diagnosis", options.use_diagnosis);
  schema.text("state_file", options.state_file);
  schema.text("priors", options.priors);
  schema.text("vehicle_type", options.vehicle_type);
  return schema;
}

/// The defaults, those in volts of as many blocks as are asked for.
NodeOptions defaultsFor(Value& parameters) {
  NodeOptions given, options;
  Faults reported_later;
  schemaOf(given).read(parameters, "~", reported_later);
  *options.standing.cranking.u_required *= given.session.series_blocks;
  options.standing.charge.u_boost *= given.session.series_blocks;
  return options;
}

void findContradictions(const NodeOptions& options, Faults& faults) {
  const SessionOptions& session = options.session;
  const auto require = [&faults](bool holds, const std::string& name, const std::string& found,
                                 const std::string& expected) {
    if (!holds) faults.push_back("~" + name + " is " + found + ", expected " + expected);
  };
  const double window = session.window_length.value_or(0.0), blocks = session.series_blocks,
               u_boost = options.standing.charge.u_boost, period = options.diagnose_period;
  require(areSeriesBlocks(blocks), "series_blocks", shown(blocks), kAllowedSeriesBlocks);
  require(!session.window_length || window >= 60.0, "window_s", shown(window),
          "0 (automatic) or 60 to 14400");
  require(u_boost >= kMinBoost, "standing_query/u_boost_v", shown(u_boost),
          "0 (at which the battery was charged lately) or " + shown(kMinBoost) + " to 100");
  require(!(period > 0.0 && period < 60.0), "diagnose_period_s", shown(period),
          "0 (only on request) or 60 to 86400");
  const double change_period = options.change_period;
  require(!(change_period > 0.0 && change_period < 60.0), "change_period_s", shown(change_period),
          "0 (never) or 60 to 86400");
  require(!options.use_diagnosis || session.identify.start != FitStart::kPaper, "use_diagnosis",
          "true and ~fit/start paper", "robust: effects are not fitted otherwise");
  require(window <= session.buffer, "window_s", shown(window),
          "at most ~buffer_s, which is " + shown(session.buffer));
  require(options.vehicle_type.empty() || !options.priors.empty(), "vehicle_type",
          "'" + options.vehicle_type + "'", "only with ~priors, a file with such types");
}

void readPriors(NodeOptions& options, Faults& faults) {
  if (options.priors.empty()) return;
  try {
    options.session.identify.priors = readPriorsFile(options.priors, options.vehicle_type);
  } catch (const ModelFileError& error) {
    faults.push_back(std::string("~priors: ") + error.what());
  }
}

}  // namespace

StopTimeQuery StandingQueries::stopTime() const {
  return {cranking.i_load, cranking.i_cranking, cranking.t_cranking,
          cranking.u_required.value_or(0.0)};
}

ChargeAcceptanceQuery StandingQueries::chargeAt(const std::optional<double>& lately) const {
  ChargeAcceptanceQuery query = charge;
  if (!u_boost_is_given && lately) query.u_boost = *lately;
  return query;
}

NodeOptionsError::NodeOptionsError(const std::vector<std::string>& faults)
    : std::runtime_error(join(faults, "\n")) {}

NodeOptions parseNodeOptions(XmlRpc::XmlRpcValue parameters) {
  NodeOptions options = defaultsFor(parameters);
  Faults faults;
  schemaOf(options).read(parameters, "~", faults);
  findContradictions(options, faults);
  readPriors(options, faults);
  if (!faults.empty()) throw NodeOptionsError(faults);
  return options;
}

}  // namespace battery_sof
