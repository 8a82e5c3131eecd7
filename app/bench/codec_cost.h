#pragma once

#include <string>
#include <vector>

#include "core/time.h"

namespace tribus::bench {

/// Processor time of a codec for one snapshot of all channels.
struct CodecCost {
    std::string protocol;
    double encode_ns = 0;
    double decode_ns = 0;
};

/// Measures each protocol of the registry with default settings (DBC: 16 channels in four
/// messages). Takes `length` in total and reports the best of several runs.
std::vector<CodecCost> measure_codecs(Duration length);

}  // namespace tribus::bench
