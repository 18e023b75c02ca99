#include <cstdint>

// Stand in for libFuzzer's, see CMakeLists.txt. Their names are the linker's.
extern "C" {
__attribute__((no_sanitize("all"))) void __wrap___sanitizer_cov_trace_cmp8(std::uint64_t,
                                                                           std::uint64_t) {}
__attribute__((no_sanitize("all"))) void __wrap___sanitizer_cov_trace_const_cmp8(std::uint64_t,
                                                                                 std::uint64_t) {}
}
