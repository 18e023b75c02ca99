# Builds everything with AddressSanitizer and UndefinedBehaviorSanitizer, and with assertions. BATTERY_SOF_FUZZ adds what
# libFuzzer needs, and the programs of test/fuzz. A fault ends the program. BATTERY_SOF_SANITIZE_THREADS has ThreadSanitizer in their
# place, for what threads share alone (below).
option(BATTERY_SOF_SANITIZE "Build with the address and undefined-behaviour sanitizers" OFF)
option(BATTERY_SOF_SANITIZE_THREADS "Build with the thread sanitizer, which goes with none of the others" OFF)
option(BATTERY_SOF_FUZZ "Build the fuzz targets of test/fuzz and, with the sanitizers, all they call; needs clang and BATTERY_SOF_ROS=OFF" OFF)
if(BATTERY_SOF_FUZZ AND NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "BATTERY_SOF_FUZZ is ON and the compiler is ${CMAKE_CXX_COMPILER_ID}, expected clang (-DCMAKE_CXX_COMPILER=clang++)")
endif()
if(BATTERY_SOF_FUZZ AND BATTERY_SOF_ROS)
  message(FATAL_ERROR "BATTERY_SOF_FUZZ is ON and BATTERY_SOF_ROS too, expected -DBATTERY_SOF_ROS=OFF")
endif()
if(BATTERY_SOF_SANITIZE_THREADS AND (BATTERY_SOF_SANITIZE OR BATTERY_SOF_FUZZ))
  message(FATAL_ERROR "BATTERY_SOF_SANITIZE_THREADS is ON, expected BATTERY_SOF_SANITIZE and BATTERY_SOF_FUZZ to be OFF")
endif()
if(BATTERY_SOF_SANITIZE OR BATTERY_SOF_FUZZ)
  set(sanitizers -fsanitize=address,undefined -fno-sanitize-recover=all)
  add_compile_options(-O2 -g1 -fno-omit-frame-pointer -UNDEBUG ${sanitizers})
  add_link_options(${sanitizers})
endif()
# Model, fits and diagnosis are functions of values that a thread has to itself, and would take twenty times as long: the node would not
# keep up with its samples. ROS is as it is installed.
if(BATTERY_SOF_SANITIZE_THREADS)
  file(GLOB shared_sources CONFIGURE_DEPENDS
    src/recording/*.cpp src/state/*.cpp src/prediction/*.cpp src/estimation/parallel.cpp src/bag/*.cpp src/ros/*.cpp)
  # The sanitizer does not follow fences; tasks of a Boost pool are ordered by its mutex, too.
  set(thread_sanitizer -g1 -fno-omit-frame-pointer -fsanitize=thread -DBOOST_ASIO_DISABLE_FENCED_BLOCK)
  set_property(SOURCE ${shared_sources} APPEND PROPERTY COMPILE_OPTIONS ${thread_sanitizer})
  set_property(SOURCE ${shared_sources} PROPERTY SKIP_PRECOMPILE_HEADERS ON)  # read without these options
  add_link_options(-fsanitize=thread)
endif()
if(BATTERY_SOF_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
