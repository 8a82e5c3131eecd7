#pragma once

#include <string>

#include <tl/expected.hpp>

/// The cost of a frame in the whole program.
namespace tribus::bench {

/// User instructions a frame of all threads of `tribus run`, counted by callgrind: i.Bus with 18
/// channels through a map to SBUS, 7.7 ms a frame. Takes 20 s. The error says what went wrong.
tl::expected<double, std::string> instructions_a_frame();

}  // namespace tribus::bench
