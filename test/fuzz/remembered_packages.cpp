#include <dlfcn.h>
#include <ros/package.h>

#include <map>
#include <stdexcept>
#include <utility>

// Whenever a bag is made rosbag looks for its plugins in all packages there are, some 40 ms each
// time. These stand before roslib's own and ask it once; the answer stays the same as long as a
// program runs.
namespace {

template <typename Function>
Function* next(const char* symbol) {
  void* const found = ::dlsym(RTLD_NEXT, symbol);
  if (found == nullptr) throw std::runtime_error(std::string("roslib has no ") + symbol);
  return reinterpret_cast<Function*>(found);
}

constexpr char kGetPath[] =
    "_ZN3ros7package7getPathERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE";
constexpr char kGetPlugins[] =
    "_ZN3ros7package10getPluginsERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEES8_"
    "RSt6vectorIS6_SaIS6_EEb";

}  // namespace

namespace ros::package {

std::string getPath(const std::string& package) {
  static std::map<std::string, std::string> known;
  const auto found = known.find(package);
  return found != known.end() ? found->second
                              : known[package] = next<decltype(getPath)>(kGetPath)(package);
}

void getPlugins(const std::string& package, const std::string& attribute, V_string& plugins,
                bool discrepancy_recrawl) {
  static std::map<std::pair<std::string, std::string>, V_string> known;
  const auto [found, is_new] = known.try_emplace({package, attribute});
  if (is_new)
    next<void(const std::string&, const std::string&, V_string&, bool)>(kGetPlugins)(
        package, attribute, found->second, discrepancy_recrawl);
  plugins = found->second;
}

}  // namespace ros::package
