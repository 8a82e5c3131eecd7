#pragma once

#include <string>
#include <vector>

#include "core/time.h"

namespace tribus::bench {

/// Processor time of one protocol's codec for a whole snapshot of the channels.
struct CodecCost {
    std::string protocol;
    double encode_ns = 0;
    double decode_ns = 0;
};

/// Every protocol of the registry, with its default settings (DBC: 16 channels in four messages),
/// the best of several runs that take `length` in all.
std::vector<CodecCost> measure_codecs(Duration length);

}  // namespace tribus::bench
