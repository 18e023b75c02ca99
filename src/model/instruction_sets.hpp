#pragma once

// For sources that compile one hot function for every InstructionSet. Such a source holds plain
// code over arrays of doubles and no inline function of a library (Eigen, containers): compiled for
// AVX-512, its copy could be the one that the linker keeps for everyone.

#if defined(__x86_64__) && defined(__GNUC__)
#define BATTERY_SOF_X86_DISPATCH 1
#define BATTERY_SOF_TARGET_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma")))
#define BATTERY_SOF_TARGET_AVX2 __attribute__((target("avx2,fma")))
#else
#define BATTERY_SOF_X86_DISPATCH 0
#endif

/// The body must be compiled inside each of its callers, for that caller's instruction set.
#define BATTERY_SOF_INLINE inline __attribute__((always_inline))

namespace battery_sof {

/// kWidth doubles in one register, or in as many as the instruction set needs.
template <int kWidth>
struct Register {
  typedef double Type __attribute__((vector_size(kWidth * sizeof(double))));
  typedef Type InMemory __attribute__((may_alias));
};

/// The kWidth doubles at an address aligned to their size.
template <int kWidth>
BATTERY_SOF_INLINE typename Register<kWidth>::InMemory& at(double* values) {
  return *reinterpret_cast<typename Register<kWidth>::InMemory*>(values);
}

template <int kWidth>
BATTERY_SOF_INLINE const typename Register<kWidth>::InMemory& at(const double* values) {
  return *reinterpret_cast<const typename Register<kWidth>::InMemory*>(values);
}

}  // namespace battery_sof

#define BATTERY_SOF_LIST(...) __VA_ARGS__

/// Defines `void name(parameters, InstructionSet set)`: kernel<kWidth>(arguments) compiled for every
/// InstructionSet, with as many samples side by side as its registers hold.
#if BATTERY_SOF_X86_DISPATCH
#define BATTERY_SOF_DISPATCH(name, kernel, parameters, arguments)                             \
  BATTERY_SOF_TARGET_AVX2 static void name##Avx2 parameters { kernel<4> arguments; }          \
  BATTERY_SOF_TARGET_AVX512 static void name##Avx512 parameters { kernel<kLanes> arguments; } \
  void name(BATTERY_SOF_LIST parameters, InstructionSet set) {                                \
    if (set == InstructionSet::kAvx512) return name##Avx512 arguments;                        \
    if (set == InstructionSet::kAvx2) return name##Avx2 arguments;                            \
    kernel<2> arguments;                                                                      \
  }
#else
#define BATTERY_SOF_DISPATCH(name, kernel, parameters, arguments) \
  void name(BATTERY_SOF_LIST parameters, InstructionSet) { kernel<2> arguments; }
#endif
